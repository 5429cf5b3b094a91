//! Closed contacts at all stages: gaps, the directions in which their multipliers push, friction and rolling.
//!
//! The gap φ, n and p are at the columns' (i) and the rows' (k) stages ([`catena_mechanism::motion::contact_geometry`]). The slip velocity u at p
//! [m/s] comes from the rates of the scheme for rolling contacts, and from the rates of [`crate::equations::slips`] for sliding ones:
//!
//! ```text
//!     gap of a stage        φ_i = 0                              gradient: the force n_i on b with its torque p_i × n_i, opposites on a
//!     push of a row         f_k = n_k − μ t_k                    at p_k; t has the direction of u ([`crate::equations::braking`])
//!     rolling               h Σ_j a_ij e_j · u_j = 0             two tangents e; gradient and push e_i, because A Ā B = 1
//!     belts                 u_k + w_k − n_k (n_k · w_k)          w = R_b w_b − R_a w_a at the stage
//!     work of belts         h Σ_k b_k f_k · (v_k − u_k) = −h Σ_k b_k f_k · w_k   [J]      of a sliding contact  h Σ_k b_k Λ_k μ t_k · w_k
//! ```
//!
//! Source: the forced scheme with constraints on velocities, L. O. Jay, SIAM J. Sci. Comput. 20 (1998); the gradients of gaps:
//! [`catena_mechanism::description::contact`].

use crate::equations::braking::{Braking, Lean, Slipping};
use crate::equations::friction_moments::FrictionMoments;
use crate::equations::loops::Displaced;
use crate::equations::origins::common_origin;
use crate::equations::reeved::SpatialRope;
use crate::equations::slips::{BodyRate, StageMixing};
use crate::equations::spatial_loops::{End, Moved};
use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::euclidean::Euclidean;
use crate::numbers::lanes::Lanes;
use crate::numbers::smooth_lanes::{triple, vector};
use crate::stages::start::Start;
use catena_mechanism::description::contact::{Cores, Grip, Pairing, TouchJoint};
use catena_mechanism::forces::total::Exchange;
use catena_mechanism::motion::contact_geometry::{Contact, Placed, contact};
use catena_mechanism::motion::touches::{belt, tangents, touch_motion};
use nalgebra::Vector3;

/// Two normals whose angle has a sine below this leave no direction of a tangent.
const ALONG: f64 = 0.1;

/// A closed contact in a step.
#[derive(Clone)]
pub(crate) struct SpatialTouch<V> {
    joint: TouchJoint,
    pairing: Option<Pairing>,
    ends: [TouchEnd; 2],
    /// A unit vector in the world at the start, beside the normal: the part of it that is square to the normal of a stage is the first tangent there.
    tangent: [f64; 3],
    /// At the columns' and the rows' stages.
    at: [AtStages<V>; 2],
    /// `h Σ_j a_ij e_j · u_j` along both tangents (m).
    creep: [V; 2],
    /// The changes of their rates.
    rolling: [[[V; 6]; 2]; 2],
    /// Whether a surface moves over its body.
    is_belt: bool,
    /// The place of the origin of the second feature at the columns' stages, from the common origin (m).
    center: Vector<V>,
    /// Its friction.
    braking: Braking<V>,
    /// Its rolling and spinning friction, if it has any.
    moments: Option<Box<FrictionMoments<V>>>,
    /// The rope through several points that it is, if it is one.
    rope: Option<Box<SpatialRope<V>>>,
}

/// An end of a contact at the start of a step, from the common origin and in the world.
#[derive(Clone, Copy, Default)]
struct TouchEnd {
    point: [f64; 3],
    arm: [f64; 3],
    axis: [f64; 3],
    /// The x axis, and the velocity of its surface over the body [m/s].
    first_axis: [f64; 3],
    surface: [f64; 3],
}

/// The rates of a body and where its anchor is, from the common origin (m), at the columns' and at the rows' stages.
type BodySides<'r, V> = [(&'r BodyRate<V>, Vector<V>); 2];

/// A contact at stages: the fields of [`Contact`], and the slip velocity [m/s].
#[derive(Clone, Copy)]
struct AtStages<V> {
    gap: V,
    normal: Vector<V>,
    point: Vector<V>,
    slip: Vector<V>,
    /// `w` along the tangents, of belts [m/s].
    belt: Vector<V>,
    /// The velocities over their bodies of the surfaces of a and of b [m/s].
    surfaces: [Vector<V>; 2],
}

