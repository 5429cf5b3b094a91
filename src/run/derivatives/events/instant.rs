//! A mechanism at one instant, over numbers with derivatives: momenta, and accelerations with the efforts that hold joints.
//!
//! ```text
//!     ρ(q, v, a) − τ − Gᵀ λ = 0  along the freedoms that move,      g̈(q, v, a) = 0,      a = 0 of held joints
//!     λ_held = ρ(q, v, a) − τ − Gᵀ λ   along the freedoms that are held
//! ```
//!
//! ρ, τ: as in [`crate::derivatives::equations::residual`], with motors that follow their laws (N m or N).

use crate::derivatives::equations::closed::{ClosedContacts, ClosedTouch};
use crate::derivatives::equations::closures::{closures, push, with_rates};
use crate::derivatives::equations::figures::LoopFigures;
use crate::derivatives::equations::placed::{Offsets, Placed, place};
use crate::derivatives::equations::residual::{Load, along_freedoms, residual, still};
use crate::derivatives::forward::elimination::Elimination;
use crate::derivatives::forward::stage_equations::{BothFigures, Drive, momentum};
use crate::derivatives::forward::step::{Part, StepMode, WIDTH, constant};
use crate::derivatives::forward::twelve::{Twelve, rate_of};
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::mechanism::motion::state::State;
use nalgebra::DMatrix;

/// A mechanism at an instant.
#[derive(Clone, Copy)]
pub struct Instant<'i, T> {
    pub figures: &'i BothFigures<T>,
    pub state: &'i State,
    /// Slight offsets of the coordinates (n).
    pub offsets: &'i [T],
    pub closed: &'i ClosedContacts<T>,
}

/// Motion equations and second derivatives of closures.
struct Equations<T> {
    motion: Vec<T>,
    closures: Vec<T>,
}

/// The motion at an instant that the equations are for.
#[derive(Clone, Copy)]
pub struct Moved<'m, T> {
    /// v and a (n).
    pub velocities: &'m [T],
    pub accelerations: &'m [T],
    /// λ, an entry for each closure.
    pub multipliers: &'m [T],
    /// Efforts from outside (n) [N m or N].
    pub efforts: &'m [T],
    pub drives: &'m [Drive<T>],
}

