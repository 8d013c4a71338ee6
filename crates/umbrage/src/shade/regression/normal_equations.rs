//! Solves the normal equations, sheet by sheet: elements that share nodes, directly or through others, are one sheet.
//!
//! Only sheets with a change are solved again. A small one is solved by Cholesky's factors, a large one by conjugate gradients from the
//! values that were there (Hestenes and Stiefel, 1952; scaled by the diagonal), in `f32`: what that errs is far below the noise of the
//! samples. Sums run in the order of the elements, whatever the threads.

use rayon::prelude::*;

use super::element::{ElementEquations, NODES};
use crate::geometry::disjoint_sets::DisjointSets;
use crate::scene::Rgb;

/// A sheet with no more nodes is solved by its factors.
const FEW_NODES: usize = 48;
/// Added to the diagonal, as a share of it, for nodes that no sample tells of.
const REGULAR: f64 = 1e-9;
/// Conjugate gradients take no more steps.
const MAX_STEPS: usize = 300;

/// An element's part of the equations.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<'a> {
    pub(super) nodes: [u32; NODES],
    pub(super) equations: &'a ElementEquations,
    /// Whether they are not those of the last solution.
    pub(super) changed: bool,
}

/// Renews the values of the nodes of all sheets with a change, to this relative residual (squared).
pub(super) fn solve(parts: &[Part<'_>], values: &mut [Rgb], max_residual: f64) {
    let mut sheets = DisjointSets::new(values.len());
    for part in parts {
        part.nodes[1..].iter().for_each(|&node| sheets.join(part.nodes[0] as usize, node as usize));
    }
    // Elements of each sheet, the sheets in the order of their first elements.
    let mut number_of = vec![u32::MAX; values.len()];
    let mut members: Vec<(Vec<u32>, bool)> = Vec::new();
    for (index, part) in parts.iter().enumerate() {
        let root = sheets.first_of(part.nodes[0] as usize);
        if number_of[root] == u32::MAX {
            number_of[root] = members.len() as u32;
            members.push((Vec::new(), false));
        }
        let (elements, changed) = &mut members[number_of[root] as usize];
        elements.push(index as u32);
        *changed |= part.changed;
    }
    members.retain(|(_, changed)| *changed);
    let known = &*values;
    let solved: Vec<Vec<(u32, Rgb)>> =
        members.par_iter().map(|(elements, _)| Sheet::new(parts, elements).solved(known, max_residual)).collect();
    for (node, value) in solved.into_iter().flatten() {
        values[node as usize] = value;
    }
}

/// The equations of one sheet.
struct Sheet<'a> {
    /// Its nodes, ascending.
    nodes: Vec<u32>,
    /// Its elements, with nodes by their places in `nodes`.
    elements: Vec<([u32; NODES], &'a ElementEquations)>,
}

impl<'a> Sheet<'a> {
    fn new(parts: &[Part<'a>], elements: &[u32]) -> Self {
        let mut nodes: Vec<u32> = elements.iter().flat_map(|&index| parts[index as usize].nodes).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let place = |node: u32| nodes.partition_point(|&known| known < node) as u32;
        let elements = elements.iter().map(|&index| {
            let part = &parts[index as usize];
            (part.nodes.map(place), part.equations)
        });
        Self { elements: elements.collect(), nodes: nodes.clone() }
    }

    fn solved(&self, known: &[Rgb], max_residual: f64) -> Vec<(u32, Rgb)> {
        let solution =
            if self.nodes.len() <= FEW_NODES { self.by_factors() } else { self.by_gradients(known, max_residual) };
        self.nodes.iter().copied().zip(solution).collect()
    }

    /// Right-hand sides.
    fn light(&self) -> Vec<Rgb> {
        let mut light = vec![Rgb::ZERO; self.nodes.len()];
        for (nodes, equations) in &self.elements {
            nodes.iter().zip(&equations.light).for_each(|(&node, &of_element)| light[node as usize] += of_element);
        }
        light
    }

    /// Cholesky's method.
    fn by_factors(&self) -> Vec<Rgb> {
        let count = self.nodes.len();
        let mut factor = vec![0.0_f64; count * count];
        for (nodes, equations) in &self.elements {
            for (i, &row) in nodes.iter().enumerate() {
                for (j, &column) in nodes.iter().enumerate() {
                    factor[row as usize * count + column as usize] += f64::from(equations.products[i][j]);
                }
            }
        }
        let mut solution = self.light();
        for i in 0..count {
            factor[i * count + i] += REGULAR * factor[i * count + i] + f64::from(f32::MIN_POSITIVE);
            for j in 0..=i {
                let product: f64 = (0..j).map(|k| factor[i * count + k] * factor[j * count + k]).sum();
                let rest = factor[i * count + j] - product;
                // Rounding may leave nothing of a node that no sample tells of.
                let least = REGULAR * factor[i * count + i].abs().max(f64::MIN_POSITIVE);
                factor[i * count + j] = if i == j { rest.max(least).sqrt() } else { rest / factor[j * count + j] };
            }
            let product: Rgb = (0..i).map(|k| factor[i * count + k] * solution[k]).sum();
            solution[i] = (solution[i] - product) / factor[i * count + i];
        }
        for i in (0..count).rev() {
            let product: Rgb = (i + 1..count).map(|k| factor[k * count + i] * solution[k]).sum();
            solution[i] = (solution[i] - product) / factor[i * count + i];
        }
        solution
    }

    /// Conjugate gradients, all three colours at once.
    fn by_gradients(&self, known: &[Rgb], max_residual: f64) -> Vec<Rgb> {
        let mut diagonal = vec![f64::from(f32::MIN_POSITIVE); self.nodes.len()];
        for (nodes, equations) in &self.elements {
            nodes
                .iter()
                .enumerate()
                .for_each(|(i, &node)| diagonal[node as usize] += f64::from(equations.products[i][i]));
        }
        let scaled = |of: &[Rgb]| -> Vec<Rgb> { of.iter().zip(&diagonal).map(|(value, by)| value / by).collect() };
        let inner = |a: &[Rgb], b: &[Rgb]| -> Rgb { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let light = self.light();
        let mut solution: Vec<Rgb> = self.nodes.iter().map(|&node| known[node as usize]).collect();
        let mut residual: Vec<Rgb> =
            light.iter().zip(self.product(&solution)).map(|(light, product)| light - product).collect();
        let mut towards = scaled(&residual);
        let mut left = inner(&residual, &towards);
        let enough = max_residual * inner(&light, &scaled(&light));
        for _ in 0..MAX_STEPS {
            if left.cmple(enough).all() {
                break;
            }
            let product = self.product(&towards);
            let step = quotient(left, inner(&towards, &product));
            for i in 0..solution.len() {
                solution[i] += step * towards[i];
                residual[i] -= step * product[i];
            }
            let next = scaled(&residual);
            let left_then = std::mem::replace(&mut left, inner(&residual, &next));
            let kept = quotient(left, left_then);
            towards.iter_mut().zip(next).for_each(|(towards, next)| *towards = next + kept * *towards);
        }
        solution
    }

    fn product(&self, values: &[Rgb]) -> Vec<Rgb> {
        let mut product = vec![Rgb::ZERO; values.len()];
        for (nodes, equations) in &self.elements {
            let local = nodes.map(|node| values[node as usize]);
            for (row, &node) in equations.products.iter().zip(nodes) {
                product[node as usize] += row.iter().zip(local).map(|(&by, value)| f64::from(by) * value).sum::<Rgb>();
            }
        }
        product
    }
}

/// By colour; 0 where there is nothing to divide by.
fn quotient(a: Rgb, b: Rgb) -> Rgb {
    Rgb::from_array(std::array::from_fn(|i| if b[i] > 0.0 { a[i] / b[i] } else { 0.0 }))
}

#[cfg(test)]
mod tests {
    use super::super::element::{Element, equations};
    use super::super::sample::Sample;
    use super::*;
    use glam::{DVec2, Vec3};

    /// Strips of squares, each of two elements, and samples of a quadratic function over them.
    fn strip(squares: usize) -> (Vec<Element>, Vec<ElementEquations>, usize) {
        let node = |x: usize, y: usize| (x * 3 + y) as u32;
        let (mut elements, mut all) = (Vec::new(), Vec::new());
        let mut state = 1_u64;
        let mut draw = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1_u32 << 24) as f32
        };
        for x in 0..squares {
            let (p, q) = (2 * x, 2 * x + 2);
            let at = |x: usize, y: usize| DVec2::new(0.5 * x as f64, 0.5 * y as f64);
            let of = [
                (
                    [at(p, 0), at(q, 0), at(q, 2)],
                    [node(p, 0), node(q, 0), node(q, 2), node(p + 1, 0), node(q, 1), node(p + 1, 1)],
                ),
                (
                    [at(p, 0), at(q, 2), at(p, 2)],
                    [node(p, 0), node(q, 2), node(p, 2), node(p + 1, 1), node(p + 1, 2), node(p, 1)],
                ),
            ];
            for (corners, nodes) in of {
                let mut element = Element::new(corners);
                element.nodes = nodes;
                let samples: Vec<Sample> = (0..20_000)
                    .map(|_| {
                        let (s, t) = (f64::from(draw()).sqrt(), f64::from(draw()));
                        let at =
                            corners[0] + s * ((1.0 - t) * (corners[1] - corners[0]) + t * (corners[2] - corners[0]));
                        let light = Vec3::new(truth(at) as f32, 1.0, 0.0);
                        Sample { at_m: at.as_vec2().to_array(), light, ..Sample::default() }
                    })
                    .collect();
                all.extend(equations(&[element], &samples, |_| Rgb::ZERO));
                elements.push(element);
            }
        }
        (elements, all, (2 * squares + 1) * 3)
    }

    fn truth(at: DVec2) -> f64 {
        1.0 + 0.1 * at.x - 0.05 * at.y + 0.01 * at.x * at.y
    }

    #[test]
    fn both_ways_find_the_function_that_the_samples_have() {
        for squares in [2, 40] {
            let (elements, equations, nodes) = strip(squares);
            let parts: Vec<Part<'_>> = elements
                .iter()
                .zip(&equations)
                .map(|(element, equations)| Part { nodes: element.nodes, equations, changed: true })
                .collect();
            let mut values = vec![Rgb::ZERO; nodes];
            solve(&parts, &mut values, 1e-12);
            for (node, value) in values.iter().enumerate() {
                let at = DVec2::new(0.5 * (node / 3) as f64, 0.5 * (node % 3) as f64);
                // A little smoothing is asked for.
                assert!((value.x / truth(at) - 1.0).abs() < 2e-3 && (value.y - 1.0).abs() < 1e-4, "{value} at {at}");
            }
        }
    }
}
