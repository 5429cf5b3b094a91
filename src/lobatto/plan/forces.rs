//! The forces on a mechanism, sorted for the sweeps, and their quantities at the start of a step.

use catena_mechanism::description::body_state::BodyState;
use catena_mechanism::description::course::Course;
use catena_mechanism::description::forces::{Drag, PointSpring};
use catena_mechanism::description::joint::JointKind;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::line_of_action::common_end;
use catena_mechanism::forces::point_spring::Line;
use catena_mechanism::forces::total::scalar_coordinate;
use catena_mechanism::ground::matrices::{column, cross, times};
use catena_mechanism::motion::state::State;
use nalgebra::Vector3;

/// The constant data of all forces, sorted by their inputs.
#[derive(Clone)]
pub(crate) struct AppliedPlan {
    /// Freedom and coefficient.
    pub(crate) dampers: Vec<(usize, f64)>,
    /// Freedom and stiffness; the displacement of its start is in [`AppliedStart`].
    pub(crate) springs: Vec<(usize, f64)>,
    /// Freedom and effort.
    pub(crate) loads: Vec<(usize, f64)>,
    pub(crate) balls: Vec<Ball>,
    pub(crate) lines: Vec<LinePlan>,
    pub(crate) wrenches: Vec<WrenchPlan>,
    /// Freedoms of one scalar coordinate each that are driven from outside, and the effort of the step.
    pub(crate) driven: Vec<(usize, f64)>,
    /// Freedom, effort, and its factor over time.
    pub(crate) courses: Vec<(usize, f64, Course)>,
    /// The body of each load that changes or turns, then of each drag, and its law.
    pub(crate) on_bodies: Vec<(usize, LoadLaw)>,
    /// Efforts that hold weights, and gravity [m/s²].
    pub(crate) holding: Vec<HoldingPlan>,
    pub(crate) gravity: [f64; 3],
}

/// An effort that holds a part of the weight beyond a joint.
#[derive(Clone)]
pub(crate) struct HoldingPlan {
    pub(crate) freedom: usize,
    /// The body of the joint.
    pub(crate) head: usize,
    /// Whether the joint turns about its axis; else it slides along it.
    pub(crate) turns: bool,
    /// f.
    pub(crate) factor: f64,
    /// The bodies beyond, with their masses (kg).
    pub(crate) beyond: Vec<(usize, f64)>,
    /// The sum of these (kg).
    pub(crate) mass: f64,
}

/// The same at the start of a step, in the components `C` of the world or of a plane, with torques `T`.
#[derive(Clone, Default)]
pub(crate) struct HoldingStart<C, T> {
    /// The axis of a joint that slides.
    pub(crate) slide: C,
    /// The axis of a joint that turns.
    pub(crate) axis: T,
    /// Vectors from the anchors of the bodies beyond to their centres of mass (m).
    pub(crate) arms: Vec<C>,
    /// S [kg m].
    pub(crate) moment: C,
}

impl HoldingPlan {
    /// The plans of a mechanism.
    pub(crate) fn all_of(mechanism: &Mechanism) -> Vec<Self> {
        let plans = mechanism.forces.gravity_compensations.iter().filter_map(|holding| {
            let head = mechanism.body_of_freedom(holding.freedom)?;
            let beyond: Vec<_> = mechanism.subtree(head).map(|body| (body, mechanism.bodies[body].mass)).collect();
            let mass = beyond.iter().map(|(_, mass)| mass).sum();
            let turns = mechanism.bodies[head].joint.kind != JointKind::Prismatic;
            Some(HoldingPlan { freedom: holding.freedom, head, turns, factor: holding.factor, beyond, mass })
        });
        plans.collect()
    }

    /// Room for the start of each.
    pub(crate) fn starts<C: Clone + Default, T: Clone + Default>(mechanism: &Mechanism) -> Vec<HoldingStart<C, T>> {
        let room = |plan: HoldingPlan| HoldingStart {
            arms: vec![C::default(); plan.beyond.len()],
            slide: C::default(),
            axis: T::default(),
            moment: C::default(),
        };
        HoldingPlan::all_of(mechanism).into_iter().map(room).collect()
    }
}

/// How a load on a body follows from its start, its time and its motion.
#[derive(Clone)]
pub(crate) enum LoadLaw {
    /// With the axes of the body or of the world, and a factor over time.
    Given { turns: bool, course: Course },
    /// N s/m, N s²/m², N m s/rad and N m s²/rad².
    Drag { linear: f64, quadratic: f64, angular_linear: f64, angular_quadratic: f64 },
}

/// A load on a body at the start of a step, in the components `C` of the world or of a plane, with torques `T`.
#[derive(Clone, Copy, Default)]
pub(crate) struct LoadStart<C, T> {
    /// Vector from the anchor to its point (m).
    pub(crate) arm: C,
    /// Velocity of that [m/s].
    pub(crate) velocity: C,
    /// Force (N) and torque [N m], without their factor over time.
    pub(crate) force: C,
    pub(crate) torque: T,
}

