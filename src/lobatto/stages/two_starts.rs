//! The starts of two motions of one tree at once, one in each of two lanes: a run and its companion ([`crate::step::carrying`]).
//!
//! The same as [`Start::set`], with poses and velocities as in [`catena_mechanism::motion::kinematics`], in the same order of operations, so that
//! each start has the bits of one that is set alone. For trees under gravity alone that are more than one free body.

use crate::numbers::lanes::Lanes;
use crate::stages::start::{BodyStart, Pivot, Start, units_per_kilogram};
use catena_mechanism::description::body_state::{BodyState, WORLD};
use catena_mechanism::description::joint::{JointKind, sine_cosine};
use catena_mechanism::description::mechanism::{Body, Mechanism};
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::kinematics::joint_rates;
use catena_mechanism::motion::state::State;
use nalgebra::{Matrix3, Vector3};

type Vector<L> = [L; 3];
/// By rows.
type Matrix<L> = [[L; 3]; 3];

/// A body of both motions.
#[derive(Clone, Copy)]
struct Placed<L> {
    position: Vector<L>,
    rotation: Matrix<L>,
    velocity: Vector<L>,
    angular_velocity: Vector<L>,
    com: Vector<L>,
}

/// The starts of a step of two motions, and the starts of the next.
#[derive(Clone)]
pub(crate) struct TwoStarts<L> {
    pub(crate) start: Start<[f64; 2]>,
    end: Start<[f64; 2]>,
    /// Whether `start` has the starts of both motions.
    known: bool,
    placed: Vec<Placed<L>>,
}

impl<L: Lanes<Array = [f64; 2]>> TwoStarts<L> {
    /// Room for a tree.
    pub(crate) fn new(mechanism: &Mechanism) -> Self {
        TwoStarts {
            start: Start::new(mechanism),
            end: Start::new(mechanism),
            known: false,
            placed: vec![Placed::world(); mechanism.bodies.len()],
        }
    }

    /// The next step of both begins at the ends that were taken last, or somewhere else.
    pub(crate) fn accept(&mut self, ends: bool) {
        std::mem::swap(&mut self.start, &mut self.end);
        self.known = ends;
    }

    /// Takes the starts of both motions as they are, unless they are known.
    pub(crate) fn join(&mut self, [first, second]: [&Start; 2]) {
        if std::mem::replace(&mut self.known, true) {
            return;
        }
        let two = |a: f64, b: f64| [a, b];
        fn all<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [[f64; 2]; N] {
            std::array::from_fn(|index| [a[index], b[index]])
        }
        let start = &mut self.start;
        for (own, (a, b)) in start.bodies.iter_mut().zip(first.bodies.iter().zip(&second.bodies)) {
            *own = BodyStart {
                mass: two(a.mass, b.mass),
                arm: all(&a.arm, &b.arm),
                com: all(&a.com, &b.com),
                sigma: all(&a.sigma, &b.sigma),
                velocity: all(&a.velocity, &b.velocity),
                spin: all(&a.spin, &b.spin),
            };
        }
        for (own, (a, b)) in start.pivots.iter_mut().zip(first.pivots.iter().zip(&second.pivots)) {
            *own = Pivot { inertia: two(a.inertia, b.inertia), weights: all(&a.weights, &b.weights) };
        }
        for (own, (a, b)) in start.axes.iter_mut().zip(first.axes.iter().zip(&second.axes)) {
            *own = all(a, b);
        }
        for (own, (&a, &b)) in start.rates.iter_mut().zip(first.rates.iter().zip(&second.rates)) {
            *own = two(a, b);
        }
    }

    /// Takes the states of both motions as the starts of the next step. Does not allocate.
    pub(crate) fn set(&mut self, ends: [&mut Start; 2], mechanism: &Mechanism, states: [&State; 2]) {
        L::apart(
            #[inline(always)]
            || self.take_states(ends, mechanism, states),
        );
    }

