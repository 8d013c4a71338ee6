//! A light tree: lights in a tree of boxes and cones of normals, and cuts through it for the points of a small place.
//!
//! A node knows the power of its lights and bounds of where they are and look. At a point it can give at most about its power times both
//! cosines over the squared distance. A cut is refined where nodes are large beside their distance and give much; then a light is drawn
//! by a node's bound, and in it by power (Conty Estevez and Kulla, *Importance sampling of many lights with adaptive tree splitting*, 2018;
//! cuts: Walter et al., *Lightcuts*, 2005). A cut serves all samples of a leaf, so a draw costs two searches and no way down the tree.
//!
//! Holds: probabilities of the lights of a cut add up to 1; a light that no point of the place can see has 0.

use glam::Vec3;

/// A node is small from where its radius is at most a tenth of the distance.
const SMALL_SQUARED: f32 = 0.01;
/// A cut is fine enough where no node has more than this share of all, weighted by its size beside its distance.
const FINE: f32 = 0.002;
/// Nearer than this share of its radius, a node gives no more.
const NEAR_OF_RADIUS: f32 = 0.3;
/// Normals as alike as this are one, and lights no farther off a plane than this share of their radius lie in it.
const ALIKE: f32 = 0.99999;
const FLAT_OF_RADIUS: f32 = 0.01;

/// A light: a flat thing that sends light by the cosine, or a lamp that sends it anywhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    pub(super) middle: Vec3,
    /// Of the ball around it, in metres.
    pub(super) radius_m: f32,
    /// `None` where it sends light anywhere.
    pub(super) normal: Option<Vec3>,
    /// In watts.
    pub(super) power: f32,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    middle: Vec3,
    /// Half the box, and the radius of the ball around it, in metres.
    half: Vec3,
    radius: f32,
    /// The cone of the normals: its axis, cosine and sine of its half angle.
    axis: Vec3,
    cosine: f32,
    sine: f32,
    /// Whether all lights lie in one plane.
    is_flat: bool,
    power: f32,
    /// The second part; the first is the next node. 0 where there are none.
    right: u32,
    /// Its lights, in the order of the tree.
    first: u32,
    end: u32,
}

/// The tree over some lights.
#[derive(Debug, Default)]
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// Power of all lights before each, and of all, in watts.
    powers: Vec<f64>,
}

/// Nodes whose lights are drawn by power.
#[derive(Clone, Debug, Default)]
pub(super) struct Cut {
    parts: Vec<CutPart>,
}

#[derive(Clone, Copy, Debug)]
struct CutPart {
    first: u32,
    end: u32,
    /// Probability of this part and those before it.
    up_to: f32,
    /// Probability of a light over its power, in 1/W.
    per_watt: f32,
}

impl LightTree {
    /// The tree of some lights, and the order in which it numbers them.
    pub(super) fn new(lights: &[Light]) -> (Self, Vec<u32>) {
        let mut order: Vec<u32> = (0..lights.len() as u32).collect();
        let mut tree = Self::default();
        if !lights.is_empty() {
            tree.grow(&mut order, 0, lights);
        }
        tree.powers.push(0.0);
        for &light in &order {
            tree.powers.push(tree.powers[tree.powers.len() - 1] + f64::from(lights[light as usize].power));
        }
        (tree, order)
    }

