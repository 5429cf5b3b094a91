//! The checks of every sample of a run: limits, overlaps, cones and finite numbers.

use crate::overlap::Convex;
use crate::scene::Scene;
use catena::mechanism::motion::contact_point::ContactPoint;
use catena::mechanism::motion::event::{Event, EventKind};
use catena::mechanism::motion::integrator::MethodDescription;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::session::Model;
use catena::simulation::{Observer, ObserverError, Sample, StepEnd};
use nalgebra::{IsometryMatrix3, Rotation3, Translation3};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// The most that anything may be outside its limit, or inside another shape (m, rad): ten times the tolerance of runs.
pub const ALLOWED: f64 = 1e-5;

/// The most that a force may be outside its cone, as a part of the largest force.
const CONE: f64 = 1e-6;

/// More attempts than this for one short scene are a defect: ordinary scenes take some hundreds.
pub const ATTEMPTS: usize = 30_000;

/// What was seen.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// The worst of each kind, with its words.
    pub outside_limit: Option<(f64, String)>,
    pub overlap: Option<(f64, String)>,
    pub outside_cone: Option<(f64, String)>,
    /// The time of the first number that is not finite (s).
    pub not_finite: Option<f64>,
    /// Contact impacts.
    pub impacts: usize,
    /// All events.
    pub events: usize,
    pub steps: usize,
    /// The time (s) at which the run took too many attempts.
    pub slow: Option<f64>,
    /// Position of joints at the start.
    pub start: Vec<f64>,
}

/// Keeps the worse of two.
fn keep(worst: &mut Option<(f64, String)>, amount: f64, words: impl FnOnce() -> String) {
    if worst.as_ref().is_none_or(|(most, _)| amount > *most) {
        *worst = Some((amount, words()));
    }
}

/// Looks at every sample.
pub struct Watch {
    scene: Arc<Scene>,
    model: Model,
    state: State,
    /// The bodies of the joints with limits.
    limits: Vec<(String, usize, f64, f64)>,
    /// The links of the solids.
    links: Vec<Option<usize>>,
    /// The obstacles, which do not move.
    standing: Vec<Vec<Convex>>,
    contacts: Vec<ContactPoint>,
    seen: Arc<Mutex<Seen>>,
    interrupt: Arc<AtomicBool>,
}

impl Watch {
    pub fn new(scene: &Arc<Scene>, model: &Model, interrupt: Arc<AtomicBool>) -> (Self, Arc<Mutex<Seen>>) {
        let described = model.description();
        let of_joint = |name: &str| described.joints.iter().find(|record| record.name == name)?.body;
        let limits = scene.limits.iter();
        let limits = limits.filter_map(|(name, low, high)| Some((name.clone(), of_joint(name)?, *low, *high)));
        let seen = Arc::new(Mutex::new(Seen::default()));
        let watch = Watch {
            limits: limits.collect(),
            links: scene.solids.iter().map(|solid| described.link(&solid.name)).collect(),
            standing: scene
                .solids
                .iter()
                .map(|solid| solid.pose.map_or(Vec::new(), |pose| Convex::of(&solid.shape, &pose)))
                .collect(),
            scene: scene.clone(),
            model: model.clone(),
            state: State::zero(&described.mechanism),
            contacts: Vec::new(),
            seen: seen.clone(),
            interrupt,
        };
        (watch, seen)
    }

    /// Whether a solid cannot move.
    fn stands(&self, solid: usize) -> bool {
        let links = &self.model.description().links;
        self.links[solid].is_none_or(|link| links[link].body.is_none())
    }

    fn overlaps(&self, seen: &mut Seen, time: f64) {
        let described = self.model.description();
        let bodies = body_states(&described.mechanism, &self.state);
        let moving: Vec<Vec<Convex>> = (self.scene.solids.iter().zip(&self.links))
            .map(|(solid, link)| match (solid.robot, link) {
                (Some(_), Some(link)) => {
                    let at = described.link_state(&bodies, *link);
                    let rotation = Rotation3::from_matrix_unchecked(at.rotation);
                    let pose = IsometryMatrix3::from_parts(Translation3::from(at.position), rotation);
                    Convex::of(&solid.shape, &pose)
                }
                _ => Vec::new(),
            })
            .collect();
        let sets = |index: usize| if moving[index].is_empty() { &self.standing[index] } else { &moving[index] };
        for one in 0..self.scene.solids.len() {
            for other in 0..one {
                // A link that the world holds may stand in an obstacle: no motion parts the two.
                if !self.scene.may_touch(one, other) || [one, other].into_iter().all(|index| self.stands(index)) {
                    continue;
                }
                for (a, b) in sets(one).iter().flat_map(|a| sets(other).iter().map(move |b| (a, b))) {
                    let depth = a.depth(b, ALLOWED);
                    if depth > 0.0 {
                        let [a, b] = [one, other].map(|index| &self.scene.solids[index].name);
                        keep(&mut seen.overlap, depth, || {
                            format!("{a} and {b} overlap by {depth:.1e} m at {time:.4} s")
                        });
                    }
                }
            }
        }
    }
}

impl Observer for Watch {
    fn begin_again(&mut self, _method: &MethodDescription) -> Result<(), ObserverError> {
        let mut seen = self.seen.lock().expect("one thread at a time");
        *seen = Seen { steps: seen.steps, ..Seen::default() };
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let shared = self.seen.clone();
        let mut seen = shared.lock().expect("one thread at a time");
        let time = sample.time;
        self.state.time = time;
        self.state.position.copy_from_slice(sample.position);
        self.state.velocity.copy_from_slice(sample.velocity);
        if !sample.position.iter().chain(sample.velocity).all(|number| number.is_finite()) {
            seen.not_finite.get_or_insert(time);
            return Ok(());
        }
        if seen.start.is_empty() {
            seen.start = sample.position.to_vec();
        }
        let mechanism = &self.model.description().mechanism;
        for (name, body, lower, upper) in &self.limits {
            let at = self.state.joint_position(mechanism, *body)[0];
            let outside = (lower - at).max(at - upper);
            if outside > ALLOWED {
                keep(&mut seen.outside_limit, outside, || {
                    format!("{name} is {outside:.1e} outside its limit at {time:.4} s")
                });
            }
        }
        self.overlaps(&mut seen, time);
        if let Some((friction, _)) = self.scene.contact {
            let largest = self.contacts.iter().map(|point| point.force.norm()).fold(0.0, f64::max);
            for point in &self.contacts {
                let off = point.cone_violation(friction);
                if off > CONE * largest {
                    let part = off / largest;
                    keep(&mut seen.outside_cone, part, || {
                        format!(
                            "a force is {off:.1e} N outside its cone at {time:.4} s, where the largest is {largest:.1e} N"
                        )
                    });
                }
            }
        }
        self.contacts.clear();
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        let mut seen = self.seen.lock().expect("one thread at a time");
        seen.steps += 1;
        if end.so_far.steps + end.so_far.rejected > ATTEMPTS && seen.slow.is_none() {
            seen.slow = Some(end.time);
            self.interrupt.store(true, Ordering::Relaxed);
        }
    }

    fn event(&mut self, event: &Event) {
        let mut seen = self.seen.lock().expect("one thread at a time");
        seen.events += 1;
        seen.impacts += usize::from(event.kind == EventKind::ContactImpact);
    }

    fn contacts(&mut self, points: &[ContactPoint]) {
        self.contacts = points.to_vec();
    }
}