    #[inline(always)]
    fn take_states(&mut self, ends: [&mut Start; 2], mechanism: &Mechanism, states: [&State; 2]) {
        let [first, second] = ends;
        let TwoStarts { end: both, placed, .. } = self;
        first.rates.copy_from_slice(&states[0].velocity);
        second.rates.copy_from_slice(&states[1].velocity);
        for (own, (&a, &b)) in both.rates.iter_mut().zip(states[0].velocity.iter().zip(&states[1].velocity)) {
            *own = [a, b];
        }
        let units = [units_per_kilogram(&states[0].velocity), units_per_kilogram(&states[1].velocity)];
        let per_unit = L::from_array(units);
        let (mut kinetic, mut potential) = (L::zero(), L::zero());
        let (half, world) = (L::splat(0.5), Placed::world());
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let joint = &body.joint;
            let parent = body.parent.map_or(&world, |parent| &placed[parent]);
            let On { own, frame, translation, arm } = place(body, parent, states);
            let mut arm = match translation {
                None => arm,
                Some(translation) => {
                    let anchor = joint.on_parent.translation.vector;
                    sum(&times(&parent.rotation, &splat(&anchor)), &times(&frame, &translation))
                }
            };
            if body.parent.is_some() {
                arm = sum(&arm, &parent.com);
            }
            let moments = body.inertia;
            let second_moments = Vector3::repeat(0.5 * moments.sum()) - moments;
            let sigma = turned_diagonal(&own.rotation, &splat(&second_moments));
            let spin = &own.angular_velocity;
            let two = L::splat(2.0);
            // ωᵀ J ω with J = ½ tr J − Σ.
            let spread = (sigma[0] * spin[0] + two * (sigma[1] * spin[1] + sigma[2] * spin[2])) * spin[0]
                + (sigma[3] * spin[1] + two * sigma[4] * spin[2]) * spin[1]
                + sigma[5] * spin[2] * spin[2];
            let mass = L::splat(body.mass);
            let trace = L::splat(0.5 * moments.sum());
            kinetic = kinetic
                + (half * (mass * dot(&own.velocity, &own.velocity)) + half * (trace * dot(spin, spin) - spread));
            potential = potential - mass * dot(&splat(&mechanism.gravity), &own.position);
            let known = BodyStart {
                mass: (mass * per_unit).to_array(),
                arm: arm.map(L::to_array),
                com: own.com.map(L::to_array),
                sigma: sigma.map(|moment| (moment * per_unit).to_array()),
                velocity: own.velocity.map(L::to_array),
                spin: own.angular_velocity.map(L::to_array),
            };
            both.bodies[index] = known;
            first.bodies[index] = alone(&known, 0);
            second.bodies[index] = alone(&known, 1);
            own.write(0, first.body_state_mut(index));
            own.write(1, second.body_state_mut(index));
            placed[index] = own;
            let mut slot = joint.velocity_index;
            for &axis in joint.kind.translation_axes() {
                let axis = [frame[0][axis], frame[1][axis], frame[2][axis]].map(L::to_array);
                write_axis([&mut first.axes[slot], &mut second.axes[slot]], &mut both.axes[slot], axis);
                slot += 1;
            }
            for &axis in joint.kind.rotation_axes() {
                let axis = splat(&joint.on_child.rotation.matrix().column(axis).into_owned());
                let axis = times(&own.rotation, &axis).map(L::to_array);
                write_axis([&mut first.axes[slot], &mut second.axes[slot]], &mut both.axes[slot], axis);
                slot += 1;
            }
        }
        let (kinetic, potential) = (kinetic.to_array(), potential.to_array());
        for (motion, start) in [first, second].into_iter().enumerate() {
            start.units = units[motion];
            start.energy = Energy { kinetic: kinetic[motion], potential: potential[motion], ..Energy::default() };
            start.set_pivots(mechanism);
            for (own, pivot) in both.pivots.iter_mut().zip(&start.pivots) {
                own.inertia[motion] = pivot.inertia;
                for (own, weight) in own.weights.iter_mut().zip(pivot.weights) {
                    own[motion] = weight;
                }
            }
        }
    }
}