impl<T: Number> Instant<'_, T> {
    fn jets(&self, rates: &[T], accelerations: &[T]) -> [Vec<Jet<T>>; 2] {
        let zero = T::zero();
        let first = self.offsets.iter().map(|&value| Jet { value, rate: zero, acceleration: zero }).collect();
        let second =
            rates.iter().zip(accelerations).map(|(&rate, &acceleration)| Jet { value: zero, rate, acceleration });
        [first, second.collect()]
    }

    /// The bodies with these velocities (n).
    pub fn placed(&self, velocities: &[T]) -> Vec<Placed<Jet<T>>> {
        let [first, second] = self.jets(velocities, &vec![T::zero(); velocities.len()]);
        place(&self.figures.moving, &self.offsets_of(&first, &second))
    }

    /// The bodies with these velocities and accelerations (n each).
    pub fn accelerated(&self, velocities: &[T], accelerations: &[T]) -> Vec<Placed<Jet<T>>> {
        let [first, second] = self.jets(velocities, accelerations);
        place(&self.figures.moving, &self.offsets_of(&first, &second))
    }

    fn offsets_of<'o>(&'o self, first: &'o [Jet<T>], second: &'o [Jet<T>]) -> Offsets<'o, Jet<T>> {
        Offsets { from: self.state, to: self.state, first, second, motion: &[] }
    }

    /// The bodies without motion.
    pub fn at_rest(&self) -> Vec<Placed<T>> {
        let still = vec![T::zero(); self.offsets.len()];
        let (from, to) = (self.state, self.state);
        place(&self.figures.plain, &Offsets { from, to, first: self.offsets, second: &still, motion: &[] })
    }

    /// `M v`: the momenta along the freedoms of velocities (n).
    pub fn momenta(&self, velocities: &[T]) -> Vec<T> {
        let placed = self.placed(velocities);
        self.momenta_of(&placed, velocities, &|body| rate_of(&placed[body]))
    }

    /// `M (v⁺ − v⁻)`, from the bodies with both velocities.
    pub fn momenta_gained(&self, placed: [&[Placed<Jet<T>>]; 2], velocities: [&[T]; 2]) -> Vec<T> {
        let gained: Vec<T> = velocities[1].iter().zip(velocities[0]).map(|(&after, &before)| after - before).collect();
        let rate = |body: usize| rate_of(&placed[1][body]).minus(&rate_of(&placed[0][body]));
        self.momenta_of(placed[1], &gained, &rate)
    }

    fn momenta_of(&self, placed: &[Placed<Jet<T>>], velocities: &[T], rate: &dyn Fn(usize) -> Twelve<T>) -> Vec<T> {
        let plain = &self.figures.plain;
        let placed = still(placed);
        let bodies = plain.bodies.iter().enumerate();
        let loads = bodies.map(|(index, body)| momentum(body, &placed[index].frame.axes, &rate(index)));
        let mut rows = along_freedoms(plain, &placed, loads.collect());
        for &(freedom, armature) in &plain.rotors {
            rows[freedom] = rows[freedom] + armature * velocities[freedom];
        }
        rows
    }

    /// G v of velocities (n).
    pub fn closure_rates(&self, velocities: &[T]) -> Vec<T> {
        let plain = &self.figures.plain;
        if plain.loops.is_empty() && plain.mimics.is_empty() && self.closed.is_empty() {
            return Vec::new();
        }
        let [first, second] = self.jets(velocities, &vec![T::zero(); velocities.len()]);
        let anchors: Vec<LoopFigures<Jet<T>>> = self.closed.anchors.iter().map(with_rates).collect();
        let offsets = self.offsets_of(&first, &second);
        let placed = place(&self.figures.moving, &offsets);
        let rows = closures(&self.figures.moving, &anchors, &placed, &offsets).into_iter().map(|row| row.rate);
        rows.chain(self.closed.touches.iter().flat_map(|closed| closed.rates(&placed))).collect()
    }

    /// g of all closures; of touches that roll the gaps alone.
    pub fn gaps(&self) -> Vec<T> {
        let zero = vec![T::zero(); self.offsets.len()];
        let [first, second] = self.jets(&zero, &zero);
        let anchors: Vec<LoopFigures<Jet<T>>> = self.closed.anchors.iter().map(with_rates).collect();
        let offsets = self.offsets_of(&first, &second);
        let placed = place(&self.figures.moving, &offsets);
        let rows = closures(&self.figures.moving, &anchors, &placed, &offsets).into_iter().map(|row| row.value);
        let bodies = still(&placed);
        let gap = |closed: &ClosedTouch<T>| {
            let mut rows = vec![T::zero(); closed.rows()];
            rows[0] = closed.touch.at(&bodies).gap;
            rows
        };
        rows.chain(self.closed.touches.iter().flat_map(gap)).collect()
    }

    /// The efforts along the freedoms of multipliers, for the slips of moving bodies, and of forces on bodies at points of the world.
    pub fn pushes(
        &self,
        moving: &[Placed<Jet<T>>],
        multipliers: &[T],
        forces: &[(Option<usize>, Vector<T>, Vector<T>)],
    ) -> Vec<T> {
        let plain = &self.figures.plain;
        if multipliers.is_empty() && forces.is_empty() {
            return vec![T::zero(); plain.freedoms];
        }
        let placed = still(moving);
        let mut loads = vec![Load { force: Vector::zero(), torque: Vector::zero() }; placed.len()];
        let mut efforts = vec![T::zero(); plain.freedoms];
        let mut on_body = |body: Option<usize>, point: Vector<T>, force: Vector<T>, torque: Vector<T>| {
            if let Some(body) = body {
                let arm = point - placed[body].frame.origin;
                loads[body].force = loads[body].force + force;
                loads[body].torque = loads[body].torque + torque + arm.cross(force);
            }
        };
        forces.iter().for_each(|&(body, point, force)| on_body(body, point, force, Vector::zero()));
        let mut on_freedom = |freedom: usize, effort: T| efforts[freedom] = efforts[freedom] + effort;
        let (multipliers, own) = multipliers.split_at(multipliers.len() - self.closed.touch_rows());
        let own = self.closed.shared(own);
        let mut own = &own[..];
        for closed in &self.closed.touches {
            let found = closed.force(moving, own);
            own = &own[closed.rows()..];
            let [a, b] = found.bodies;
            on_body(a, found.point, -found.force, Vector::zero());
            on_body(b, found.point, found.force, Vector::zero());
        }
        push(plain, &self.closed.anchors, &placed, multipliers, &mut on_body, &mut on_freedom);
        let along = along_freedoms(plain, &placed, loads);
        along.into_iter().zip(efforts).map(|(one, other)| one + other).collect()
    }

    fn equations(&self, moved: &Moved<T>) -> Equations<T> {
        let [first, second] = self.jets(moved.velocities, moved.accelerations);
        let offsets = self.offsets_of(&first, &second);
        let placed = place(&self.figures.moving, &offsets);
        let mut motion = residual(&self.figures.moving, &placed, &offsets);
        for (row, &effort) in motion.iter_mut().zip(moved.efforts) {
            *row = *row - effort;
        }
        for drive in moved.drives {
            let freedom = drive.coordinate.freedom;
            let position = offsets.coordinate(drive.coordinate).value;
            motion[freedom] = motion[freedom] + drive.kp * position + drive.kd * moved.velocities[freedom];
        }
        for (row, push) in motion.iter_mut().zip(self.pushes(&placed, moved.multipliers, &[])) {
            *row = *row - push;
        }
        let anchors: Vec<LoopFigures<Jet<T>>> = self.closed.anchors.iter().map(with_rates).collect();
        let closures = closures(&self.figures.moving, &anchors, &placed, &offsets);
        let touches = self.closed.touches.iter().flat_map(|closed| closed.accelerations(&placed));
        Equations { motion, closures: closures.into_iter().map(|row| row.acceleration).chain(touches).collect() }
    }

    /// Efforts along all freedoms that the motion needs besides those that act: zero along those that move, λ along those that are held.
    pub fn lacking(&self, moved: &Moved<T>) -> Vec<T> {
        self.equations(moved).motion
    }
}