/// Dampers and loads about the axes of a ball joint.
#[derive(Clone)]
pub(crate) struct Ball {
    pub(crate) first: usize,
    pub(crate) coefficients: [f64; 3],
    pub(crate) efforts: [f64; 3],
    /// Efforts that drive it from outside in this step.
    pub(crate) driven: [f64; 3],
}

/// Law of a spring with a damper for its length and rate.
#[derive(Clone, Copy)]
pub(crate) struct SpringLaw {
    /// N/m.
    pub(crate) stiffness: f64,
    /// N s/m.
    pub(crate) damping: f64,
    /// m.
    pub(crate) rest_length: f64,
}

impl SpringLaw {
    /// The law of a spring between points.
    pub(crate) fn of(spring: &PointSpring) -> Self {
        let &PointSpring { stiffness, damping, rest_length, .. } = spring;
        SpringLaw { stiffness, damping, rest_length }
    }
}

/// A spring between points.
#[derive(Clone)]
pub(crate) struct LinePlan {
    /// The bodies at its ends; `None` is the world.
    pub(crate) ends: [Option<usize>; 2],
    pub(crate) law: SpringLaw,
}

#[derive(Clone)]
pub(crate) struct WrenchPlan {
    pub(crate) body: usize,
    pub(crate) force: [f64; 3],
    pub(crate) torque: [f64; 3],
}

/// Quantities of the forces at the start of a step.
#[derive(Clone, Default)]
pub struct AppliedStart {
    /// Extension of each joint spring (rad or m).
    pub(crate) extensions: Vec<f64>,
    pub(crate) lines: Vec<LineStart<[f64; 3]>>,
    /// Vectors from the anchor to the point of each wrench, in world axes (m).
    pub(crate) arms: Vec<[f64; 3]>,
    /// Loads that change or turn, then drag.
    pub(crate) loads: Vec<LoadStart<[f64; 3], [f64; 3]>>,
    /// Efforts that hold weights.
    pub(crate) holding: Vec<HoldingStart<[f64; 3], [f64; 3]>>,
}

/// A spring between points at the start of a step, in the components `C` of the world or of a plane.
#[derive(Clone, Copy, Default)]
pub(crate) struct LineStart<C> {
    /// Vectors from the anchors of the two bodies to the ends (m).
    pub(crate) arms: [C; 2],
    /// If one of the arms is very long, the end at which both forces act, and the arm of the other body to it (m).
    pub(crate) common: Option<(usize, C)>,
    /// d, from a to b (m).
    pub(crate) separation: C,
    /// Square of the part z of d along the normal of a plane, which never changes (m²).
    pub(crate) square: f64,
    /// ℓ (m) and its rate [m/s].
    pub(crate) length: f64,
    pub(crate) rate: f64,
}

impl AppliedStart {
    /// Room for the start of a step.
    pub fn new(mechanism: &Mechanism) -> Self {
        let forces = &mechanism.forces;
        AppliedStart {
            extensions: vec![0.0; forces.joint_springs.len()],
            lines: vec![LineStart::default(); forces.point_springs.len()],
            arms: vec![[0.0; 3]; forces.wrenches.len()],
            loads: vec![LoadStart::default(); forces.link_loads.len() + forces.drags.len()],
            holding: HoldingPlan::starts(mechanism),
        }
    }

    /// Takes the state at the start of a step, with the bodies it places. Does not allocate.
    pub fn set(&mut self, mechanism: &Mechanism, state: &State, bodies: &[BodyState]) {
        let forces = &mechanism.forces;
        for (extension, spring) in self.extensions.iter_mut().zip(&forces.joint_springs) {
            let slot = spring.coordinate.position;
            *extension = state.position[slot] - spring.rest + state.compensation[slot];
        }
        // Vector from the anchor of a body to a point in its frame.
        let arm = |body: usize, point: &Vector3<f64>| {
            times(&bodies[body].rotation, &(point - mechanism.bodies[body].joint.on_child.translation.vector))
        };
        let anchor = |body: usize| {
            let on_child = &mechanism.bodies[body].joint.on_child.translation.vector;
            bodies[body].position + times(&bodies[body].rotation, on_child)
        };
        for (start, spring) in self.lines.iter_mut().zip(&forces.point_springs) {
            let ends = [&spring.a, &spring.b];
            let [(from, from_rate), (to, to_rate)] = ends.map(|end| end.point(bodies));
            let line = Line::new(to - from, &(to_rate - from_rate));
            let anchors = [0, 1].map(|side: usize| ends[side].body.map(anchor));
            *start = LineStart {
                common: common_end([from, to], anchors).map(|(end, arm)| (end, arm.into())),
                arms: ends.map(|end| end.body.map_or([0.0; 3], |body| arm(body, &end.frame.translation.vector).into())),
                separation: line.separation.into(),
                square: 0.0,
                length: line.length,
                rate: line.rate,
            };
        }
        for (start, wrench) in self.arms.iter_mut().zip(&forces.wrenches) {
            *start = arm(wrench.body, &wrench.point).into();
        }
        let velocity = |body: usize, point: &Vector3<f64>| {
            let BodyState { rotation, velocity, angular_velocity, .. } = &bodies[body];
            velocity + cross(angular_velocity, &times(rotation, point))
        };
        let (of_loads, of_drags) = self.loads.split_at_mut(forces.link_loads.len());
        for (start, load) in of_loads.iter_mut().zip(&forces.link_loads) {
            let (force, torque) = load.at_point(1.0, &bodies[load.body]);
            *start = LoadStart {
                arm: arm(load.body, &load.point).into(),
                velocity: velocity(load.body, &load.point).into(),
                force: force.into(),
                torque: torque.into(),
            };
        }
        for (start, drag) in of_drags.iter_mut().zip(&forces.drags) {
            start.arm = arm(drag.body, &drag.point).into();
            start.velocity = velocity(drag.body, &drag.point).into();
        }
        for (start, holding) in self.holding.iter_mut().zip(&forces.gravity_compensations) {
            let Some(head) = mechanism.body_of_freedom(holding.freedom) else { continue };
            let on_child = mechanism.bodies[head].joint.on_child.rotation;
            let axis = times(&bodies[head].rotation, &column(on_child.matrix(), 2));
            (start.axis, start.slide) = (axis.into(), axis.into());
            let (from, mut moment) = (anchor(head), Vector3::zeros());
            for (own, body) in start.arms.iter_mut().zip(mechanism.subtree(head)) {
                *own = arm(body, &Vector3::zeros()).into();
                moment += mechanism.bodies[body].mass * (bodies[body].position - from);
            }
            start.moment = moment.into();
        }
    }
}

