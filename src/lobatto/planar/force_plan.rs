//! Springs between points and wrenches on bodies in a plane, and their quantities at the start of a step.
//!
//! Only components in the plane act: the projection of a force, the part of a torque about the normal, and the projection `d` of a line between two
//! points. Its height z, the difference of their places along the normal, is constant: `ℓ² = |d|² + z²`.

use crate::plan::forces::{HoldingPlan, HoldingStart, LineStart, LoadStart, SpringLaw};
use crate::planar::body::{PlanarBody, turned};
use catena_mechanism::description::body_state::BodyState;
use catena_mechanism::description::closure::Attachment;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::line_of_action::common_end;
use catena_mechanism::forces::point_spring::NO_LENGTH;
use catena_mechanism::forces::total::{Stored, scalar_coordinate};
use catena_mechanism::ground::matrices::column;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::plane::Plane;
use nalgebra::Vector3;

/// The constant data of all forces that do not act in joints.
#[derive(Clone)]
pub(crate) struct ForcesPlan {
    pub lines: Vec<LinePlan>,
    pub wrenches: Vec<WrenchPlan>,
    /// Loads that change or turn, then drag.
    pub loads: Vec<LoadPlan>,
    /// Efforts that hold weights.
    holding: Vec<HeldWeight>,
}

/// An effort that holds a weight, at zero displacement.
#[derive(Clone)]
struct HeldWeight {
    head: usize,
    /// The direction of a slide, and the sign of a turn about the normal.
    slide: [f64; 2],
    sign: f64,
    /// Vectors from the anchors of the bodies beyond to their centres of mass (m), and their masses (kg).
    beyond: Vec<([f64; 2], f64)>,
}

/// A load on a body in the plane.
#[derive(Clone)]
pub(crate) struct LoadPlan {
    body: usize,
    /// Vector from the anchor to the point of action, at zero displacement (m).
    arm: [f64; 2],
    /// At zero displacement (N, N m), where they turn with the body.
    force: [f64; 2],
    torque: f64,
    turns: bool,
}

/// A spring between two points.
#[derive(Clone)]
pub(crate) struct LinePlan {
    pub ends: [End; 2],
    /// z (m).
    height: f64,
    pub law: SpringLaw,
}

/// A point of a body, or of the world.
#[derive(Clone)]
pub(crate) struct End {
    pub body: Option<usize>,
    /// Vector from the anchor of the body at zero displacement, or from the origin of the world (m).
    pub arm: [f64; 2],
}

/// Finds points of bodies that are placed so at zero displacement.
pub(crate) struct Ends<'m> {
    pub mechanism: &'m Mechanism,
    pub plane: &'m Plane,
    pub zero: &'m [BodyState],
}

impl Ends<'_> {
    /// The arm of a point of a body from its anchor.
    fn arm_of(&self, body: usize, point: &Vector3<f64>) -> [f64; 2] {
        let anchor = self.mechanism.bodies[body].joint.on_child.translation.vector;
        self.plane.flat(&(self.zero[body].rotation * (point - anchor)))
    }

    /// The place of an end.
    pub fn end(&self, at: &Attachment) -> End {
        let point = at.frame.translation.vector;
        End { body: at.body, arm: at.body.map_or(self.plane.flat(&point), |body| self.arm_of(body, &point)) }
    }

    /// How high it is (m).
    pub fn height(&self, at: &Attachment) -> f64 {
        self.plane.normal().dot(&at.place(self.zero).0)
    }
}

/// A constant wrench.
#[derive(Clone)]
pub(crate) struct WrenchPlan {
    pub body: usize,
    /// Vector from the anchor to the point of action, at zero displacement (m).
    arm: [f64; 2],
    pub force: [f64; 2],
    pub torque: f64,
    /// Potential of the force at the height where it acts (J).
    offset: f64,
}

/// Quantities of the forces at the start of a step.
#[derive(Clone)]
pub(crate) struct ForcesStart {
    /// Extension of each joint spring (rad or m).
    pub extensions: Vec<f64>,
    pub lines: Vec<LineStart<[f64; 2]>>,
    /// Vectors from the anchor to the point of each wrench (m).
    pub arms: Vec<[f64; 2]>,
    pub loads: Vec<LoadStart<[f64; 2], f64>>,
    pub holding: Vec<HoldingStart<[f64; 2], f64>>,
}