/// The accelerations of a state, with their matrix.
pub struct Accelerations {
    /// a (n).
    pub values: Vec<f64>,
    /// λ, an entry for each closure.
    pub multipliers: Vec<f64>,
    factors: Elimination,
}

impl Accelerations {
    /// Of a state with velocities v under efforts (n), with constant figures; `None` if some motion moves no mass.
    pub fn of(figures: &BothFigures<Part>, state: &State, mode: &StepMode, efforts: &[f64]) -> Option<Self> {
        let n = state.velocity.len();
        let still = vec![Part::zero(); n];
        let at = Instant { figures, state, offsets: &still, closed: &mode.constant };
        let (velocities, efforts): (Vec<Part>, Vec<Part>) = (constant(&state.velocity), constant(efforts));
        let drives = mode.drives(&figures.laws);
        let (free, count) = (mode.free.len(), mode.free.len() + mode.rows.len());
        let mut matrix = DMatrix::zeros(count, count);
        let mut right = vec![0.0; count];
        for first in (0..count).step_by(WIDTH) {
            let mut accelerations = vec![Part::zero(); n];
            let mut multipliers = vec![Part::zero(); mode.row_count];
            for part in 0..WIDTH.min(count - first) {
                match mode.free.get(first + part) {
                    Some(&freedom) => accelerations[freedom] = Part::parameter(0.0, part),
                    None => multipliers[mode.rows[first + part - free]] = Part::parameter(0.0, part),
                }
            }
            let moved = Moved {
                velocities: &velocities,
                accelerations: &accelerations,
                multipliers: &multipliers,
                efforts: &efforts,
                drives: &drives,
            };
            for (row, value) in selected(mode, &at.equations(&moved)).into_iter().enumerate() {
                right[row] = -value.value;
                (0..WIDTH.min(count - first)).for_each(|part| matrix[(row, first + part)] = value.parts[part]);
            }
        }
        let factors = Elimination::new(&matrix)?;
        let found = factors.solve(&right);
        let (mut values, mut multipliers) = (vec![0.0; n], vec![0.0; mode.row_count]);
        mode.free.iter().zip(found.iter()).for_each(|(&freedom, &value)| values[freedom] = value);
        mode.rows.iter().zip(found.iter().skip(free)).for_each(|(&row, &value)| multipliers[row] = value);
        Some(Accelerations { values, multipliers, factors })
    }

    /// a without its derivatives (n).
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// a and λ with their derivatives, for a state, velocities and efforts with theirs; `None` if the factors are singular.
    pub fn varied(
        &self,
        at: &Instant<Part>,
        mode: &StepMode,
        velocities: &[Part],
        efforts: &[Part],
    ) -> Option<(Vec<Part>, Vec<Part>)> {
        let mut accelerations: Vec<Part> = constant(&self.values);
        let mut multipliers: Vec<Part> = constant(&self.multipliers);
        let drives = mode.drives(&at.figures.laws);
        let moved =
            Moved { velocities, accelerations: &accelerations, multipliers: &multipliers, efforts, drives: &drives };
        let rows = selected(mode, &at.equations(&moved));
        let right = DMatrix::from_fn(rows.len(), WIDTH, |row, part| -rows[row].parts[part]);
        let found = self.factors.solve_all(&right);
        for (row, &freedom) in mode.free.iter().enumerate() {
            (0..WIDTH).for_each(|part| accelerations[freedom].parts[part] = found[(row, part)]);
        }
        for (row, &closure) in mode.rows.iter().enumerate() {
            (0..WIDTH).for_each(|part| multipliers[closure].parts[part] = found[(mode.free.len() + row, part)]);
        }
        Some((accelerations, multipliers))
    }
}

/// The equations of the freedoms that move, and of independent closures.
fn selected(mode: &StepMode, equations: &Equations<Part>) -> Vec<Part> {
    let motion = mode.free.iter().map(|&freedom| equations.motion[freedom]);
    motion.chain(mode.rows.iter().map(|&row| equations.closures[row])).collect()
}