impl<V: Lanes> SpatialTouch<V> {
    /// The contacts of a mechanism under gravity of this size [m/s²].
    pub fn all(joints: &[TouchJoint], gravity: f64) -> Vec<Self> {
        let zero = Vector::zero();
        let nowhere =
            AtStages { gap: V::zero(), normal: zero, point: zero, slip: zero, belt: zero, surfaces: [zero; 2] };
        let new = |joint: &TouchJoint| SpatialTouch {
            joint: joint.clone(),
            pairing: joint.touch.pairing(),
            ends: [TouchEnd::default(); 2],
            tangent: [0.0; 3],
            at: [nowhere; 2],
            creep: [V::zero(); 2],
            rolling: [[[V::zero(); 6]; 2]; 2],
            is_belt: joint.is_belt(),
            center: zero,
            braking: Braking::new(joint.touch.friction(), gravity),
            moments: FrictionMoments::new(joint.moments, gravity).filter(|_| joint.touch.rows() > 0),
            rope: SpatialRope::new(joint).map(Box::new),
        };
        joints.iter().map(new).collect()
    }

    /// The bodies at its ends; `None` is the world.
    pub fn bodies(&self) -> [Option<usize>; 2] {
        [self.joint.a.body, self.joint.b.body]
    }

    /// Number of its equations.
    pub fn rows(&self) -> usize {
        self.joint.rows()
    }

    /// Whether its slip is held at zero.
    pub fn rolls(&self) -> bool {
        self.joint.touch.rows() == 3
    }

    /// μ; zero if it does not slide.
    pub fn friction(&self) -> f64 {
        self.braking.friction
    }

    /// Its slip at the columns' or the rows' stages.
    #[inline(always)]
    fn slipping(&self, side: usize) -> Slipping<V> {
        Slipping { normal: self.at[side].normal, slip: self.at[side].slip }
    }

    /// Whether its equations or forces depend on the slip or the turning.
    pub fn feels_slip(&self) -> bool {
        self.rolls() || self.friction() != 0.0 || self.moments.is_some()
    }

    /// Its rolling and spinning friction.
    pub fn moments(&self) -> Option<&FrictionMoments<V>> {
        self.moments.as_deref()
    }

    /// Whether friction has a direction: of a slip, or of a turning.
    pub fn brakes(&self) -> bool {
        self.friction() != 0.0 || self.moments().is_some_and(FrictionMoments::brake)
    }

    /// The rope through several points that it is, if it is one.
    pub fn rope(&mut self) -> Option<&mut SpatialRope<V>> {
        self.rope.as_deref_mut()
    }

    /// The pulls of a rope through several points on its bodies; empty for everything else.
    pub fn pulls(&self) -> &[[[V; 6]; 2]] {
        self.rope.as_ref().map_or(&[], |rope| rope.pulls())
    }

    /// The normal at the start of a step.
    pub fn normal(&self, start: &Start) -> Vector3<f64> {
        touch_motion(&self.joint, start.body_states()).normal
    }

    /// Takes the start of a step; `origins` are the common origins of the parts of all bodies (m). The first tangent is along the normal `beside` it, if
    /// there is one.
    pub fn begin(&mut self, start: &Start, origins: &[[f64; 3]], beside: Option<Vector3<f64>>) {
        if let Some(rope) = &mut self.rope {
            rope.begin(start, origins);
            return;
        }
        let origin = common_origin(self.bodies(), origins);
        let ends = [self.joint.a, self.joint.b].map(|end| End::new(&end, start, &origin));
        self.ends = ends.map(|End { point, arm, axes }| TouchEnd {
            point,
            arm,
            axis: axes[2],
            first_axis: axes[0],
            surface: [0.0; 3],
        });
        if self.is_belt {
            let attachments = [&self.joint.a, &self.joint.b].into_iter().zip(self.joint.surfaces);
            for (end, (attachment, surface)) in self.ends.iter_mut().zip(attachments) {
                end.surface = (attachment.axes(start.body_states()) * surface).into();
            }
        }
        let motion = touch_motion(&self.joint, start.body_states());
        let beside = beside.filter(|beside| beside.cross(&motion.normal).norm() > ALONG);
        self.tangent = beside.unwrap_or_else(|| tangents(&motion.normal)[0]).into();
        let speed = |body: Option<usize>| {
            let state = body.map(|body| &start.body_states()[body]);
            state.map_or(0.0, |state| {
                state.velocity.norm() + state.angular_velocity.norm() * (motion.point - state.position).norm()
            })
        };
        let [a, b] = self.bodies().map(speed);
        let carried = if self.is_belt { belt(&self.joint, start.body_states(), &motion.normal).norm() } else { 0.0 };
        let given = match self.joint.touch.grip {
            Grip::Slides { direction, .. } => direction,
            Grip::Rolls => Vector3::zeros(),
        };
        self.braking.begin(&motion.slip, a + b + carried, given);
        if let Some(moments) = &mut self.moments {
            let bodies = [self.joint.a.body, self.joint.b.body];
            let spin =
                |body: Option<usize>| body.map_or(Vector3::zeros(), |body| start.body_states()[body].angular_velocity);
            moments.begin(&motion.normal, bodies.map(spin));
        }
        let still = Moved { turn: Matrix::zero(), anchor: Vector::zero() };
        self.place([[&still; 2]; 2]);
        let (normals, tangents) = self.axes();
        if let Some(moments) = &mut self.moments {
            moments.hold(normals, tangents);
        }
    }

