//! Elements: the triangles of a leaf, with a quadratic function over each, and what samples ask of it.
//!
//! A function has six nodes, at the corners and in the middles of the sides; triangles that share a side share its nodes, wherever light is
//! continuous there ([`super::super::field`]). A little smoothing is asked of each: that a middle be the mean of its ends, as
//! if so many samples had said so; where real ones are many it does not count.

use glam::DVec2;

use super::sample::Sample;
use crate::scene::Rgb;

/// Nodes of a quadratic function over a triangle.
pub(super) const NODES: usize = 6;
/// So many samples' worth is asked of each middle to lie between its ends.
pub(super) const SMOOTHING: f64 = 100.0;
/// The same of ends to be alike, as a share of it.
const EVENNESS: f64 = 0.05;

/// A triangle of a leaf, in the frame of its face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    /// Numbers of its nodes: corners, then middles from each corner to the next.
    pub(super) nodes: [u32; NODES],
    /// The first two barycentric coordinates, as linear functions of the place.
    linear: [[f64; 3]; 2],
}

impl Element {
    pub(super) fn new([a, b, c]: [DVec2; 3]) -> Self {
        let doubled = (b - a).perp_dot(c - a);
        let over_side = |p: DVec2, q: DVec2| {
            let side = q - p;
            [-side.y / doubled, side.x / doubled, (side.y * p.x - side.x * p.y) / doubled]
        };
        Self { nodes: [0; NODES], linear: [over_side(b, c), over_side(c, a)] }
    }

    /// Barycentric coordinates of a place.
    pub(super) fn coordinates(&self, at: DVec2) -> [f64; 3] {
        let [p, q] = self.linear.map(|[x, y, one]| x * at.x + y * at.y + one);
        [p, q, 1.0 - p - q]
    }

    /// The values of the six nodes' functions at barycentric coordinates.
    pub(super) fn weights([p, q, r]: [f64; 3]) -> [f64; NODES] {
        [p * (2.0 * p - 1.0), q * (2.0 * q - 1.0), r * (2.0 * r - 1.0), 4.0 * p * q, 4.0 * q * r, 4.0 * r * p]
    }

    /// The value there, where the nodes have these values.
    pub(super) fn value(&self, coordinates: [f64; 3], values: &[Rgb]) -> Rgb {
        let weights = Self::weights(coordinates);
        self.nodes.iter().zip(weights).map(|(&node, weight)| weight * values[node as usize]).sum()
    }
}

/// The element that a place lies in, or beside, and its barycentric coordinates there.
pub(super) fn element_at(elements: &[Element], at: DVec2) -> Option<(usize, [f64; 3])> {
    let least = |coordinates: &[f64; 3]| coordinates.iter().copied().fold(f64::INFINITY, f64::min);
    let mut nearest: Option<(usize, [f64; 3])> = None;
    for (number, element) in elements.iter().enumerate() {
        let coordinates = element.coordinates(at);
        if least(&coordinates) >= 0.0 {
            return Some((number, coordinates));
        }
        // A triangle without area has no coordinates.
        let is_nearer = nearest.as_ref().is_none_or(|(_, known)| least(&coordinates) > least(known));
        if coordinates.iter().all(|coordinate| coordinate.is_finite()) && is_nearer {
            nearest = Some((number, coordinates));
        }
    }
    nearest
}

/// The normal equations of an element.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ElementEquations {
    /// Sums of products of the nodes' functions over the samples.
    pub(super) products: [[f32; NODES]; NODES],
    /// Sums of their products with the light.
    pub(super) light: [Rgb; NODES],
}

/// The normal equations of the elements of a leaf, from the light of samples less what `class_light` tells of their directions.
pub(super) fn equations(
    elements: &[Element],
    samples: &[Sample],
    class_light: impl Fn(&Sample) -> Rgb,
) -> Vec<ElementEquations> {
    let mut products = vec![[[0.0_f64; NODES]; NODES]; elements.len()];
    let mut light = vec![[Rgb::ZERO; NODES]; elements.len()];
    for sample in samples {
        let Some((number, coordinates)) = element_at(elements, sample.at()) else { continue };
        let weights = Element::weights(coordinates);
        let value = sample.light.as_dvec3() - class_light(sample);
        for i in 0..NODES {
            for j in i..NODES {
                products[number][i][j] += weights[i] * weights[j];
            }
            light[number][i] += weights[i] * value;
        }
    }
    products.iter().zip(light).map(|(products, light)| finished(products, light)).collect()
}

/// With smoothing, and both halves of the matrix.
fn finished(upper: &[[f64; NODES]; NODES], light: [Rgb; NODES]) -> ElementEquations {
    let mut products: [[f64; NODES]; NODES] =
        std::array::from_fn(|i| std::array::from_fn(|j| if i <= j { upper[i][j] } else { upper[j][i] }));
    for side in 0..3 {
        let [one, other, middle] = [side, (side + 1) % 3, 3 + side];
        let mut ask = |weight: f64, of: &[(usize, f64)]| {
            for &(i, a) in of {
                for &(j, b) in of {
                    products[i][j] += weight * a * b;
                }
            }
        };
        ask(SMOOTHING, &[(one, -0.5), (other, -0.5), (middle, 1.0)]);
        ask(EVENNESS * SMOOTHING, &[(one, 1.0), (other, -1.0)]);
    }
    ElementEquations { products: products.map(|row| row.map(|product| product as f32)), light }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_functions_are_one_at_their_node_and_sum_to_one() {
        let at_nodes =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]];
        for (node, at) in at_nodes.into_iter().enumerate() {
            let weights = Element::weights(at);
            assert!((0..NODES).all(|i| (weights[i] - f64::from(u8::from(i == node))).abs() < 1e-15));
        }
        assert!((Element::weights([0.2, 0.5, 0.3]).iter().sum::<f64>() - 1.0).abs() < 1e-15);
        let corners = [DVec2::new(1.0, 2.0), DVec2::new(4.0, 1.0), DVec2::new(2.0, 5.0)];
        let element = Element::new(corners);
        let at = 0.2 * corners[0] + 0.5 * corners[1] + 0.3 * corners[2];
        let found = element.coordinates(at);
        assert!([0.2, 0.5, 0.3].iter().zip(found).all(|(truth, found)| (truth - found).abs() < 1e-12), "{found:?}");
    }
}