    /// Adds the node of some lights, and those below it.
    fn grow(&mut self, order: &mut [u32], first: usize, lights: &[Light]) {
        let of = |&number: &u32| &lights[number as usize];
        let bounds = |value: &dyn Fn(&Light) -> Vec3| {
            let values = || order.iter().map(of).map(value);
            [values().fold(Vec3::INFINITY, Vec3::min), values().fold(Vec3::NEG_INFINITY, Vec3::max)]
        };
        let [low, high] = bounds(&|light| light.middle);
        let [least, most] = bounds(&|light| light.normal.unwrap_or(Vec3::ZERO));
        let middle = low.midpoint(high);
        let lights_of = || order.iter().map(of);
        let directed = |light: &Light| light.normal.map_or(Vec3::ZERO, |normal| light.power * normal);
        let axis = lights_of().map(directed).sum::<Vec3>().try_normalize().unwrap_or(Vec3::Z);
        let cosine_of = |light: &Light| light.normal.map_or(-1.0, |normal| normal.dot(axis));
        let cosine = lights_of().map(cosine_of).fold(1.0, f32::min).max(-1.0);
        let widest_m = lights_of().map(|light| light.radius_m).fold(0.0, f32::max);
        let off_plane = lights_of().map(|light| (light.middle - middle).dot(axis).abs()).fold(0.0, f32::max);
        let is_flat = cosine > ALIKE && off_plane < FLAT_OF_RADIUS * widest_m;
        let reach = lights_of().map(|light| light.middle.distance(middle) + light.radius_m).fold(0.0, f32::max);
        let beyond = if is_flat { (Vec3::ONE - axis * axis).max(Vec3::ZERO).map(f32::sqrt) } else { Vec3::ONE };
        let number = self.nodes.len();
        self.nodes.push(Node {
            middle,
            half: 0.5 * (high - low) + widest_m * beyond,
            radius: reach,
            axis,
            cosine,
            sine: (1.0 - cosine * cosine).max(0.0).sqrt(),
            is_flat,
            power: lights_of().map(|light| light.power).sum(),
            right: 0,
            first: first as u32,
            end: (first + order.len()) as u32,
        });
        if order.len() == 1 {
            return;
        }
        // Along the axis on which middles, or normals as far away as the box is large, differ most.
        let size = (high - low).max_element().max(widest_m);
        let spread = [high - low, 0.5 * size * (most - least)].map(|spread| spread.to_array()).concat();
        let along = (0..6).max_by(|&i, &j| spread[i].total_cmp(&spread[j]).then(j.cmp(&i))).unwrap_or(0);
        let key = |number: &u32| {
            let light = &lights[*number as usize];
            if along < 3 { light.middle[along] } else { light.normal.unwrap_or(Vec3::ZERO)[along - 3] }
        };
        let halfway = if along < 3 { middle[along] } else { least.midpoint(most)[along - 3] };
        order.sort_unstable_by(|a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let left = order.partition_point(|number| key(number) <= halfway);
        let left = if left == 0 || left == order.len() { order.len() / 2 } else { left };
        let (one, other) = order.split_at_mut(left);
        self.grow(one, first, lights);
        self.nodes[number].right = self.nodes.len() as u32;
        self.grow(other, first + left, lights);
    }

    /// A cut of at most so many nodes, for points with this normal.
    pub(super) fn cut(&self, points: &[Vec3], normal: Vec3, most: usize) -> Cut {
        let mut open: Vec<(f32, u32, f32)> = Vec::with_capacity(most);
        let mut fine: Vec<(u32, f32)> = Vec::with_capacity(most);
        let mut all = 0.0;
        let mut add = |number: u32, open: &mut Vec<(f32, u32, f32)>, all: &mut f32| {
            let node = &self.nodes[number as usize];
            let gives = points.iter().map(|&point| node.bound(point, normal)).sum::<f32>() / points.len() as f32;
            let squared = points.iter().map(|point| point.distance_squared(node.middle)).fold(f32::INFINITY, f32::min);
            let of_radius = node.radius * node.radius;
            if gives <= 0.0 {
                return;
            }
            *all += gives;
            if node.right == 0 || of_radius < SMALL_SQUARED * squared {
                fine.push((number, gives));
            } else {
                open.push((gives * of_radius / squared.max(0.1 * of_radius), number, gives));
            }
        };
        if !self.nodes.is_empty() {
            add(0, &mut open, &mut all);
        }
        let mut parts = 1;
        while parts < most {
            let roughest = (0..open.len()).max_by(|&a, &b| open[a].0.total_cmp(&open[b].0).then(b.cmp(&a)));
            let Some(place) = roughest.filter(|&place| open[place].0 > FINE * all) else { break };
            let (_, number, gives) = open.swap_remove(place);
            all -= gives;
            add(number + 1, &mut open, &mut all);
            add(self.nodes[number as usize].right, &mut open, &mut all);
            parts += 1;
        }
        fine.extend(open.into_iter().map(|(_, number, gives)| (number, gives)));
        fine.sort_unstable_by_key(|(number, _)| self.nodes[*number as usize].first);
        let all: f32 = fine.iter().map(|(_, gives)| gives).sum();
        let mut up_to = 0.0;
        let part = |(number, gives): (u32, f32)| {
            let Node { first, end, .. } = self.nodes[number as usize];
            let power = (self.powers[end as usize] - self.powers[first as usize]) as f32;
            up_to += gives / all;
            CutPart { first, end, up_to, per_watt: gives / all / power }
        };
        Cut { parts: fine.into_iter().map(part).collect() }
    }

    /// The lights of each part of a cut.
    pub(super) fn parts<'a>(&'a self, cut: &'a Cut) -> impl Iterator<Item = std::ops::Range<usize>> + 'a {
        cut.parts.iter().map(|part| part.first as usize..part.end as usize)
    }

    /// Draws one of a range of lights by power, and gives its probability among them.
    pub(super) fn draw_of(&self, lights: std::ops::Range<usize>, number: f32) -> (usize, f32) {
        let powers = &self.powers[lights.start..=lights.end];
        let all = powers[powers.len() - 1] - powers[0];
        let wanted = powers[0] + f64::from(number) * all;
        let among = powers[1..powers.len() - 1].partition_point(|&power| power <= wanted);
        (lights.start + among, ((powers[among + 1] - powers[among]) / all) as f32)
    }

    /// Draws a light of a cut by an even random number, and gives its probability.
    pub(super) fn draw(&self, cut: &Cut, number: f32) -> Option<(usize, f32)> {
        let place = cut.parts.partition_point(|part| part.up_to <= number).min(cut.parts.len().checked_sub(1)?);
        let part = &cut.parts[place];
        let before = if place == 0 { 0.0 } else { cut.parts[place - 1].up_to };
        let share = ((number - before) / (part.up_to - before).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let (light, _) = self.draw_of(part.first as usize..part.end as usize, share);
        Some((light, self.probability(cut, light)))
    }

    /// The probability of a light in a cut.
    pub(super) fn probability(&self, cut: &Cut, light: usize) -> f32 {
        let place = cut.parts.partition_point(|part| part.first as usize <= light);
        let part = place.checked_sub(1).map(|place| &cut.parts[place]).filter(|part| light < part.end as usize);
        part.map_or(0.0, |part| part.per_watt * (self.powers[light + 1] - self.powers[light]) as f32)
    }
}

impl Node {
    /// About the most that it can give at a point with this normal, in W/m2.
    fn bound(&self, point: Vec3, normal: Vec3) -> f32 {
        let towards = self.middle - point;
        let height = normal.dot(towards) + self.half.dot(normal.abs());
        if height <= 1e-5 * self.radius {
            return 0.0;
        }
        let distance = towards.length();
        let least = (distance - self.radius).max(NEAR_OF_RADIUS * self.radius);
        let received = (height / least).min(1.0);
        self.power * received * self.sent(towards, distance, least) / distance.max(self.radius).powi(2)
    }

    /// A bound of the cosine with which it sends back along `towards`.
    fn sent(&self, towards: Vec3, distance: f32, least: f32) -> f32 {
        let height = -self.axis.dot(towards);
        if self.is_flat {
            return if height <= 1e-5 * self.radius { 0.0 } else { (height / least.max(height)).min(1.0) };
        }
        if distance <= self.radius {
            return 1.0;
        }
        // The angle to the axis, less that of the cone, less that of the ball: by sines and cosines.
        let less = |[cosine, sine]: [f32; 2], [of_cosine, of_sine]: [f32; 2]| match cosine >= of_cosine {
            true => [1.0, 0.0],
            false => [cosine * of_cosine + sine * of_sine, (sine * of_cosine - cosine * of_sine).abs()],
        };
        let cosine = (height / distance).clamp(-1.0, 1.0);
        let of_ball = self.radius / distance;
        let from_cone = less([cosine, (1.0 - cosine * cosine).max(0.0).sqrt()], [self.cosine, self.sine]);
        less(from_cone, [(1.0 - of_ball * of_ball).max(0.0).sqrt(), of_ball])[0].max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lights() -> impl Strategy<Value = Vec<Light>> {
        let vector = || prop::array::uniform3(-1.0_f32..1.0).prop_map(Vec3::from);
        let light = (vector(), vector(), 0.01_f32..3.0).prop_filter_map("a normal", |(middle, normal, power)| {
            Some(Light { middle: 3.0 * middle, radius_m: 1e-3, normal: Some(normal.try_normalize()?), power })
        });
        prop::collection::vec(light, 1..60)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn probabilities_add_up_to_one_and_draws_have_them(lights in lights(), most in 1_usize..20) {
            let (tree, order) = LightTree::new(&lights);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            prop_assert!(sorted.into_iter().eq(0..lights.len() as u32));
            let cut = tree.cut(&[Vec3::new(0.3, 0.1, -0.2), Vec3::new(0.5, 0.1, -0.2)], Vec3::Y, most);
            prop_assert!(cut.parts.len() <= most);
            let all: f32 = (0..lights.len()).map(|light| tree.probability(&cut, light)).sum();
            prop_assert!(cut.parts.is_empty() || (all - 1.0).abs() < 1e-4, "{all}");
            let count = 20_000;
            let mut drawn = vec![0.0_f32; lights.len()];
            for i in 0..count {
                let Some((light, probability)) = tree.draw(&cut, (i as f32 + 0.5) / count as f32) else { continue };
                prop_assert!((probability - tree.probability(&cut, light)).abs() < 1e-6);
                drawn[light] += 1.0 / count as f32;
            }
        }

        #[test]
        fn no_light_that_a_point_sees_is_above_the_bound_of_its_node(lights in lights(), point in prop::array::uniform3(-5.0_f32..5.0)) {
            let point = Vec3::from(point);
            let (tree, order) = LightTree::new(&lights);
            for node in &tree.nodes {
                let bound = node.bound(point, Vec3::Z);
                for &light in &order[node.first as usize..node.end as usize] {
                    let Light { middle, normal, power, .. } = lights[light as usize];
                    let normal = normal.unwrap();
                    let towards = middle - point;
                    let squared = towards.length_squared();
                    // About: near a node one over the squared distance is that of its middle.
                    if squared > 4.0 * node.radius.powi(2) {
                        let brings = power * towards.z.max(0.0) * (-normal.dot(towards)).max(0.0) / squared.powi(2);
                        prop_assert!(bound * 9.0 >= brings, "{bound} is below {brings}");
                        prop_assert!(bound > 0.0 || brings == 0.0);
                    }
                }
            }
        }
    }
}
