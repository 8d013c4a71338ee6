//! Triangles flat as a needle are taken out of what is shown.
//!
//! A patch may narrow to nothing: at a sharp corner, or between two cuts that meet nearly in line. Its neighbours cut its
//! two long edges where these are nearer to each other than vertices may be, and know nothing of each other. What is left
//! there are triangles whose corners lie in one line as far as a reader of the file can tell.
//!
//! Two steps, each of which keeps all triangles around whole, so that no T-vertex is made:
//! 1. Vertices that an edge much shorter than the weld distance joins become one: the later one goes.
//! 2. A triangle with a corner `r` on its longest edge, but for rounding, goes; so does one no larger than a point. All
//!    others along that edge are cut at `r`:
//!
//! ```text
//!     p ------- r ------- q           p ------- r ------- q
//!      `------- . -------'     ->      \        |        /
//!       \                /              \       |       /
//!        `----- y -----'                 `----- y -----'
//! ```
//!
//! The longest edge first, so that the two sides of a sliver close from its wide end; and only where no part is as low as
//! what goes, or turned over, so that two of them do not hand a vertex to and fro. What cannot go that way stays. Both
//! steps are repeated: a cut may make a short edge, and either may make a flat triangle.
//!
//! At last, at a border of the surface, where nothing lies behind the longest edge, a triangle goes that is a little higher: its corner
//! lies on that edge for a reader who measures, and would be a T-vertex.
//!
//! Along an edge of more than two faces a cut makes more triangles than go: it is left out where they would be more than may
//! be written ([`Limit`]).
//!
//! Holds after: edges are shared as they were; nothing moved by more than half the weld distance.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec3;
use smallvec::SmallVec;

use crate::id::{FaceId, VertexId};
use crate::scene::Rgb;

/// Rounds after which flat triangles stay. What a round cuts may be flat in its turn; two or three are usual.
const MOST_ROUNDS: usize = 16;

/// An edge shorter than this share of the weld distance joins two vertices that are one.
const NEAR_OF_WELD: f64 = 0.5;
/// A triangle less high than this share of the weld distance is flat: three roundings of `f32`.
const FLAT_OF_WELD: f64 = 0.06;
/// So is one of less area than the square of this share: it would fit in what counts as one point. It is less high than
/// half the weld distance, whatever its shape.
const POINT_OF_WELD: f64 = 0.35;

/// At a border of the surface a triangle less high than this share of the weld distance, a millionth of the scene, goes.
const FLAT_AT_BORDER_OF_WELD: f64 = 0.35;

/// A triangle as it is shown, with the numbers of the values at its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LitTriangle {
    pub(super) face: FaceId,
    pub(super) vertices: [VertexId; 3],
    pub(super) values: [usize; 3],
}

impl LitTriangle {
    /// The ends of the side after corner `i`, the lesser first.
    pub(super) fn side(&self, i: usize) -> [VertexId; 2] {
        let [a, b] = [self.vertices[i], self.vertices[(i + 1) % 3]];
        [a.min(b), a.max(b)]
    }

    /// The number of the value at a vertex.
    pub(super) fn value_at(&self, vertex: VertexId) -> Option<usize> {
        self.vertices.iter().position(|&v| v == vertex).map(|i| self.values[i])
    }
}

/// How many triangles may be written, and of which faces they are.
pub(super) struct Limit<'a> {
    pub(super) most: usize,
    pub(super) is_written: &'a dyn Fn(FaceId) -> bool,
}

impl Limit<'_> {
    /// How many more triangles may be written than there are.
    fn room(&self, triangles: &[LitTriangle]) -> usize {
        self.most.saturating_sub(triangles.iter().filter(|triangle| (self.is_written)(triangle.face)).count())
    }
}

/// Takes out what is flat, within a limit. Returns how many triangles that were; new values are added behind the others.
pub(super) fn take_out(
    triangles: &mut Vec<LitTriangle>,
    values: &mut Vec<Rgb>,
    at_m: impl Fn(VertexId) -> DVec3,
    weld_m: f64,
    limit: &Limit<'_>,
) -> usize {
    let mut count = 0;
    let mut stays = BTreeSet::new();
    for _ in 0..MOST_ROUNDS {
        // Anew in each round: a cut joins a corner to the vertices across, and one of them may be as near as that.
        let joined = join_near(triangles, &at_m, weld_m, &mut stays);
        let flat = (0..triangles.len()).filter_map(|number| {
            let shape = Shape::of(triangles[number].vertices.map(&at_m));
            shape.is_flat(weld_m).then_some((number, shape))
        });
        let mut flat: Vec<(usize, Shape)> = flat.collect();
        flat.sort_by(|(m, p), (n, q)| q.longest_m.total_cmp(&p.longest_m).then(m.cmp(n)));
        let closed = Round::new(triangles, values, &flat, limit).close(&flat, &at_m);
        if joined + closed == 0 {
            break;
        }
        count += joined + closed;
    }
    count + take_off_borders(triangles, &at_m, weld_m)
}

