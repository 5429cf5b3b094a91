//! Which shapes may touch, and with which friction and restitution.
//!
//! Candidates are shapes of links with obstacles, shapes of different links of one robot, and with `pairs = "all"` shapes of links of different
//! robots. The last `[[contact.pair]]` that
//! names both gives friction and restitution of a pair, else the obstacle, else `[contact]`. Links that a loop joint joins do not touch; if they are
//! of different robots, a `[[contact.pair]]` with `ignore = false` lets them.

use crate::mechanism::description::closure::Attachment;
use crate::mechanism::description::contact::{Collider, ContactPair, MomentLengths};
use crate::mechanism::description::contact_pairs::{ContactPairs, PairRun};
use crate::model::description::chain_reach::{Ball, ball_about, never_meet_within_limits};
use crate::model::description::contact_reach::ContactReach;
use crate::model::description::kinship::Kinship;
use crate::model::description::never_touch::NeverTouch;
use crate::model::description::wheel::{Wheel, rigid_with};
use crate::scene::pattern::matches;
use crate::scene::{ContactSettings, MeshSource, PairRule, Surface, Touching};

/// Two shapes that are not looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOutPair {
    /// The pair as it would be; its number is meaningless.
    pub pair: ContactPair,
    /// Why.
    pub because: NeverTouch,
}

/// To whom a collider belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// A link of a robot, by the number of the robot.
    Robot(usize),
    /// An obstacle, by number.
    Obstacle(usize),
    /// The first end of a rope, with its length, by number.
    Rope(usize),
    /// The second end.
    RopeEnd(usize),
}

/// A rope through two points or more.
#[derive(Clone, Debug, PartialEq)]
pub struct RopeRecord {
    /// Its name.
    pub name: String,
    /// The links of its points, in their order.
    pub links: Vec<String>,
    /// Its points; before them the one on its winch, which has no link here, if it has a winch.
    pub points: Vec<Attachment>,
    /// The ball in which it holds its second end, and that end; of a rope through more points, two of them on different bodies.
    pub colliders: [Collider; 2],
    /// Neighbours on different bodies, as balls that touch where these are as near to each other as they may be.
    pub stops: Vec<[Collider; 2]>,
    /// m.
    pub length: f64,
    /// e.
    pub restitution: f64,
}

impl RopeRecord {
    /// Its points without the one on its winch, if it has one.
    pub fn seen_points(&self) -> &[Attachment] {
        &self.points[self.points.len() - self.links.len()..]
    }
}

/// The record of the shapes of a model.
#[derive(Clone, Debug, Default)]
pub struct ContactRecord {
    /// The settings of the user.
    pub settings: ContactSettings,
    /// To whom each collider of the mechanism belongs.
    pub owners: Vec<Owner>,
    /// The shapes that turn exactly about the axes of their joints, and where the files put them.
    pub wheels: Vec<Wheel>,
    /// The pairs that never touch, and why.
    pub left_out: Vec<LeftOutPair>,
    /// The meshes of links that were read.
    pub meshes: Vec<MeshSource>,
    /// The ropes, whose ends are the last colliders and pairs.
    pub ropes: Vec<RopeRecord>,
}