impl<L: Lanes<Array = [f64; 2]>> Placed<L> {
    #[inline(always)]
    fn world() -> Self {
        Placed {
            position: [L::zero(); 3],
            rotation: splat_matrix(&WORLD.rotation),
            velocity: [L::zero(); 3],
            angular_velocity: [L::zero(); 3],
            com: [L::zero(); 3],
        }
    }

    /// Writes the body of one of the motions.
    #[inline(always)]
    fn write(&self, motion: usize, state: &mut BodyState) {
        for axis in 0..3 {
            state.position[axis] = self.position[axis].to_array()[motion];
            state.velocity[axis] = self.velocity[axis].to_array()[motion];
            state.angular_velocity[axis] = self.angular_velocity[axis].to_array()[motion];
            for column in 0..3 {
                state.rotation[(axis, column)] = self.rotation[axis][column].to_array()[motion];
            }
        }
    }
}

/// A placed body, with intermediate results.
#[derive(Clone)]
struct On<L> {
    own: Placed<L>,
    /// The joint frame on the parent, in the world.
    frame: Matrix<L>,
    /// The joint's translation, in that frame (m); `None` for a hinge.
    translation: Option<Vector<L>>,
    /// Vector from the parent's centre of mass to the anchor (m).
    arm: Vector<L>,
}

/// Places a body on its parent.
#[inline(always)]
fn place<L: Lanes<Array = [f64; 2]>>(body: &Body, parent: &Placed<L>, states: [&State; 2]) -> On<L> {
    let joint = &body.joint;
    let (slots, rates) = (joint.position_range(), joint.velocity_range());
    let (on_parent, on_child) = (joint.on_parent.rotation.matrix(), joint.on_child.rotation.matrix());
    let (frame_on_parent, frame_on_child) = (splat_matrix::<L>(on_parent), splat_matrix::<L>(on_child));
    let frame = product(&parent.rotation, &frame_on_parent);
    let mut anchor = splat(&joint.on_parent.translation.vector);
    let mut sliding = None;
    let (translation, turned, turning);
    if joint.kind == JointKind::Revolute {
        let [(s0, c0), (s1, c1)] =
            states.map(|state| sine_cosine(state.position[slots.start], state.compensation[slots.start]));
        let (sine, cosine) = (L::from_array([s0, s1]), L::from_array([c0, c1]));
        // The frame times (c, −s, 0; s, c, 0; 0, 0, 1).
        turned = frame.map(|[x, y, z]| [x * cosine + y * sine, y * cosine - x * sine, z]);
        let rate = L::from_array(states.map(|state| state.velocity[rates.start]));
        turning = [frame_on_child[0][2] * rate, frame_on_child[1][2] * rate, frame_on_child[2][2] * rate];
        translation = None;
    } else {
        let of = |motion: usize| {
            let state = states[motion];
            let (positions, rests) = (&state.position[slots.clone()], &state.compensation[slots.clone()]);
            let (translation, turn) = joint.displacement(positions, rests);
            let (translation_rate, turn_rate) = joint_rates(joint, &state.velocity[rates.clone()]);
            (translation, turn, translation_rate, turn_rate)
        };
        let ([first, second], along) = ([of(0), of(1)], |a: &Vector3<f64>, b: &Vector3<f64>| -> Vector<L> {
            std::array::from_fn(|axis| L::from_array([a[axis], b[axis]]))
        });
        let turn: Matrix<L> = std::array::from_fn(|row| {
            std::array::from_fn(|column| L::from_array([first.1[(row, column)], second.1[(row, column)]]))
        });
        turned = product(&frame, &turn);
        let slide = along(&first.0, &second.0);
        anchor = sum(&anchor, &times(&frame_on_parent, &slide));
        sliding = Some(times(&parent.rotation, &times(&frame_on_parent, &along(&first.2, &second.2))));
        turning = times(&frame_on_child, &along(&first.3, &second.3));
        translation = Some(slide);
    }
    let rotation = product_transposed(&turned, &frame_on_child);
    let arm_on_parent = times(&parent.rotation, &anchor);
    let arm_on_child = times(&rotation, &splat(&joint.on_child.translation.vector));
    let angular_velocity = sum(&parent.angular_velocity, &times(&rotation, &turning));
    let carried = sum(&parent.velocity, &cross(&parent.angular_velocity, &arm_on_parent));
    let carried = sliding.map_or(carried, |sliding| sum(&carried, &sliding));
    let own = Placed {
        position: difference(&sum(&parent.position, &arm_on_parent), &arm_on_child),
        rotation,
        velocity: difference(&carried, &cross(&angular_velocity, &arm_on_child)),
        angular_velocity,
        com: arm_on_child.map(|side| -side),
    };
    On { own, frame, translation, arm: arm_on_parent }
}

