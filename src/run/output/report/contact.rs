//! The contacts at the end of a run, and the worst of all its contacts.

use crate::mechanism::description::contact::ContactPair;
use crate::mechanism::description::contact_pairs::PairRun;
use crate::mechanism::ground::words::{counted, decimals, rounded};
use crate::mechanism::motion::contact_point::{ContactPoint, OutsideCone};
use crate::model::{Model, Owner};
use crate::simulation::Finished;
use serde::Serialize;

/// A closed contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactReport {
    /// The link, of two links the one of the first robot.
    pub a: String,
    /// The obstacle, or the other link.
    pub b: String,
    /// The contact point, in the world (m).
    pub position: [f64; 3],
    /// The unit normal from b to a.
    pub normal: [f64; 3],
    /// The force on a, in the world (N).
    pub force: [f64; 3],
    /// Negative where they overlap (m).
    pub gap: f64,
    /// `stick` or `slip`.
    pub state: &'static str,
    /// Whether it is a rope that is taut: its force is the tension.
    #[serde(skip)]
    pub is_rope: bool,
}

/// The contacts of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ContactsReport {
    /// The deepest overlap of shapes that may touch, whether they do or not (m): at the ends of steps, and between them.
    pub max_penetration: f64,
    /// The farthest of a force from its friction cone at the end of any step (N).
    pub max_cone_violation: f64,
    /// A warning, if a force is outside its cone by more than roundings.
    #[serde(skip)]
    pub(crate) outside: Option<String>,
    /// A warning, if shapes overlap by more than roundings and located events leave.
    #[serde(skip)]
    pub(crate) overlapping: Option<String>,
    /// Those that are closed at the end of the run.
    pub points: Vec<ContactReport>,
    /// Whether the mechanism has shapes that may touch; otherwise the lines for people do not mention them.
    #[serde(skip)]
    pub may_touch: bool,
}

impl ContactReport {
    /// A contact of this model.
    pub(crate) fn new(model: &Model, point: &ContactPoint) -> Self {
        let (a, b) = pair_names(model, point.pair);
        ContactReport {
            a: a.to_string(),
            b: b.to_string(),
            position: point.position.into(),
            normal: point.normal.into(),
            force: point.force.into(),
            gap: point.gap,
            state: state_name(point),
            is_rope: is_rope(model, point.pair),
        }
    }
}

/// A force that is outside its cone by less than this part of the weight of all bodies is a rounding: bodies that touch without pressing have only such forces.
const ROUNDING: f64 = 1e-12;

impl ContactsReport {
    /// The contacts of a run of this model.
    #[doc(hidden)]
    pub fn new(model: &Model, finished: &Finished) -> Self {
        let figures = finished.summary.contact;
        let weight = model.mechanism.total_mass() * model.mechanism.gravity.norm();
        let outside = figures.outside.filter(|outside| outside.violation > ROUNDING * weight);
        ContactsReport {
            max_penetration: figures.penetration,
            max_cone_violation: figures.cone_violation,
            overlapping: overlap_words(figures.penetration, finished.summary.deepest_at),
            outside: outside.map(|outside| outside_words(model, &outside)),
            points: finished.contacts.iter().map(|point| ContactReport::new(model, point)).collect(),
            may_touch: !model.mechanism.nonsmooth.pairs.is_empty(),
        }
    }

    /// The contacts at the end and the worst of all contacts, in words.
    pub(crate) fn words(&self) -> String {
        let touching = self.points.iter().filter(|point| !point.is_rope);
        let slipping = touching.clone().filter(|point| point.state == "slip").count();
        let touching = touching.count();
        let ropes = match self.points.len() - touching {
            0 => String::new(),
            taut => format!("{} taut, ", counted(taut, "rope", "ropes")),
        };
        ropes + &contact_words(touching, slipping, self.max_penetration, Some(self.max_cone_violation))
    }
}

/// Overlaps up to this are left by located events, and by contacts of crowds (m).
const DEEP: f64 = 1e-6;

/// The warning about an overlap (m) at a time (s), if it is deep.
fn overlap_words(penetration: f64, time: f64) -> Option<String> {
    let deep = format!(
        "shapes overlap by {penetration:.1e} m at t = {} s, in a step of first order; compare the run with one of a \
         smaller --tolerance or --step",
        rounded(time)
    );
    (penetration > DEEP).then_some(deep)
}