/// The pairs of colliders that may touch, and those that never do. Colliders that follow each other, roam and touch in one way are one run for each collider
/// of another robot.
pub(crate) fn contact_pairs(
    settings: &ContactSettings,
    colliders: &[Collider],
    owners: &[Owner],
    surfaces: &[Surface],
    robots: usize,
    reach: &ContactReach,
) -> (ContactPairs, Vec<LeftOutPair>) {
    let (mut pairs, mut left_out) = (ContactPairs::default(), Vec::new());
    let kinship = Kinship::new(reach.mechanism());
    let rigid: Vec<Option<usize>> = colliders.iter().map(|collider| rigid_with(reach.mechanism(), collider)).collect();
    let one_distance = |kept: bool| kept.then_some(NeverTouch::OneDistance);
    let itself = settings.touches_itself(robots);
    let balls: Vec<Ball> = if itself { colliders.iter().map(ball_about).collect() } else { Vec::new() };
    let roams = |collider: usize| matches!(owners[collider], Owner::Robot(_)) && reach.roams(&colliders[collider]);
    let ends = alike(settings, colliders, surfaces, roams);
    for (a, one) in colliders.iter().enumerate() {
        // A loop joint makes neighbours of links of two robots, too. Obstacles are all of the world, and no links at the joint.
        let of_robot = |of: usize| colliders[of].body.filter(|_| matches!(owners[of], Owner::Robot(_)));
        let joined_to = of_robot(a).map_or(Vec::new(), |body| kinship.joined_by_loops(body));
        let joins = |b: usize| of_robot(b).is_some_and(|body| kinship.is_of(&joined_to, body));
        let mut next = a + 1;
        while next < colliders.len() {
            let (b, other) = (next, &colliders[next]);
            let own = owners[a] == owners[b];
            // Links that roam meet all links of other robots.
            let meets = !own && roams(b);
            let by_loop = !own && joins(b);
            next = match meets && !by_loop {
                true => (b + 1..ends[b]).find(|&other| joins(other)).unwrap_or(ends[b]),
                false => b + 1,
            };
            if never_asked(settings.touching(), itself, [owners[a], owners[b]]).is_some()
                || (own && one.name == other.name)
            {
                continue;
            }
            let is_obstacle = matches!(owners[b], Owner::Obstacle(_));
            let Manner { friction, restitution, moments: [rolling, spinning], ignored, wanted } =
                manner(settings, [surfaces[a], surfaces[b]], is_obstacle, [&one.name, &other.name]);
            let moments = MomentLengths { rolling, spinning };
            let first = ContactPair { number: pairs.len(), a, b, friction, restitution, moments };
            let joined = || match own {
                true => kinship.reason([one.body, other.body]).or(one_distance(rigid[a] == rigid[b])),
                false => (by_loop && !wanted).then_some(NeverTouch::Neighbours),
            };
            let within_limits =
                || never_meet_within_limits(reach.mechanism(), [one.body, other.body], [balls[a], balls[b]]);
            let apart = || !meets && (reach.never_meet(one, other) || (own && within_limits()));
            let because = match ignored {
                _ if one.body.is_none() && other.body.is_none() => Some(NeverTouch::BothFixed),
                Some(line) => Some(NeverTouch::Ignored(line)),
                None => joined().or_else(|| apart().then_some(NeverTouch::OutOfReach)),
            };
            let run = PairRun { first, count: next - b };
            match because {
                Some(because) => left_out.extend(run.pairs().map(|pair| LeftOutPair { pair, because })),
                None => pairs.push_run(run),
            }
        }
    }
    (pairs, left_out)
}

/// For each collider the end of those that follow it, roam like it, and touch in the same way.
fn alike(
    settings: &ContactSettings,
    colliders: &[Collider],
    surfaces: &[Surface],
    roams: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let patterns = || settings.rules.iter().flat_map(|rule| [&rule.a, &rule.b]);
    let named = |name: &str| patterns().map(|pattern| matches(pattern, name)).collect::<Vec<bool>>();
    let mut ends: Vec<usize> = (1..=colliders.len()).collect();
    let mut after = Vec::new();
    for (number, collider) in colliders.iter().enumerate().rev() {
        let own = named(&collider.name);
        let follower = number + 1;
        if follower < colliders.len()
            && roams(number)
            && roams(follower)
            && own == after
            && surfaces[number].touches_like(&surfaces[follower])
        {
            ends[number] = ends[follower];
        }
        after = own;
    }
    ends
}

/// Why the shapes of two are not even looked at. The last can be mended by another `pairs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
pub(crate) enum NeverAsked {
    #[error("contact is left out")]
    NoContact,
    #[error("obstacles do not touch each other")]
    Obstacles,
    #[error("a link does not touch itself")]
    OneLink,
    #[error("links of one robot touch each other with self_contact = true in [contact] only")]
    OneRobot,
    #[error("links of different robots do not touch: there is no obstacle, or [contact] says pairs = \"environment\"")]
    Robots,
}