/// Takes out what is flat behind a border of the surface; returns how many triangles that were.
fn take_off_borders(triangles: &mut Vec<LitTriangle>, at_m: &impl Fn(VertexId) -> DVec3, weld_m: f64) -> usize {
    let low = |triangle: &LitTriangle| {
        let shape = Shape::of(triangle.vertices.map(at_m));
        let corner = triangle.vertices[(shape.longest + 2) % 3];
        (shape.height_m < FLAT_AT_BORDER_OF_WELD * weld_m).then(|| (triangle.side(shape.longest), corner))
    };
    let mut borders: BTreeMap<[VertexId; 2], VertexId> = triangles.iter().filter_map(low).collect();
    for triangle in triangles.iter() {
        for i in 0..3 {
            // Something with another corner lies behind it.
            let (side, corner) = (triangle.side(i), triangle.vertices[(i + 2) % 3]);
            if borders.get(&side).is_some_and(|&of_low| of_low != corner) {
                borders.remove(&side);
            }
        }
    }
    let before = triangles.len();
    triangles.retain(|triangle| low(triangle).is_none_or(|(side, _)| !borders.contains_key(&side)));
    before - triangles.len()
}

/// Makes one of vertices that a short edge joins; returns how many triangles that took out. The later vertex goes, and none
/// to which another went, in this round or one before, so that a chain does not draw together; none goes where that would
/// turn a triangle over that is not flat then.
fn join_near(
    triangles: &mut Vec<LitTriangle>,
    at_m: &impl Fn(VertexId) -> DVec3,
    weld_m: f64,
    stays: &mut BTreeSet<VertexId>,
) -> usize {
    let (before, near_m) = (triangles.len(), NEAR_OF_WELD * weld_m);
    let sides = triangles.iter().flat_map(|t| (0..3).map(|i| t.side(i)));
    let short: BTreeSet<[VertexId; 2]> = sides.filter(|&[a, b]| at_m(a).distance(at_m(b)) < near_m).collect();
    let ends: BTreeSet<VertexId> = short.iter().flatten().copied().collect();
    let mut around: BTreeMap<VertexId, Vec<usize>> = BTreeMap::new();
    for (number, triangle) in triangles.iter().enumerate() {
        triangle.vertices.iter().filter(|v| ends.contains(v)).for_each(|&v| around.entry(v).or_default().push(number));
    }
    let mut went: BTreeSet<VertexId> = BTreeSet::new();
    for [earlier, later] in short {
        let of_later = around.get(&later).map_or(&[][..], Vec::as_slice);
        let moved = |number: usize| triangles[number].vertices.map(|v| if v == later { earlier } else { v });
        let keeps = |&number: &usize| {
            let (old, new) = (triangles[number].vertices.map(at_m), moved(number).map(at_m));
            let new_shape = Shape::of(new);
            new_shape.is_flat(weld_m) || new_shape.doubled_m2.dot(Shape::of(old).doubled_m2) > 0.0
        };
        let free = !went.contains(&earlier) && !went.contains(&later) && !stays.contains(&later);
        if free && of_later.iter().all(keeps) {
            let of_later = of_later.to_vec();
            let all: Vec<[VertexId; 3]> = of_later.iter().map(|&number| moved(number)).collect();
            of_later.iter().zip(all).for_each(|(&number, vertices)| triangles[number].vertices = vertices);
            around.entry(earlier).or_default().extend(of_later);
            went.insert(later);
            stays.insert(earlier);
        }
    }
    triangles.retain(|t| (0..3).all(|i| t.vertices[i] != t.vertices[(i + 1) % 3]));
    before - triangles.len()
}