impl ForcesPlan {
    /// Projects the forces, for bodies that are placed so at zero displacement.
    pub fn new(mechanism: &Mechanism, plane: &Plane, zero: &[BodyState]) -> Self {
        let (ends, normal) = (Ends { mechanism, plane, zero }, plane.normal());
        let height =
            |body: usize, point: &Vector3<f64>| normal.dot(&(zero[body].position + zero[body].rotation * point));
        let lines = mechanism.forces.point_springs.iter().map(|spring| LinePlan {
            ends: [ends.end(&spring.a), ends.end(&spring.b)],
            height: ends.height(&spring.b) - ends.height(&spring.a),
            law: SpringLaw::of(spring),
        });
        let wrenches = mechanism.forces.wrenches.iter().map(|wrench| WrenchPlan {
            body: wrench.body,
            arm: ends.arm_of(wrench.body, &wrench.point),
            force: plane.flat(&wrench.force),
            torque: normal.dot(&wrench.torque),
            offset: -normal.dot(&wrench.force) * height(wrench.body, &wrench.point),
        });
        let loads = mechanism.forces.link_loads.iter().map(|load| {
            let at_zero = |own: &Vector3<f64>| if load.turns { zero[load.body].rotation * own } else { *own };
            LoadPlan {
                body: load.body,
                arm: ends.arm_of(load.body, &load.point),
                force: plane.flat(&at_zero(&load.force)),
                torque: normal.dot(&at_zero(&load.torque)),
                turns: load.turns,
            }
        });
        let drags = mechanism.forces.drags.iter().map(|drag| LoadPlan {
            body: drag.body,
            arm: ends.arm_of(drag.body, &drag.point),
            force: [0.0; 2],
            torque: 0.0,
            turns: false,
        });
        let loads = loads.chain(drags).collect();
        let holding = HoldingPlan::all_of(mechanism).into_iter().map(|plan| {
            let on_child = mechanism.bodies[plan.head].joint.on_child.rotation;
            let axis = zero[plan.head].rotation * column(on_child.matrix(), 2);
            let arm = |&(body, mass): &(usize, f64)| (ends.arm_of(body, &Vector3::zeros()), mass);
            HeldWeight {
                head: plan.head,
                slide: plane.flat(&axis),
                sign: if axis.dot(&normal) < 0.0 { -1.0 } else { 1.0 },
                beyond: plan.beyond.iter().map(arm).collect(),
            }
        });
        ForcesPlan { lines: lines.collect(), wrenches: wrenches.collect(), loads, holding: holding.collect() }
    }

    /// Whether there are any.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty() && self.wrenches.is_empty() && self.loads.is_empty() && self.holding.is_empty()
    }
}

impl ForcesStart {
    /// Room for the start of a step.
    pub fn new(mechanism: &Mechanism) -> Self {
        let forces = &mechanism.forces;
        ForcesStart {
            extensions: vec![0.0; forces.joint_springs.len()],
            lines: vec![LineStart::default(); forces.point_springs.len()],
            arms: vec![[0.0; 2]; forces.wrenches.len()],
            loads: vec![LoadStart::default(); forces.link_loads.len() + forces.drags.len()],
            holding: HoldingPlan::starts(mechanism),
        }
    }

    /// Takes the state at the start of a step, with the bodies it places; returns the energy stored. Does not allocate.
    pub fn set(&mut self, plan: &ForcesPlan, mechanism: &Mechanism, state: &State, bodies: &[PlanarBody]) -> Stored {
        let forces = &mechanism.forces;
        let mut stored = Stored::default();
        for (extension, spring) in self.extensions.iter_mut().zip(&forces.joint_springs) {
            let slot = spring.coordinate.position;
            *extension = state.position[slot] - spring.rest + state.compensation[slot];
            stored.spring += spring.energy(state.position[slot]);
        }
        for load in &forces.joint_loads {
            if let Some(coordinate) = scalar_coordinate(mechanism, load.freedom) {
                stored.load += load.potential(state.position[coordinate.position]);
            }
        }
        // Arm, place and velocity of a point of a body.
        let point = |body: &PlanarBody, arm: &[f64; 2]| {
            let arm = turned(&body.turn, arm);
            let place = [body.position[0] + arm[0], body.position[1] + arm[1]];
            (arm, place, [body.velocity[0] - body.spin * arm[1], body.velocity[1] + body.spin * arm[0]])
        };
        for ((start, line), spring) in self.lines.iter_mut().zip(&plan.lines).zip(&forces.point_springs) {
            let [(a_arm, a, a_rate), (b_arm, b, b_rate)] = [0, 1].map(|side: usize| {
                let End { body, arm } = &line.ends[side];
                body.map_or(([0.0; 2], *arm, [0.0; 2]), |body| point(&bodies[body], arm))
            });
            let separation = [b[0] - a[0], b[1] - a[1]];
            let square = line.height * line.height;
            let length = (separation[0] * separation[0] + separation[1] * separation[1] + square + NO_LENGTH).sqrt();
            let rate = separation[0] * (b_rate[0] - a_rate[0]) + separation[1] * (b_rate[1] - a_rate[1]);
            let anchors = [0, 1].map(|side: usize| line.ends[side].body.map(|body| bodies[body].position.into()));
            *start = LineStart {
                arms: [a_arm, b_arm],
                common: common_end([a.into(), b.into()], anchors).map(|(end, arm)| (end, arm.into())),
                separation,
                square,
                length,
                rate: rate / length,
            };
            stored.spring += spring.energy(length);
        }
        for (start, wrench) in self.arms.iter_mut().zip(&plan.wrenches) {
            let (arm, place, _) = point(&bodies[wrench.body], &wrench.arm);
            *start = arm;
            stored.load += wrench.offset - (wrench.force[0] * place[0] + wrench.force[1] * place[1]);
        }
        for (start, load) in self.loads.iter_mut().zip(&plan.loads) {
            let body = &bodies[load.body];
            let (arm, _, velocity) = point(body, &load.arm);
            let force = if load.turns { turned(&body.turn, &load.force) } else { load.force };
            *start = LoadStart { arm, velocity, force, torque: load.torque };
        }
        for (start, held) in self.holding.iter_mut().zip(&plan.holding) {
            let from = bodies[held.head].position;
            (start.slide, start.axis) = (turned(&bodies[held.head].turn, &held.slide), held.sign);
            start.moment = [0.0; 2];
            for (offset, (own, (arm, mass))) in start.arms.iter_mut().zip(&held.beyond).enumerate() {
                let (arm, place, _) = point(&bodies[held.head + offset], arm);
                *own = arm;
                start.moment[0] += mass * (place[0] - from[0]);
                start.moment[1] += mass * (place[1] - from[1]);
            }
        }
        stored
    }
}