    /// The normals at the columns' and the rows' stages, and both tangents there.
    #[inline(always)]
    fn axes(&self) -> ([Vector<V>; 2], [[Vector<V>; 2]; 2]) {
        let tangents = [0, 1].map(|axis: usize| [0, 1].map(|side: usize| self.tangent(axis, side)));
        ([0, 1].map(|side: usize| self.at[side].normal), tangents)
    }

    /// Finds the contact for bodies that have moved so since the start: at the columns' stages (a, b), then at the rows'.
    #[inline(always)]
    pub fn place(&mut self, moved: [[&Moved<V>; 2]; 2]) {
        let Some(pairing) = self.pairing else { return };
        let (ends, bodies) = (&self.ends, self.bodies());
        for (number, (at, moved)) in self.at.iter_mut().zip(moved).enumerate() {
            let of = |side: usize| {
                let end = &ends[side];
                let (origin, axis) = (Vector::splat(&end.point), Vector::splat(&end.axis));
                if bodies[side].is_none() {
                    return Placed { origin: triple(origin), axis: triple(axis) };
                }
                let origin = origin.plus(moved[side].displacement(&end.arm));
                Placed { origin: triple(origin), axis: triple(moved[side].turn(&end.axis)) }
            };
            let (a, b) = (of(0), of(1));
            if number == 0 {
                self.center = vector(b.origin);
            }
            let Contact { gap, normal, point } = contact(pairing, self.joint.touch.side, a, b, || {
                let axis = &ends[1].first_axis;
                triple(if bodies[1].is_none() { Vector::splat(axis) } else { moved[1].turn(axis) })
            });
            (at.gap, at.normal, at.point) = (gap.0, vector(normal), vector(point));
            if self.is_belt {
                at.surfaces = [0, 1].map(|side: usize| match bodies[side] {
                    Some(_) => moved[side].turn(&ends[side].surface),
                    None => Vector::splat(&ends[side].surface),
                });
                let surface = at.surfaces[1].minus(at.surfaces[0]);
                at.belt = at.normal.times_minus(at.normal.dot(surface), surface);
            }
        }
    }

    /// The gradient of the gap at the rows' stages.
    pub fn gradient_of_rows(&self) -> [V; 6] {
        let row = &self.at[1];
        row.normal.joined(row.point.cross(row.normal))
    }

    /// Finds slip, creep and braking in a step of this length (s), after [`SpatialTouch::place`], from the rates of the bodies at its ends and where
    /// their anchors are, both at the columns' and at the rows' stages.
    #[inline(always)]
    pub fn slip(&mut self, mixing: &StageMixing<V>, step: f64, bodies: [Option<BodySides<V>>; 2]) {
        for (side, at) in self.at.iter_mut().enumerate() {
            at.slip = Vector::zero();
            for (body, sign) in bodies.iter().zip([-1.0, 1.0]) {
                if let Some(rates) = body {
                    let (rate, anchor) = &rates[side];
                    at.slip = rate.at(at.point.minus(*anchor)).times_plus(V::splat(sign), at.slip);
                }
            }
        }
        if self.is_belt {
            self.at.iter_mut().for_each(|at| at.slip = at.slip.plus(at.belt));
        }
        match self.joint.touch.grip {
            Grip::Rolls => {
                self.roll(bodies);
                for axis in 0..2 {
                    let along = [0, 1].map(|side: usize| self.tangent(axis, side).dot(self.at[side].slip));
                    self.creep[axis] = mixing.integrate(along) * V::splat(step);
                }
            }
            Grip::Slides { .. } => {
                for side in 0..2 {
                    self.braking.follow(side, self.slipping(side), mixing.active);
                }
            }
        }
    }