/// How a triangle is shaped.
#[derive(Clone, Copy, Debug)]
struct Shape {
    /// Which side is the longest, and how long that is.
    longest: usize,
    longest_m: f64,
    /// Height over it.
    height_m: f64,
    /// Along the normal, twice as long as the area.
    doubled_m2: DVec3,
}

impl Shape {
    fn of([a, b, c]: [DVec3; 3]) -> Self {
        let lengths_m = [a.distance(b), b.distance(c), c.distance(a)];
        let longest = (1..3).fold(0, |best, i| if lengths_m[i] > lengths_m[best] { i } else { best });
        let longest_m = lengths_m[longest];
        let doubled_m2 = (b - a).cross(c - a);
        let height_m = if longest_m > 0.0 { doubled_m2.length() / longest_m } else { 0.0 };
        Self { longest, longest_m, height_m, doubled_m2 }
    }

    /// Whether a reader of the file would take it for a line or a point.
    fn is_flat(&self, weld_m: f64) -> bool {
        let point_m = POINT_OF_WELD * weld_m;
        self.height_m < FLAT_OF_WELD * weld_m || 0.5 * self.doubled_m2.length() < point_m * point_m
    }
}

/// One round over all triangles that are flat at its begin.
struct Round<'a> {
    triangles: &'a mut Vec<LitTriangle>,
    values: &'a mut Vec<Rgb>,
    /// The triangles along each edge between vertices of flat ones; among them some that no longer lie there.
    along: HashMap<[VertexId; 2], SmallVec<[usize; 4]>>,
    in_question: BTreeSet<VertexId>,
    /// How many more triangles may be written.
    room: usize,
    is_written: &'a dyn Fn(FaceId) -> bool,
    is_gone: Vec<bool>,
    is_cut: Vec<bool>,
}

impl<'a> Round<'a> {
    fn new(
        triangles: &'a mut Vec<LitTriangle>,
        values: &'a mut Vec<Rgb>,
        flat: &[(usize, Shape)],
        limit: &'a Limit<'a>,
    ) -> Self {
        let (room, is_written) = (limit.room(triangles), limit.is_written);
        let in_question = flat.iter().flat_map(|&(number, _)| triangles[number].vertices).collect();
        let count = if flat.is_empty() { 0 } else { triangles.len() };
        let (is_gone, is_cut) = (vec![false; count], vec![false; count]);
        let along = HashMap::new();
        let mut round = Self { triangles, values, along, in_question, room, is_written, is_gone, is_cut };
        (0..count).for_each(|number| round.list(number));
        round
    }

    /// Lists a triangle along those of its sides that may be asked for.
    fn list(&mut self, number: usize) {
        for i in 0..3 {
            let side = self.triangles[number].side(i);
            if side.iter().all(|vertex| self.in_question.contains(vertex)) {
                self.along.entry(side).or_default().push(number);
            }
        }
    }

    /// Takes the flat triangles out that are still as they were; returns how many it took.
    fn close(mut self, flat: &[(usize, Shape)], at_m: &impl Fn(VertexId) -> DVec3) -> usize {
        for (number, shape) in flat {
            if !self.is_gone[*number] && !self.is_cut[*number] {
                self.close_one(*number, shape, at_m);
            }
        }
        let count = self.is_gone.iter().filter(|gone| **gone).count();
        let mut gone = self.is_gone.iter();
        self.triangles.retain(|_| gone.next() != Some(&true));
        count
    }