#[inline(always)]
fn alone(known: &BodyStart<[f64; 2]>, motion: usize) -> BodyStart {
    BodyStart {
        mass: known.mass[motion],
        arm: known.arm.map(|side| side[motion]),
        com: known.com.map(|side| side[motion]),
        sigma: known.sigma.map(|moment| moment[motion]),
        velocity: known.velocity.map(|speed| speed[motion]),
        spin: known.spin.map(|rate| rate[motion]),
    }
}

#[inline(always)]
fn write_axis([first, second]: [&mut [f64; 3]; 2], both: &mut [[f64; 2]; 3], axis: [[f64; 2]; 3]) {
    *both = axis;
    *first = axis.map(|side| side[0]);
    *second = axis.map(|side| side[1]);
}

#[inline(always)]
fn splat<L: Lanes>(v: &Vector3<f64>) -> Vector<L> {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

#[inline(always)]
fn splat_matrix<L: Lanes>(m: &Matrix3<f64>) -> Matrix<L> {
    let row = |i: usize| [L::splat(m[(i, 0)]), L::splat(m[(i, 1)]), L::splat(m[(i, 2)])];
    [row(0), row(1), row(2)]
}

#[inline(always)]
fn sum<L: Lanes>(a: &Vector<L>, b: &Vector<L>) -> Vector<L> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn difference<L: Lanes>(a: &Vector<L>, b: &Vector<L>) -> Vector<L> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<L: Lanes>(a: &Vector<L>, b: &Vector<L>) -> L {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<L: Lanes>(a: &Vector<L>, b: &Vector<L>) -> Vector<L> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn times<L: Lanes>(a: &Matrix<L>, v: &Vector<L>) -> Vector<L> {
    [dot(&a[0], v), dot(&a[1], v), dot(&a[2], v)]
}

/// `A B`.
#[inline(always)]
fn product<L: Lanes>(a: &Matrix<L>, b: &Matrix<L>) -> Matrix<L> {
    let column = |j: usize| [b[0][j], b[1][j], b[2][j]];
    let (x, y, z) = (column(0), column(1), column(2));
    let row = |i: usize| [dot(&a[i], &x), dot(&a[i], &y), dot(&a[i], &z)];
    [row(0), row(1), row(2)]
}

/// `A Bᵀ`.
#[inline(always)]
fn product_transposed<L: Lanes>(a: &Matrix<L>, b: &Matrix<L>) -> Matrix<L> {
    let row = |i: usize| [dot(&a[i], &b[0]), dot(&a[i], &b[1]), dot(&a[i], &b[2])];
    [row(0), row(1), row(2)]
}

/// `R diag(d) Rᵀ`: xx, xy, xz, yy, yz, zz.
#[inline(always)]
fn turned_diagonal<L: Lanes>(rotation: &Matrix<L>, diagonal: &Vector<L>) -> [L; 6] {
    let scaled = |i: usize| [rotation[i][0] * diagonal[0], rotation[i][1] * diagonal[1], rotation[i][2] * diagonal[2]];
    let (x, y, z) = (scaled(0), scaled(1), scaled(2));
    let [i, j, k] = rotation;
    [dot(&x, i), dot(&x, j), dot(&x, k), dot(&y, j), dot(&y, k), dot(&z, k)]
}