    /// Finds rolling and spinning friction, after [`SpatialTouch::slip`], for both kinds of rates of the bodies at its ends, at the columns' and the
    /// rows' stages.
    #[inline(always)]
    pub fn turn(&mut self, mixing: &StageMixing<V>, step: f64, bodies: [Option<&[[BodyRate<V>; 2]; 2]>; 2]) {
        let (normals, tangents) = self.axes();
        if let Some(moments) = &mut self.moments {
            let spin = |kind: usize, side: usize| {
                bodies.map(|rates| rates.map_or(Vector::zero(), |rates| rates[kind][side].spin()))
            };
            let spins = [0, 1].map(|kind: usize| [0, 1].map(|side: usize| spin(kind, side)));
            moments.follow(mixing, step, normals, tangents, spins);
        }
    }

    /// Computes the changes of the rates of a rolling contact besides its gradients, at the columns' stages. For twists η of the bodies
    ///
    /// ```text
    ///     δ vel_b(p) = (η_b(p))˙ + η_ω × (vel_b(p) − ṗ) − ω_b × (η_b(p) − δp)        and the same of a
    /// ```
    ///
    /// where p moves about as the core c of b, `δp = η_b(c)`: exact where n does not turn. Surfaces turn with their bodies, `δw = η_ω × w`.
    #[inline(always)]
    fn roll(&mut self, bodies: [Option<BodySides<V>>; 2]) {
        let AtStages { normal, point, .. } = self.at[0];
        let arm = match self.pairing {
            Some(Pairing { cores: Cores::PlaneRim(_) | Cores::LineRim(_) | Cores::PlaneEllipsoid(_), .. }) => {
                point.minus(self.center)
            }
            Some(Pairing { radius, .. }) => normal.times(V::splat(-radius)),
            None => Vector::zero(),
        };
        let core = point.minus(arm);
        let at_columns = bodies.map(|rates| rates.map(|rates| rates[0]));
        let zero = Vector::zero();
        let spin = at_columns.map(|body| body.map_or(zero, |(rate, _)| rate.spin()));
        let velocity = |side: usize, at: Vector<V>| match at_columns[side] {
            Some((rate, anchor)) => rate.at(at.minus(anchor)),
            None => zero,
        };
        let passes = velocity(0, point).minus(velocity(1, core));
        for axis in 0..2 {
            let along = self.tangent(axis, 0);
            let force = along.cross(spin[0]);
            let of_a = force.joined(point.cross(force).minus(passes.cross(along)));
            let torque = spin[1].cross(arm.cross(along)).minus(core.cross(force));
            self.rolling[axis] = [of_a, zero.minus(force).joined(torque)];
            if self.is_belt {
                let [of_a, of_b] = self.at[0].surfaces.map(|surface| zero.joined(surface.cross(along)));
                let [own_a, own_b] = &mut self.rolling[axis];
                for component in 0..6 {
                    own_a[component] = own_a[component] - of_a[component];
                    own_b[component] = own_b[component] + of_b[component];
                }
            }
        }
    }

    /// For both tangents of a rolling contact the changes of its rates, for the twists of a and of b.
    pub fn rolling(&self) -> [[[V; 6]; 2]; 2] {
        self.rolling
    }

    /// The rates of bodies that its slip takes: the rates of the scheme if it rolls (0), the rates of slips if it slides (1).
    pub fn kind_of_rate(&self) -> usize {
        usize::from(self.joint.touch.grip != Grip::Rolls)
    }

    /// The direction across the slip, `n × t` at p, at the columns' and the rows' stages.
    #[inline(always)]
    pub fn across(&self) -> [[V; 6]; 2] {
        [0, 1].map(|side: usize| {
            let AtStages { normal, point, .. } = self.at[side];
            let across = normal.cross(self.braking.directions()[side]);
            across.joined(point.cross(across))
        })
    }

    /// How friction resists that the slip turns, and where it lags behind, for the multiplier of the gap ([`Braking::turning`]).
    pub fn turning_friction(&self, step: f64, multiplier: V) -> [V; 2] {
        self.braking.turning(self.slipping(1), step, multiplier)
    }