    fn close_one(&mut self, number: usize, shape: &Shape, at_m: &impl Fn(VertexId) -> DVec3) {
        let ends = self.triangles[number].side(shape.longest);
        let corner = self.triangles[number].vertices[(shape.longest + 2) % 3];
        let sharing = self.along.get(&ends).cloned().unwrap_or_default();
        let mut sharing: Vec<usize> = sharing.into_iter().filter(|&n| self.lies_along(n, ends)).collect();
        sharing.sort_unstable();
        sharing.dedup();
        // Two sides of a sheet are flat at once.
        let (gone, cut): (Vec<usize>, Vec<usize>) =
            sharing.into_iter().partition(|&n| self.triangles[n].vertices.contains(&corner));
        if !cut.iter().all(|&n| self.may_cut(n, ends, corner, shape.height_m, at_m)) {
            return;
        }
        // Each one that is cut is one more, each that goes one less.
        let written = |of: &[usize]| of.iter().filter(|&&n| (self.is_written)(self.triangles[n].face)).count();
        let (more, less) = (written(&cut), written(&gone));
        if more > less + self.room {
            return;
        }
        self.room = self.room + less - more;
        let along = at_m(ends[1]) - at_m(ends[0]);
        let share = ((at_m(corner) - at_m(ends[0])).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        for n in cut {
            let value = self.value(n, ends, &gone, corner, share);
            let [first, second] = parts(&self.triangles[n], ends, corner, value);
            self.triangles[n] = first;
            self.triangles.push(second);
            self.is_cut[n] = true;
            self.is_gone.push(false);
            self.is_cut.push(true);
            self.list(n);
            self.list(self.triangles.len() - 1);
        }
        gone.into_iter().for_each(|n| self.is_gone[n] = true);
    }

    fn lies_along(&self, number: usize, ends: [VertexId; 2]) -> bool {
        !self.is_gone[number] && ends.iter().all(|end| self.triangles[number].vertices.contains(end))
    }

    /// Whether both parts of a triangle that is cut at a corner of another are higher than that one, and look the same way.
    fn may_cut(
        &self,
        number: usize,
        ends: [VertexId; 2],
        corner: VertexId,
        height_m: f64,
        at_m: &impl Fn(VertexId) -> DVec3,
    ) -> bool {
        let whole = Shape::of(self.triangles[number].vertices.map(at_m));
        parts(&self.triangles[number], ends, corner, 0).iter().all(|part| {
            let part = Shape::of(part.vertices.map(at_m));
            part.height_m > height_m && part.doubled_m2.dot(whole.doubled_m2) > 0.0
        })
    }

    /// The number of the value that a triangle has where a corner of others, which go, comes to lie on its edge.
    fn value(&mut self, number: usize, ends: [VertexId; 2], gone: &[usize], corner: VertexId, share: f64) -> usize {
        let at_ends = |n: usize| ends.map(|end| self.triangles[n].value_at(end));
        let of = at_ends(number);
        // Light that does not jump between the two is known at the corner.
        let known = gone.iter().find(|&&n| at_ends(n) == of).and_then(|&n| self.triangles[n].value_at(corner));
        known.unwrap_or_else(|| {
            let [first, second] = of.map(|value| value.map_or(Rgb::ZERO, |value| self.values[value]));
            self.values.push(first.lerp(second, share));
            self.values.len() - 1
        })
    }
}

/// The two parts of a triangle that is cut from a point of one of its edges.
fn parts(triangle: &LitTriangle, ends: [VertexId; 2], point: VertexId, value: usize) -> [LitTriangle; 2] {
    let i = (0..3).find(|&i| triangle.side(i) == ends).unwrap_or(0);
    [(i + 1) % 3, i].map(|k| {
        let mut part = *triangle;
        (part.vertices[k], part.values[k]) = (point, value);
        part
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const WELD_M: f64 = 1e-3;

    /// The same without a limit.
    fn take_out(
        triangles: &mut Vec<LitTriangle>,
        values: &mut Vec<Rgb>,
        at_m: impl Fn(VertexId) -> DVec3,
        weld_m: f64,
    ) -> usize {
        super::take_out(triangles, values, at_m, weld_m, &Limit { most: usize::MAX, is_written: &|_| true })
    }

    #[test]
    fn a_cut_that_makes_more_triangles_than_may_be_written_is_left_out() {
        // Behind the longest edge of the flat one lie two others.
        let at =
            [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, TINY_M, 0.0], [1.0, -1.0, 0.0], [1.0, 0.0, 1.0]].map(DVec3::from);
        let before = triangles(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        for (most, left) in [(3, 3), (4, 4), (usize::MAX, 4)] {
            let mut all = before.clone();
            let limit = Limit { most, is_written: &|_| true };
            super::take_out(&mut all, &mut values(5), |v| at[v.index()], WELD_M, &limit);
            assert_eq!(all.len(), left);
        }
        let mut all = before;
        super::take_out(
            &mut all,
            &mut values(5),
            |v| at[v.index()],
            WELD_M,
            &Limit { most: 0, is_written: &|_| false },
        );
        assert_eq!(all.len(), 4, "what is not written is not counted");
    }
    /// Far less than that.
    const TINY_M: f64 = 1e-6;

    /// Triangles of one face; each vertex has a value of its own number.
    fn triangles(of: &[[usize; 3]]) -> Vec<LitTriangle> {
        of.iter()
            .map(|&values| LitTriangle { face: FaceId::from(0), vertices: values.map(VertexId::from), values })
            .collect()
    }

    fn values(count: usize) -> Vec<Rgb> {
        (0..count).map(|i| Rgb::splat(i as f64)).collect()
    }

    fn area_m2(triangles: &[LitTriangle], at: &[[f64; 2]]) -> f64 {
        let place = |v: VertexId| glam::DVec2::from(at[v.index()]);
        let doubled = |t: &LitTriangle| {
            let [a, b, c] = t.vertices.map(place);
            (b - a).perp_dot(c - a)
        };
        0.5 * triangles.iter().map(doubled).sum::<f64>()
    }

    /// Takes the flat ones out of a disc of triangles, and checks that it is a disc with the same rim.
    fn taken_out(of: &[[usize; 3]], at: &[[f64; 2]]) -> Vec<LitTriangle> {
        let (mut all, mut values) = (triangles(of), values(at.len()));
        let rim = |all: &[LitTriangle]| {
            let directed: BTreeSet<[VertexId; 2]> =
                all.iter().flat_map(|t| (0..3).map(|i| [t.vertices[i], t.vertices[(i + 1) % 3]])).collect();
            assert_eq!(directed.len(), 3 * all.len(), "an edge is passed twice in one direction");
            directed.iter().copied().filter(|&[a, b]| !directed.contains(&[b, a])).collect::<Vec<_>>()
        };
        let (rim_before, area_before) = (rim(&all), area_m2(&all, at));
        let at_m = |v: VertexId| glam::DVec2::from(at[v.index()]).extend(0.0);
        assert!(take_out(&mut all, &mut values, at_m, WELD_M) > 0);
        assert!(all.iter().all(|t| !Shape::of(t.vertices.map(at_m)).is_flat(WELD_M)));
        assert!((area_m2(&all, at) - area_before).abs() < WELD_M);
        assert_eq!(rim(&all), rim_before);
        all
    }

    #[test]
    fn the_triangle_behind_the_longest_edge_is_cut_at_the_corner() {
        let at = [[0.0, 0.0], [2.0, 0.0], [1.0, TINY_M], [1.0, -1.0], [1.0, 1.0]];
        let left = taken_out(&[[0, 1, 2], [1, 0, 3], [0, 2, 4], [2, 1, 4]], &at);
        assert_eq!(left, triangles(&[[1, 2, 3], [0, 2, 4], [2, 1, 4], [2, 0, 3]]));
    }

    #[test]
    fn across_a_jump_the_corner_has_light_of_each_side() {
        let at = [[0.0, 0.0], [2.0, 0.0], [0.5, TINY_M], [1.0, -1.0]].map(|p| glam::DVec2::from(p).extend(0.0));
        let mut all = triangles(&[[0, 1, 2], [1, 0, 3]]);
        all[1].values = [4, 5, 6];
        let mut values = [0.0, 0.0, 0.0, 0.0, 8.0, 4.0, 0.0].map(Rgb::splat).to_vec();
        assert_eq!(take_out(&mut all, &mut values, |v| at[v.index()], WELD_M), 1);
        assert_eq!(all.iter().map(|t| t.values).collect::<Vec<_>>(), [[4, 7, 6], [7, 5, 6]]);
        assert!((values[7] - Rgb::splat(5.0)).abs().max_element() < 1e-12, "a quarter of the way from 4 to 8");
    }

    #[test]
    fn both_sides_of_a_sheet_go_together() {
        let at = [[0.0, 0.0], [2.0, 0.0], [1.0, TINY_M], [1.0, -1.0]].map(|p| glam::DVec2::from(p).extend(0.0));
        let mut all = triangles(&[[0, 1, 2], [1, 0, 3], [1, 0, 2], [0, 1, 3]]);
        assert_eq!(take_out(&mut all, &mut values(4), |v| at[v.index()], WELD_M), 2);
        assert_eq!(all.len(), 4);
        assert!(all.iter().all(|t| t.vertices.contains(&VertexId::from(3))));
    }

    #[test]
    fn a_sliver_with_vertices_on_both_sides_closes() {
        // From 0 to 5 a sliver with 1 and 2 above and 3 and 4 below; 6 lies far above it, 7 far below.
        let at = [
            [0.0, 0.0],
            [1.0, TINY_M],
            [3.0, TINY_M],
            [2.0, -TINY_M],
            [4.0, -TINY_M],
            [5.0, 0.0],
            [2.5, 2.0],
            [2.5, -2.0],
        ];
        let sliver = [[0, 3, 1], [1, 3, 2], [3, 4, 2], [2, 4, 5]];
        let above = [[0, 1, 6], [1, 2, 6], [2, 5, 6]];
        let below = [[3, 0, 7], [4, 3, 7], [5, 4, 7]];
        let left = taken_out(&[&sliver[..], &above, &below].concat(), &at);
        assert_eq!(left.len(), 10, "five edges in line, a triangle to each side of each");
    }

    #[test]
    fn at_a_border_a_corner_that_lies_on_it_for_a_reader_goes_with_its_triangle() {
        let height_m = 0.3 * WELD_M;
        let at = [[0.0, 0.0], [2.0, 0.0], [0.5, height_m], [1.0, 1.0], [1.0, -1.0]]
            .map(|p| glam::DVec2::from(p).extend(0.0));
        let at_m = |v: VertexId| at[v.index()];
        let behind = triangles(&[[0, 2, 3], [2, 1, 3]]);
        let mut all = [triangles(&[[0, 1, 2]]), behind.clone()].concat();
        assert_eq!(take_out(&mut all, &mut values(4), at_m, WELD_M), 1);
        assert_eq!(all, behind);
        // Where something lies behind the longest edge, there is no border.
        let whole = [triangles(&[[0, 1, 2]]), behind, triangles(&[[1, 0, 4]])].concat();
        let mut all = whole.clone();
        assert_eq!(take_out(&mut all, &mut values(5), at_m, WELD_M), 0);
        assert_eq!(all, whole);
    }

    #[test]
    fn no_vertex_is_handed_to_and_fro() {
        // The corner 1 of the flat one lies near 2, beyond which 3 goes on in line: to cut there makes a lower one.
        let at = [[0.0, 0.0], [1.0, TINY_M], [1.01, 0.0], [20.0, -2e-3], [9.0, -5.0]]
            .map(|p| glam::DVec2::from(p).extend(0.0));
        let before = triangles(&[[0, 2, 1], [2, 0, 3], [3, 0, 4]]);
        let (mut all, mut values) = (before.clone(), values(5));
        assert_eq!(take_out(&mut all, &mut values, |v| at[v.index()], WELD_M), 0);
        assert_eq!((all, values.len()), (before, 5));
    }

    #[test]
    fn near_vertices_on_the_two_sides_of_a_needle_become_one() {
        // The needle's tip is 0; 1 and 2 were cut into its two edges, by neighbours.
        let at = [[0.0, 0.0], [1.0, TINY_M], [1.0, -TINY_M], [3.0, 0.1], [3.0, -0.1], [0.0, 2.0], [0.0, -2.0]];
        let of = [[0, 2, 1], [1, 2, 4], [1, 4, 3], [0, 1, 5], [1, 3, 5], [2, 0, 6], [4, 2, 6]];
        let left = taken_out(&of, &at);
        assert_eq!(left.len(), 5);
        assert!(left.iter().all(|t| !t.vertices.contains(&VertexId::from(2))));
    }

    #[test]
    fn an_edge_that_a_cut_makes_short_is_joined_too() {
        // The cut joins 2 to 3, which lies across the longest edge and nearer than vertices may be.
        let at = [[0.0, 0.0], [2.0, 0.0], [1.0, TINY_M], [1.0, -0.4 * WELD_M], [1.0, 1.0], [1.0, -1.0]];
        let left = taken_out(&[[0, 1, 2], [1, 0, 3], [0, 2, 4], [2, 1, 4], [0, 5, 3], [5, 1, 3]], &at);
        assert_eq!(left, {
            let mut four = triangles(&[[0, 2, 4], [2, 1, 4], [0, 5, 2], [5, 1, 2]]);
            (four[2].values[2], four[3].values[2]) = (3, 3);
            four
        });
    }

    #[test]
    fn a_triangle_no_larger_than_a_point_goes_though_it_is_not_low() {
        let at = [[0.0, 0.0], [1.2e-3, 0.0], [0.6e-3, 0.15e-3], [0.6e-3, -1.0], [0.6e-3, 1.0]];
        let left = taken_out(&[[0, 1, 2], [1, 0, 3], [0, 2, 4], [2, 1, 4]], &at);
        assert_eq!(left, triangles(&[[1, 2, 3], [0, 2, 4], [2, 1, 4], [2, 0, 3]]));
    }
}