/// Why the shapes of these two are not even looked at; `None` if they are.
fn never_asked(touching: Touching, itself: bool, owners: [Owner; 2]) -> Option<NeverAsked> {
    match owners {
        _ if touching == Touching::None => Some(NeverAsked::NoContact),
        [Owner::Obstacle(_), Owner::Obstacle(_)] => Some(NeverAsked::Obstacles),
        [Owner::Robot(one), Owner::Robot(other)] if one == other => (!itself).then_some(NeverAsked::OneRobot),
        [Owner::Robot(_), Owner::Robot(_)] if touching != Touching::All => Some(NeverAsked::Robots),
        _ => None,
    }
}

/// The rules that name no two things that may touch, by number, and why: among `named`, all links with collision shapes and all obstacles.
pub(crate) fn rules_of_nothing(
    settings: &ContactSettings,
    robots: usize,
    named: &[(&str, Owner)],
) -> Vec<(usize, NeverAsked)> {
    let itself = settings.touches_itself(robots);
    if settings.touching() == Touching::None {
        return Vec::new();
    }
    let why = |rule: &PairRule| {
        let of = |pattern: &str| -> Vec<&(&str, Owner)> {
            named.iter().filter(|(name, _)| matches(pattern, name)).collect()
        };
        let (ones, others) = (of(&rule.a), of(&rule.b));
        let pairs = ones.iter().flat_map(|one| others.iter().map(move |other| [*one, *other]));
        let never = |[one, other]: [&(&str, Owner); 2]| match one.1 {
            Owner::Robot(_) if one == other => Some(NeverAsked::OneLink),
            _ => never_asked(settings.touching(), itself, [one.1, other.1]),
        };
        let reasons: Option<Vec<_>> = pairs.map(never).collect();
        reasons?.into_iter().max()
    };
    settings.rules.iter().enumerate().filter_map(|(number, rule)| Some((number, why(rule)?))).collect()
}

/// How two shapes touch, and on which line it says that they do not.
struct Manner {
    friction: f64,
    restitution: f64,
    /// Lengths of rolling and of spinning friction (m).
    moments: [f64; 2],
    ignored: Option<usize>,
    /// Whether a rule says that they do touch.
    wanted: bool,
}

/// Friction of every kind and restitution of a pair. If both shapes have a coefficient, the smaller one counts, or the larger one with `settings.larger`; of a link
/// and an obstacle the obstacle's counts without it.
fn manner(settings: &ContactSettings, surfaces: [Surface; 2], is_obstacle: bool, [a, b]: [&str; 2]) -> Manner {
    let of_both = |[of_a, of_b]: [Option<f64>; 2], otherwise| match (of_a, of_b) {
        (Some(_), Some(of_obstacle)) if is_obstacle && !settings.larger => of_obstacle,
        (Some(one), Some(other)) if settings.larger => f64::max(one, other),
        (Some(one), Some(other)) => f64::min(one, other),
        (one, other) => one.or(other).unwrap_or(otherwise),
    };
    let mut manner = Manner {
        friction: of_both(surfaces.map(|surface| surface.friction), settings.friction),
        restitution: of_both(surfaces.map(|surface| surface.restitution), settings.restitution),
        moments: [0, 1].map(|of: usize| of_both(surfaces.map(|surface| surface.moments[of]), settings.moments[of])),
        ignored: None,
        wanted: false,
    };
    for rule in settings.rules.iter().filter(|rule| names(rule, a, b)) {
        manner.friction = rule.friction.unwrap_or(manner.friction);
        manner.restitution = rule.restitution.unwrap_or(manner.restitution);
        manner.moments = [0, 1].map(|of: usize| rule.moments[of].unwrap_or(manner.moments[of]));
        manner.wanted = rule.ignore.map_or(manner.wanted, |ignore| !ignore);
        manner.ignored = rule.ignore.map_or(manner.ignored, |ignore| ignore.then_some(rule.line));
    }
    manner
}

/// Whether a rule says that two shapes of links do touch: `ignore = false`.
pub(crate) fn are_wanted(settings: &ContactSettings, names: [&str; 2]) -> bool {
    manner(settings, [Surface::default(); 2], false, names).wanted
}

/// Whether a rule names two shapes, in either order.
fn names(rule: &PairRule, a: &str, b: &str) -> bool {
    (matches(&rule.a, a) && matches(&rule.b, b)) || (matches(&rule.a, b) && matches(&rule.b, a))
}