impl AppliedPlan {
    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        let forces = &mechanism.forces;
        let mut plan = AppliedPlan {
            dampers: Vec::new(),
            springs: forces.joint_springs.iter().map(|spring| (spring.coordinate.freedom, spring.stiffness)).collect(),
            loads: Vec::new(),
            balls: Vec::new(),
            lines: Vec::new(),
            wrenches: Vec::new(),
            driven: Vec::new(),
            courses: forces.joint_courses.iter().map(|load| (load.freedom, load.effort, load.course.clone())).collect(),
            on_bodies: Vec::new(),
            holding: HoldingPlan::all_of(mechanism),
            gravity: mechanism.gravity.into(),
        };
        for load in &forces.link_loads {
            plan.on_bodies.push((load.body, LoadLaw::Given { turns: load.turns, course: load.course.clone() }));
        }
        for &Drag { body, linear, quadratic, angular_linear, angular_quadratic, .. } in &forces.drags {
            plan.on_bodies.push((body, LoadLaw::Drag { linear, quadratic, angular_linear, angular_quadratic }));
        }
        for freedom in (0..mechanism.velocity_count).filter(|_| forces.driven) {
            match scalar_coordinate(mechanism, freedom) {
                Some(_) => plan.driven.push((freedom, 0.0)),
                None => {
                    plan.ball(mechanism, freedom);
                }
            }
        }
        for damper in &forces.joint_dampers {
            match scalar_coordinate(mechanism, damper.freedom) {
                Some(_) => plan.dampers.push((damper.freedom, damper.coefficient)),
                None => {
                    let (ball, axis) = plan.ball(mechanism, damper.freedom);
                    ball.coefficients[axis] += damper.coefficient;
                }
            }
        }
        for load in &forces.joint_loads {
            match scalar_coordinate(mechanism, load.freedom) {
                Some(_) => plan.loads.push((load.freedom, load.effort)),
                None => {
                    let (ball, axis) = plan.ball(mechanism, load.freedom);
                    ball.efforts[axis] += load.effort;
                }
            }
        }
        for spring in &forces.point_springs {
            plan.lines.push(LinePlan { ends: [spring.a.body, spring.b.body], law: SpringLaw::of(spring) });
        }
        for wrench in &forces.wrenches {
            let (body, force, torque) = (wrench.body, wrench.force.into(), wrench.torque.into());
            plan.wrenches.push(WrenchPlan { body, force, torque });
        }
        plan
    }

    /// Takes the efforts that drive the joints in the next step, one entry a degree of freedom; an empty slice means zero efforts.
    pub(crate) fn drive(&mut self, efforts: &[f64]) {
        let effort = |freedom: usize| efforts.get(freedom).copied().unwrap_or(0.0);
        for (freedom, own) in &mut self.driven {
            *own = effort(*freedom);
        }
        for ball in &mut self.balls {
            ball.driven = std::array::from_fn(|axis| effort(ball.first + axis));
        }
    }

    /// The entry of the ball joint that a freedom belongs to, and which of its axes it is.
    fn ball(&mut self, mechanism: &Mechanism, freedom: usize) -> (&mut Ball, usize) {
        let owner = mechanism.body_of_freedom(freedom).map(|body| &mechanism.bodies[body]);
        let first = owner.map_or(0, |body| body.joint.velocity_index + body.joint.kind.translation_axes().len());
        let index = self.balls.iter().position(|ball| ball.first == first).unwrap_or_else(|| {
            self.balls.push(Ball { first, coefficients: [0.0; 3], efforts: [0.0; 3], driven: [0.0; 3] });
            self.balls.len() - 1
        });
        (&mut self.balls[index], freedom - first)
    }
}