    /// Counts an iteration; whether its friction lagged behind the slip in it.
    pub fn iterated(&mut self) -> bool {
        let turns = self.moments.as_mut().is_some_and(|moments| moments.iterated());
        self.friction() != 0.0 && self.braking.iterated() || turns
    }

    /// The largest speed of its slip at the rows' stages [m/s].
    pub fn fastest(&self) -> f64 {
        self.braking.fastest(self.slipping(1))
    }

    /// Its friction at the end of the step.
    pub fn lean(&self, mixing: &StageMixing<V>) -> Lean {
        let mut lean = match self.friction() {
            0.0 => Lean::default(),
            _ => self.braking.lean(mixing, [self.slipping(0), self.slipping(1)], self.at[0].belt),
        };
        if let Some(moments) = &self.moments {
            moments.lean(mixing, &mut lean);
        }
        lean
    }

    /// Whether its forces exchange energy with what is no body: it has friction, or a surface that is driven.
    pub fn exchanges(&self) -> bool {
        self.brakes() || self.is_belt && self.feels_slip()
    }

    /// Energy that its friction dissipates over the rows ([`Braking::dissipated`]), and the work of the drives of its surfaces, for the multipliers of
    /// its equations.
    #[inline(always)]
    pub fn exchanged(&self, mixing: &StageMixing<V>, multipliers: &[V]) -> Exchange {
        let mut exchange = Exchange::default();
        if self.friction() != 0.0 {
            exchange.friction = self.braking.dissipated(self.slipping(1), mixing, multipliers[0]);
        }
        if let Some(moments) = &self.moments {
            exchange.friction += moments.dissipated(mixing, multipliers[0]);
        }
        if self.is_belt {
            let driven = match self.joint.touch.grip {
                Grip::Slides { .. } => self.braking.of_rows().dot(self.at[1].belt) * multipliers[0],
                Grip::Rolls => {
                    let along = self.carried(1);
                    V::zero() - along[0] * multipliers[1] - along[1] * multipliers[2]
                }
            };
            exchange.work = (driven * mixing.weights).sum();
        }
        exchange
    }

    /// `e · w` of a contact with belts that rolls, along both tangents at the columns' or the rows' stages [m/s]; zero of all others.
    #[inline(always)]
    pub fn carried(&self, side: usize) -> [V; 2] {
        if !self.is_belt || self.joint.touch.grip != Grip::Rolls {
            return [V::zero(); 2];
        }
        [0, 1].map(|axis: usize| self.tangent(axis, side).dot(self.at[side].belt))
    }

    /// A tangent at the columns' or the rows' stages.
    #[inline(always)]
    fn tangent(&self, axis: usize, side: usize) -> Vector<V> {
        let normal = self.at[side].normal;
        let first = Vector::splat(&self.tangent);
        let first = normal.times_minus(normal.dot(first), first);
        let first = first.times(first.dot(first).square_root().reciprocal());
        if axis == 0 { first } else { normal.cross(first) }
    }

    /// Writes its gaps, and its gradients and pushes; beside the gradients at one configuration it pushes as it `leans`, in a step as its
    /// friction says.
    #[inline(always)]
    pub fn write(&self, leans: Option<&Lean>, gaps: &mut [V], gradients: &mut [[[V; 6]; 2]]) {
        if self.pairing.is_none() {
            return;
        }
        if let Some(rope) = &self.rope {
            gaps[0] = rope.gap();
            return;
        }
        gaps[0] = self.at[0].gap;
        let joined = |at: &AtStages<V>, force: Vector<V>| force.joined(at.point.cross(force));
        let [column, row] = &self.at;
        let push = match leans {
            Some(lean) => row.normal.minus(Vector::splat(&lean.along)),
            None => row.normal.minus(self.braking.of_rows()),
        };
        gradients[0] = [joined(column, column.normal), joined(row, push)];
        if let Some(moments) = &self.moments {
            let torque = match leans {
                Some(lean) => Vector::zero().minus(Vector::splat(&lean.torque)),
                None => moments.of_rows(),
            };
            gradients[0][1] = push.joined(row.point.cross_plus(push, torque));
            let held = self.joint.touch.rows();
            moments.write(&mut gaps[held..], &mut gradients[held..]);
        }
        if self.joint.touch.grip == Grip::Rolls {
            for axis in 0..2 {
                gaps[1 + axis] = self.creep[axis];
                gradients[1 + axis] = [0, 1].map(|side: usize| joined(&self.at[side], self.tangent(axis, side)));
            }
        }
    }
}
