//! Places at the same point, of which the first is left.
//!
//! Two points are no farther apart along a line than in space. So the places near one are found among its neighbours in the order along a line, for a
//! cost of n log n unless many are at one height of it. The line has no direction in which faces of robots lie.

use crate::features::both::Candidate;
use nalgebra::Vector3;

/// The direction of the line.
const LINE: Vector3<f64> = Vector3::new(0.742_781_352_708_207_4, 0.371_390_676_354_103_7, 0.557_086_014_531_155_6);
/// A line is looked along from this many places on.
const MANY: usize = 32;
/// Roundings of places along the line, relative to the length that counts as the same point.
const ROUNDED: f64 = 1.0 + 1e-4;

/// Leaves the first of places whose points on either surface are nearer than a distance (m) to each other, and returns the others; the cores have these radii
/// (m).
/// Because the core of a ball is a point, all its places have the same point there, and not on its surface.
pub fn take_doubles(found: &mut Vec<Candidate>, same: f64, radii: [f64; 2]) -> Vec<Candidate> {
    let places: Vec<[Vector3<f64>; 2]> = found
        .iter()
        .map(|one| [one.points[0] + one.normal * radii[0], one.points[1] - one.normal * radii[1]])
        .collect();
    let near = |one: usize, other: usize| {
        let apart = |side: usize| (places[one][side] - places[other][side]).norm();
        (apart(0) <= same || apart(1) <= same) && found[one].normal.dot(&found[other].normal) > 0.9
    };
    let mut kept = vec![false; places.len()];
    if places.len() < MANY {
        for number in 0..places.len() {
            kept[number] = !(0..number).any(|earlier| kept[earlier] && near(earlier, number));
        }
    } else {
        let lines = [0, 1].map(|side| Line::new(places.iter().map(|points| points[side]), ROUNDED * same));
        for number in 0..places.len() {
            let double = |earlier: usize| earlier < number && kept[earlier] && near(earlier, number);
            kept[number] = !lines.iter().any(|line| line.beside(number).any(double));
        }
    }
    let mut kept = kept.into_iter();
    found.extract_if(.., |_| !kept.next().unwrap_or(true)).collect()
}

/// Points in their order along the line.
struct Line {
    /// Heights (m) and numbers, and the place of each number.
    sorted: Vec<(f64, usize)>,
    places: Vec<usize>,
    /// How far apart neighbours are (m).
    within: f64,
}

impl Line {
    fn new(points: impl Iterator<Item = Vector3<f64>>, within: f64) -> Self {
        let mut sorted: Vec<(f64, usize)> =
            points.enumerate().map(|(number, point)| (LINE.dot(&point), number)).collect();
        sorted.sort_unstable_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        let mut places = vec![0; sorted.len()];
        sorted.iter().enumerate().for_each(|(place, (_, number))| places[*number] = place);
        Line { sorted, places, within }
    }

    /// All numbers whose heights are near the one of a number.
    fn beside(&self, number: usize) -> impl Iterator<Item = usize> {
        let place = self.places[number];
        let height = self.sorted[place].0;
        let is_near = move |one: &&(f64, usize)| (one.0 - height).abs() <= self.within;
        let (before, after) = self.sorted.split_at(place);
        before.iter().rev().take_while(is_near).chain(after.iter().take_while(is_near)).map(|one| one.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::feature::FeatureId;
    use crate::tests::scenes::Numbers;

    #[test]
    fn of_many_places_the_same_are_left_as_by_a_look_at_all_pairs() {
        let mut numbers = Numbers::new(2);
        for round in 0..50 {
            let spots: Vec<[Vector3<f64>; 2]> = (0..40).map(|_| [numbers.vector(), numbers.vector()]).collect();
            // A flat face across an axis, and normals of two sides.
            let places: Vec<Candidate> = (0..300)
                .map(|number| {
                    let mut spot = |side: usize| spots[(numbers.next().abs() * 40.0) as usize % 40][side];
                    let mut points = [spot(0), spot(1)];
                    points.iter_mut().for_each(|point| *point += numbers.vector() * 2e-4);
                    points[0].x = if round % 2 == 0 { 0.3 } else { points[0].x };
                    let normal = if number % 5 == 0 { -Vector3::z() } else { Vector3::z() };
                    let features = [FeatureId::Vertex(number), FeatureId::Face(0)];
                    Candidate { normal, points, features, separation: 0.0 }
                })
                .collect();
            let same = 1e-4;
            let mut wanted: Vec<&Candidate> = Vec::new();
            for one in &places {
                let near = |other: &&&Candidate| {
                    let apart = |side: usize| (one.points[side] - other.points[side]).norm() <= same;
                    (apart(0) || apart(1)) && one.normal.dot(&other.normal) > 0.9
                };
                if wanted.iter().find(near).is_none() {
                    wanted.push(one);
                }
            }
            let mut found = places.clone();
            take_doubles(&mut found, same, [0.0; 2]);
            let names = |one: &Candidate| one.features[0];
            assert!(found.len() < 290 && found.len() > 40);
            assert!(found.iter().map(names).eq(wanted.into_iter().map(names)), "round {round}");
        }
    }
}
