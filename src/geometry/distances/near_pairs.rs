//! The pairs of features of two shapes whose balls are near each other, in the order of both.
//!
//! Of many features the balls are sorted by where they begin along a line across the normal, and only balls that overlap along it are compared: sweep
//! and prune. The cost is n log n and the number of those.
//!
//! Source: J. Cohen, M. Lin, D. Manocha, M. Ponamgi, I-COLLIDE, Symposium on Interactive 3D Graphics (1995).

use crate::features::both::Both;
use crate::features::feature::FeatureId;
use crate::shapes::convex::Core;
use nalgebra::{Matrix3, Vector3};

/// So many pairs are looked at one by one.
const FEW: usize = 1024;
/// Intervals along the line are longer by this part, for roundings.
const ROUNDED: f64 = 1e-9;

/// The numbers of the pairs of features, each with a mark, whose balls are not farther apart than a length (m).
pub fn near_pairs(both: &Both, [of_a, of_b]: [&[(FeatureId, bool)]; 2], most: f64) -> Vec<(usize, usize)> {
    let balls_a: Vec<Ball> = of_a.iter().map(|(one, _)| ball(&both.a.core, *one)).collect();
    let of_b = of_b.iter().map(|(other, _)| ball(&both.b.core, *other).moved(&both.rotation, &both.translation));
    let balls_b: Vec<Ball> = of_b.collect();
    let is_near = |one: usize, other: usize| !balls_a[one].is_farther(&balls_b[other], most);
    let all = balls_a.len() * balls_b.len();
    if all <= FEW || balls_a.iter().chain(&balls_b).any(|ball| ball.1.is_infinite()) || most.is_infinite() {
        let pairs = (0..balls_a.len()).flat_map(|one| (0..balls_b.len()).map(move |other| (one, other)));
        return pairs.filter(|&(one, other)| is_near(one, other)).collect();
    }
    let mut pairs = overlapping([&balls_a, &balls_b], most);
    pairs.retain(|&(one, other)| is_near(one, other));
    pairs.sort_unstable();
    pairs
}

/// The pairs of balls that overlap along a line when the balls of the first are larger by a length (m).
fn overlapping([balls_a, balls_b]: [&[Ball]; 2], most: f64) -> Vec<(usize, usize)> {
    let axis = widest(balls_a.iter().chain(balls_b));
    let ends = |ball: &Ball, larger: f64| {
        let (middle, half) = (ball.0[axis], ball.1 + larger);
        let half = half + ROUNDED * (middle.abs() + half);
        [middle - half, middle + half]
    };
    let of_a = balls_a.iter().enumerate().map(|(number, ball)| (ends(ball, most), false, number));
    let of_b = balls_b.iter().enumerate().map(|(number, ball)| (ends(ball, 0.0), true, number));
    let mut sorted: Vec<([f64; 2], bool, usize)> = of_a.chain(of_b).collect();
    sorted.sort_unstable_by(|one, other| one.0[0].total_cmp(&other.0[0]));
    let mut open: [Vec<(f64, usize)>; 2] = Default::default();
    let mut pairs = Vec::new();
    for ([low, high], second, number) in sorted {
        let others = &mut open[usize::from(!second)];
        others.retain(|(end, _)| *end >= low);
        pairs.extend(others.iter().map(|&(_, other)| if second { (other, number) } else { (number, other) }));
        open[usize::from(second)].push((high, number));
    }
    pairs
}

/// The axis along which the centres of balls are spread most.
fn widest<'b>(balls: impl Iterator<Item = &'b Ball> + Clone) -> usize {
    let spread = |axis: usize| {
        let places = balls.clone().map(|ball| ball.0[axis]);
        let (low, high) =
            places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        high - low
    };
    (0..3).max_by(|&one, &other| spread(one).total_cmp(&spread(other))).unwrap_or(0)
}

/// A ball about all points of a feature: its centre and radius (m).
struct Ball(Vector3<f64>, f64);

impl Ball {
    fn moved(self, rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Self {
        Ball(rotation * self.0 + translation, self.1)
    }

    /// Whether all points of two features are farther apart than this (m).
    fn is_farther(&self, other: &Ball, most: f64) -> bool {
        let reach = self.1 + other.1 + most;
        (self.0 - other.0).norm_squared() > reach * reach
    }
}

/// The ball about a face, an edge or a vertex of a polytope; one without end about other features.
fn ball(core: &Core, feature: FeatureId) -> Ball {
    let Core::Polytope(polytope) = core else { return Ball(Vector3::zeros(), f64::INFINITY) };
    match feature {
        FeatureId::Vertex(number) => Ball(polytope.vertices[number as usize], 0.0),
        FeatureId::Edge(edge) | FeatureId::EdgePoint { edge, .. } => {
            let [from, to] = polytope.edges[edge as usize].ends.map(|end| polytope.vertices[end]);
            Ball((from + to) / 2.0, (to - from).norm() / 2.0)
        }
        FeatureId::Face(number) => {
            let corners = &polytope.faces[number as usize].corners;
            let at = |corner: &usize| polytope.vertices[*corner];
            let centre = corners.iter().map(at).sum::<Vector3<f64>>() / corners.len() as f64;
            Ball(centre, corners.iter().map(|corner| (at(corner) - centre).norm()).fold(0.0, f64::max))
        }
        _ => Ball(Vector3::zeros(), f64::INFINITY),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::slab::reaching;
    use crate::shapes::convex::Convex;
    use crate::tests::scenes::{Numbers, collider};

    #[test]
    fn a_sweep_finds_the_pairs_of_features_that_a_look_at_all_of_them_finds() {
        let mut numbers = Numbers::new(4);
        let mut hull = || {
            let of = collider("hull", 1.0, &mut numbers);
            Convex::new(&of.shape, &of.pose).expect("possible").expect("convex")
        };
        let (a, b) = (hull(), hull());
        for _ in 0..50 {
            let pose = numbers.pose(0.5);
            let both = Both { a: &a, b: &b, rotation: *pose.rotation.matrix(), translation: pose.translation.vector };
            let all = |core: &Core| crate::features::feature::features(core).map(|one| (one, true)).collect::<Vec<_>>();
            let (of_a, of_b) = (all(&a.core), all(&b.core));
            assert!(of_a.len() * of_b.len() > FEW && reaching(&a.core, &nalgebra::Vector3::x(), 0.0).is_none());
            let found = near_pairs(&both, [&of_a, &of_b], 0.02);
            let ball_of = |other: FeatureId| ball(&b.core, other).moved(&both.rotation, &both.translation);
            let pairs = (0..of_a.len()).flat_map(|one| (0..of_b.len()).map(move |other| (one, other)));
            let wanted: Vec<(usize, usize)> = pairs
                .filter(|&(one, other)| !ball(&a.core, of_a[one].0).is_farther(&ball_of(of_b[other].0), 0.02))
                .collect();
            assert_eq!(found, wanted);
        }
    }
}