/// The warning about a force outside its cone: which, where, when, and how far.
fn outside_words(model: &Model, outside: &OutsideCone) -> String {
    let (name, [x, y, z]) = (pair_name(model, outside.pair), outside.position.map(decimals).into());
    format!(
        "contact {name:?}: a force is {:.1e} N outside its friction cone at t = {} s, at x = {x}, y = {y}, z = {z} m, where the largest force is \
         {:.1e} N; compare the run with one of a smaller --tolerance or --step",
        outside.violation,
        rounded(outside.time),
        outside.largest
    )
}

/// The contacts at the end, how many of them slip, the deepest overlap (m) and, if it is known, the farthest of a force from its cone (N):
/// `4 contacts at the end, 1 of them slips; deepest overlap 1.0e-16 m, largest error of friction cones 0.0e0 N`.
pub(crate) fn contact_words(count: usize, slipping: usize, penetration: f64, cone_violation: Option<f64>) -> String {
    let all = counted(count, "contact", "contacts");
    let slip = match slipping {
        0 => String::new(),
        1 => ", 1 of them slips".to_string(),
        slipping => format!(", {slipping} of them slip"),
    };
    let cones = cone_violation.map_or(String::new(), |off| format!(", largest error of friction cones {off:.1e} N"));
    format!("{all} at the end{slip}; deepest overlap {penetration:.1e} m{cones}")
}

/// The state of friction at a contact, as reports and logs name it.
pub(crate) fn state_name(point: &ContactPoint) -> &'static str {
    if point.sticks { "stick" } else { "slip" }
}

/// How many numbers of pairs there are, from zero on.
pub(crate) fn pair_count(model: &Model) -> usize {
    let last = |run: &PairRun| run.first.number + run.count;
    model.mechanism.nonsmooth.pairs.runs().iter().map(last).max().unwrap_or(0)
}

/// A pair by its number.
fn pair_of(model: &Model, number: usize) -> Option<ContactPair> {
    model.mechanism.nonsmooth.pairs.with_number(number)
}

/// The names of the shapes of a pair, by its number.
pub(crate) fn pair_names(model: &Model, number: usize) -> (&str, &str) {
    let colliders = &model.mechanism.nonsmooth.colliders;
    pair_of(model, number).map_or(("", ""), |pair| (&colliders[pair.a].name, &colliders[pair.b].name))
}

/// Whether a pair, by its number, is a rope.
fn is_rope(model: &Model, number: usize) -> bool {
    let owner = pair_of(model, number).and_then(|pair| model.contact.owners.get(pair.a));
    matches!(owner, Some(Owner::Rope(_)))
}

/// The names `a|b` of the shapes of a pair, by its number, as events have them.
pub(crate) fn pair_name(model: &Model, number: usize) -> String {
    let (a, b) = pair_names(model, number);
    format!("{a}|{b}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_overlap_beyond_what_located_events_leave_is_a_warning_with_its_depth_and_time() {
        let words = overlap_words(6.9e-4, 0.1311).expect("a deep overlap");
        assert!(words.starts_with("shapes overlap by 6.9e-4 m at t = 0.131 s"), "{words}");
        assert_eq!(overlap_words(9e-7, 0.1311), None);
    }

    #[test]
    fn the_words_count_what_touches_and_what_slips() {
        let point = |state| ContactReport {
            a: "ball".to_string(),
            b: "floor".to_string(),
            position: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            force: [0.0; 3],
            gap: 0.0,
            state,
            is_rope: state == "rope",
        };
        let words = |states: &[&'static str]| {
            let points = states.iter().map(|state| point(state)).collect();
            ContactsReport { points, ..ContactsReport::default() }.words()
        };
        let worst = "; deepest overlap 0.0e0 m, largest error of friction cones 0.0e0 N";
        assert_eq!(words(&[]), format!("0 contacts at the end{worst}"));
        assert_eq!(words(&["stick"]), format!("1 contact at the end{worst}"));
        assert_eq!(words(&["stick", "slip"]), format!("2 contacts at the end, 1 of them slips{worst}"));
        assert_eq!(words(&["slip", "slip"]), format!("2 contacts at the end, 2 of them slip{worst}"));
        assert_eq!(words(&["slip", "rope"]), format!("1 rope taut, 1 contact at the end, 1 of them slips{worst}"));
        // The words of a log that was cut off.
        assert_eq!(contact_words(1, 0, 2e-16, None), "1 contact at the end; deepest overlap 2.0e-16 m");
    }
}
