//! The equations of one step of the scheme in joint coordinates, over numbers with derivatives.
//!
//! Unknowns are the displacements of all stages i = 2..s, the velocities v̄ at the end, and the multipliers Λ of closures at all stages. Let
//! z_i = Q_i − q₀ in R¹² a body, and `w_i = z_i − h c_i q̇₀`. Elimination of the momenta from (2.5.11a–g) leaves for the stages k = 1..s−1, and for the
//! end
//!
//! ```text
//!     J(Q_k)ᵀ (M Σ_i B_ki w_i − h² F_k) − h² τ_k − h² G(Q_k)ᵀ Λ_k = 0                                      g(Q_i) = 0
//!     J(q̄)ᵀ (M q̇(v̄) − M q̇₀ − M Σ_i ω_i w_i / h − h b_s F_s) − h b_s τ_s − h b_s G(q̄)ᵀ Λ_s = 0              G(q̄) v̄ = 0
//! ```
//!
//! J: motions that the joints allow; M: the constant mass matrix of R¹², with rotors as masses of coordinates; F: gravity, springs between points,
//! wrenches; τ: efforts in the joints, with springs, and dampers at the rates of the scheme `ẏ_j = ẏ₀ + Σ_i (Ā B)_ji (y_i − y₀ − h c_i ẏ₀)/h`. The
//! coefficients B, ω and Ā B are in [`crate::lobatto::tableau::butcher`]. Held joints keep their places, and their equations are left out.
//!
//! Source: T. M. Tyranowski, PhD thesis, California Institute of Technology, 2014, section 2.5 (`doc/method.md`).

use crate::derivatives::equations::closed::ClosedContacts;
use crate::derivatives::equations::closures::{closures, push as push_closures, with_rates};
use crate::derivatives::equations::figures::{BodyFigures, End, Figures, LoopFigures};
use crate::derivatives::equations::laws::Laws;
use crate::derivatives::equations::placed::{Offsets, Placed, end_frame, place};
use crate::derivatives::equations::residual::{Load, along_freedoms, still};
use crate::derivatives::forward::touching::{BodiesInStep, TouchInStep};
use crate::derivatives::forward::twelve::{Twelve, place_of, rate_of};
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::closure::Coordinate;
use crate::mechanism::motion::state::State;

/// The figures of a mechanism for places, and for places with their rates; and the numbers of its elements.
pub struct BothFigures<T> {
    pub plain: Figures<T>,
    pub moving: Figures<Jet<T>>,
    pub laws: Laws<T>,
}

/// A motor that follows its law: the part that follows the state, `−kp q − kd q̇`.
#[derive(Clone, Copy, Debug)]
pub struct Drive<T> {
    pub coordinate: Coordinate,
    pub kp: T,
    pub kd: T,
}

/// The closures that a mode adds, its motors, and the multipliers.
pub struct InMode<'m, T> {
    pub drives: &'m [Drive<T>],
    pub closed: &'m ClosedContacts<T>,
    /// Λ_1 … Λ_s, an entry for each closure (N).
    pub multipliers: &'m [Vec<T>],
}

/// What the equations of a step are off by.
pub struct Residual<T> {
    /// n for each k = 1..s−1, then n of the end.
    pub motion: Vec<T>,
    /// g at the stages i = 2..s.
    pub closures: Vec<Vec<T>>,
    /// G v̄ at the end.
    pub rates: Vec<T>,
}

/// A step, with everything that its equations depend on.
pub struct StepMotion<'s, T> {
    pub figures: &'s BothFigures<T>,
    pub tableau: &'s Tableau,
    /// h (s).
    pub step: T,
    /// The start; slight offsets of its coordinates, and its velocities (n each).
    pub start: &'s State,
    pub start_offsets: &'s [T],
    pub start_velocities: &'s [T],
    /// The stages i = 2..s, and slight offsets of each (n).
    pub stages: &'s [State],
    pub offsets: &'s [Vec<T>],
    /// v̄ (n).
    pub end_velocities: &'s [T],
    /// Efforts from outside at all stages i = 1..s (n each) [N m or N].
    pub efforts: &'s [Vec<T>],
    pub mode: InMode<'s, T>,
}

/// What forces at a stage depend on.
struct AtStage<'s, T> {
    stage: usize,
    placed: &'s [Vec<Placed<T>>],
    started: &'s [Placed<Jet<T>>],
    touches: &'s [TouchInStep<T>],
}

impl<T: Number> StepMotion<'_, T> {
    /// The residuals.
    pub fn residual(&self) -> Residual<T> {
        let (s, h) = (self.tableau.stages, self.step);
        let unmoved = vec![T::zero(); self.start_velocities.len()];
        let started = self.place_moving(self.start, &unmoved, self.start_velocities);
        let begin: Vec<Twelve<T>> = started.iter().map(place_of).collect();
        let rates: Vec<Twelve<T>> = started.iter().map(rate_of).collect();
        let mut placed = vec![still(&started)];
        for (stage, offsets) in self.stages.iter().zip(self.offsets) {
            placed.push(place(&self.figures.plain, &self.at(stage, offsets)));
        }
        // w_i of all bodies.
        let ahead: Vec<Vec<Twelve<T>>> = (1..s)
            .map(|i| {
                let gone = h.times(self.tableau.nodes[i]);
                let of = |body: usize| {
                    let at = &placed[i][body].frame;
                    let z = Twelve { origin: at.origin, axes: at.axes }.minus(&begin[body]);
                    z.minus(&rates[body].scaled(gone))
                };
                (0..begin.len()).map(of).collect()
            })
            .collect();
        let bodies = BodiesInStep {
            tableau: self.tableau,
            bodies: &self.figures.plain.bodies,
            step: h,
            started: &started,
            placed: &placed,
            rates: &rates,
            ahead: &ahead,
        };
        let touches: Vec<TouchInStep<T>> = self.mode.closed.touches.iter().map(|closed| bodies.touch(closed)).collect();
        let mixed = |weights: &dyn Fn(usize) -> f64, body: usize| {
            let mut sum = Twelve::zero();
            for (i, ahead) in ahead.iter().enumerate() {
                sum = sum.plus(&ahead[body].scaled(T::of(weights(i))));
            }
            sum
        };
        let mut efforts = self.efforts_at_stages();
        let rotors = self.rotors_ahead();
        let square = h * h;
        let mut rows = Vec::with_capacity(s * self.start_velocities.len());
        for k in 0..s - 1 {
            let weights = |i: usize| self.tableau.b_matrix[k * (s - 1) + i];
            let mut loads: Vec<Load<T>> = (0..begin.len())
                .map(|body| {
                    momentum(&self.figures.plain.bodies[body], &placed[k][body].frame.axes, &mixed(&weights, body))
                })
                .collect();
            let at = AtStage { stage: k, placed: &placed, started: &started, touches: &touches };
            self.add_forces(&at, -square, &mut loads, &mut efforts[k]);
            let mut along = along_freedoms(&self.figures.plain, &placed[k], loads);
            for (&(freedom, armature), ahead) in self.figures.plain.rotors.iter().zip(&rotors) {
                along[freedom] = along[freedom] + armature * weighted(ahead, &weights);
            }
            rows.extend(along.into_iter().zip(&efforts[k]).map(|(row, &effort)| row - square * effort));
        }
        let ended = self.ended();
        let last = h.times(self.tableau.weights[s - 1]);
        let weights = |i: usize| self.tableau.momentum_weights[i];
        let mut loads: Vec<Load<T>> = (0..begin.len())
            .map(|body| {
                let gained = mixed(&weights, body).scaled(T::of(1.0) / h);
                let rate = rate_of(&ended[body]).minus(&rates[body]).minus(&gained);
                momentum(&self.figures.plain.bodies[body], &placed[s - 1][body].frame.axes, &rate)
            })
            .collect();
        let at = AtStage { stage: s - 1, placed: &placed, started: &started, touches: &touches };
        self.add_forces(&at, -last, &mut loads, &mut efforts[s - 1]);
        let mut along = along_freedoms(&self.figures.plain, &placed[s - 1], loads);
        for (&(freedom, armature), ahead) in self.figures.plain.rotors.iter().zip(&rotors) {
            let gained = weighted(ahead, &weights) / h;
            let rate = self.end_velocities[freedom] - self.start_velocities[freedom] - gained;
            along[freedom] = along[freedom] + armature * rate;
        }
        rows.extend(along.into_iter().zip(&efforts[s - 1]).map(|(row, &effort)| row - last * effort));
        Residual { motion: rows, closures: self.closures(&placed, &touches), rates: self.closure_rates(&ended) }
    }

    /// g at the stages i = 2..s.
    fn closures(&self, placed: &[Vec<Placed<T>>], touches: &[TouchInStep<T>]) -> Vec<Vec<T>> {
        let stages = self.stages.iter().zip(self.offsets).zip(&placed[1..]);
        let of = |((stage, offsets), placed): ((&State, &Vec<T>), &Vec<Placed<T>>)| {
            closures(&self.figures.plain, &self.mode.closed.anchors, placed, &self.at(stage, offsets))
        };
        let mut all: Vec<Vec<T>> = stages.map(of).collect();
        for (stage, rows) in all.iter_mut().enumerate() {
            touches.iter().for_each(|touch| rows.extend(&touch.rows[stage]));
        }
        all
    }

    /// The bodies at the end, with v̄.
    fn ended(&self) -> Vec<Placed<Jet<T>>> {
        let last = self.stages.len() - 1;
        self.place_moving(&self.stages[last], &self.offsets[last], self.end_velocities)
    }

    /// G v̄ at the end, of all closures.
    pub fn rates_at_end(&self) -> Vec<T> {
        self.closure_rates(&self.ended())
    }

    fn closure_rates(&self, ended: &[Placed<Jet<T>>]) -> Vec<T> {
        let Some(end) = self.stages.last() else { return Vec::new() };
        let anchors: Vec<LoopFigures<Jet<T>>> = self.mode.closed.anchors.iter().map(with_rates).collect();
        let jets = |values: &[T], rate: bool| -> Vec<Jet<T>> {
            let zero = T::zero();
            let jet = |&of: &T| {
                let (value, rate) = if rate { (zero, of) } else { (of, zero) };
                Jet { value, rate, acceleration: zero }
            };
            values.iter().map(jet).collect()
        };
        let first = jets(self.start_offsets, false);
        let second = jets(self.offsets.last().map_or(&[], Vec::as_slice), false);
        let motion = jets(self.end_velocities, true);
        let offsets = Offsets { from: self.start, to: end, first: &first, second: &second, motion: &motion };
        let rows = closures(&self.figures.moving, &anchors, ended, &offsets);
        let touches = self.mode.closed.touches.iter();
        rows.into_iter().map(|row| row.rate).chain(touches.flat_map(|closed| closed.rates(ended))).collect()
    }

    /// w_i of the coordinates of all rotors, at the stages i = 2..s.
    fn rotors_ahead(&self) -> Vec<Vec<T>> {
        let plain = &self.figures.plain;
        let zero = vec![T::zero(); plain.freedoms];
        let of = |&(freedom, _): &(usize, T)| {
            let Some(position) = position_of(plain, freedom) else { return vec![T::zero(); self.stages.len()] };
            let begin = self.at(self.start, &zero).scalar(position, freedom);
            let gone = |i: usize| self.step.times(self.tableau.nodes[i + 1]) * self.start_velocities[freedom];
            let stages = self.stages.iter().zip(self.offsets).enumerate();
            let ahead = |(i, (stage, offsets)): (usize, (&State, &Vec<T>))| {
                self.at(stage, offsets).scalar(position, freedom) - begin - gone(i)
            };
            stages.map(ahead).collect()
        };
        plain.rotors.iter().map(of).collect()
    }

    fn at<'o>(&'o self, stage: &'o State, offsets: &'o [T]) -> Offsets<'o, T> {
        Offsets { from: self.start, to: stage, first: self.start_offsets, second: offsets, motion: &[] }
    }

    /// Bodies with their rates at an end of the step.
    fn place_moving(&self, stage: &State, offsets: &[T], velocities: &[T]) -> Vec<Placed<Jet<T>>> {
        let zero = T::zero();
        let constant = |&value: &T| Jet { value, rate: zero, acceleration: zero };
        let first: Vec<Jet<T>> = self.start_offsets.iter().map(constant).collect();
        let second: Vec<Jet<T>> = offsets.iter().map(constant).collect();
        let motion: Vec<Jet<T>> =
            velocities.iter().map(|&rate| Jet { value: zero, rate, acceleration: zero }).collect();
        let offsets = Offsets { from: self.start, to: stage, first: &first, second: &second, motion: &motion };
        place(&self.figures.moving, &offsets)
    }

    /// Efforts in the joints at all stages, with springs and dampers.
    fn efforts_at_stages(&self) -> Vec<Vec<T>> {
        let plain = &self.figures.plain;
        let mut efforts = self.efforts.to_vec();
        let zero = vec![T::zero(); plain.freedoms];
        let at_stage = |stage: usize| match stage {
            0 => self.at(self.start, &zero),
            later => self.at(&self.stages[later - 1], &self.offsets[later - 1]),
        };
        for spring in &plain.springs {
            for (stage, efforts) in efforts.iter_mut().enumerate() {
                let stretch = at_stage(stage).coordinate(spring.coordinate) - spring.rest;
                let freedom = spring.coordinate.freedom;
                efforts[freedom] = efforts[freedom] - spring.stiffness * stretch;
            }
        }
        for drive in self.mode.drives {
            for (stage, efforts) in efforts.iter_mut().enumerate() {
                let freedom = drive.coordinate.freedom;
                efforts[freedom] = efforts[freedom] - drive.kp * at_stage(stage).coordinate(drive.coordinate);
            }
        }
        let driven = self.mode.drives.iter().map(|drive| (drive.coordinate.freedom, drive.kd));
        for (freedom, coefficient) in plain.dampers.iter().copied().chain(driven) {
            let Some(position) = position_of(plain, freedom) else { continue };
            let along = |stage: usize| at_stage(stage).scalar(position, freedom);
            let values: Vec<T> = (0..self.tableau.stages).map(along).collect();
            for (stage, rate) in self.rates(&values, self.start_velocities[freedom]).into_iter().enumerate() {
                efforts[stage][freedom] = efforts[stage][freedom] - coefficient * rate;
            }
        }
        for &(freedom, effort) in &plain.loads {
            efforts.iter_mut().for_each(|efforts| efforts[freedom] = efforts[freedom] + effort);
        }
        efforts
    }

    /// `ẏ_1 … ẏ_s` of a scalar with these values at the stages and this rate at the start.
    fn rates(&self, values: &[T], start_rate: T) -> Vec<T> {
        let (s, h) = (self.tableau.stages, self.step);
        let ahead: Vec<T> =
            (1..s).map(|i| values[i] - values[0] - h.times(self.tableau.nodes[i]) * start_rate).collect();
        (0..s)
            .map(|j| {
                let sum = ahead
                    .iter()
                    .enumerate()
                    .fold(T::zero(), |sum, (i, &ahead)| sum + ahead.times(self.tableau.velocity[j * (s - 1) + i]));
                start_rate + sum / h
            })
            .collect()
    }

    /// Adds `factor · F` of a stage (0 is the start) to loads, with the forces of closures.
    fn add_forces(&self, at: &AtStage<T>, factor: T, loads: &mut [Load<T>], efforts: &mut [T]) {
        let &AtStage { stage, placed, started, touches } = at;
        let plain = &self.figures.plain;
        let gravity = plain.gravity.scaled(factor);
        for ((load, body), at) in loads.iter_mut().zip(&plain.bodies).zip(&placed[stage]) {
            load.force = load.force + gravity.scaled(body.mass);
            load.torque = load.torque + at.frame.axes.apply(body.moment).cross(gravity);
        }
        let mut push = |body: Option<usize>, arm: Vector<T>, force: Vector<T>, torque: Vector<T>| {
            if let Some(load) = body.map(|body| &mut loads[body]) {
                load.force = load.force + force.scaled(factor);
                load.torque = load.torque + (arm.cross(force) + torque).scaled(factor);
            }
        };
        for (number, spring) in plain.point_springs.iter().enumerate() {
            let gap = |placed: &[Placed<T>]| end_frame(&spring.b, placed).origin - end_frame(&spring.a, placed).origin;
            let lengths: Vec<T> = placed.iter().map(|placed| gap(placed).dot(gap(placed)).square_root()).collect();
            let rate = self.rates(&lengths, self.start_rate_of_spring(number, started))[stage];
            let tension = spring.stiffness * (lengths[stage] - spring.rest_length) + spring.damping * rate;
            let pull = gap(&placed[stage]).scaled(tension / lengths[stage]);
            let arm = |end: &End<T>| match end.body {
                Some(body) => end_frame(end, &placed[stage]).origin - placed[stage][body].frame.origin,
                None => Vector::zero(),
            };
            push(spring.a.body, arm(&spring.a), pull, Vector::zero());
            push(spring.b.body, arm(&spring.b), -pull, Vector::zero());
        }
        for wrench in &plain.wrenches {
            let arm = placed[stage][wrench.body].frame.axes.apply(wrench.point);
            push(Some(wrench.body), arm, wrench.force, wrench.torque);
        }
        let (closed, multipliers) = (self.mode.closed, &self.mode.multipliers[stage]);
        let (multipliers, of_touches) = multipliers.split_at(multipliers.len() - closed.touch_rows());
        let mut on_body = |body: Option<usize>, point: Vector<T>, force: Vector<T>, torque: Vector<T>| {
            let arm = body.map_or_else(Vector::zero, |body| point - placed[stage][body].frame.origin);
            push(body, arm, force, torque);
        };
        let mut on_freedom = |freedom: usize, effort: T| efforts[freedom] = efforts[freedom] + effort;
        let of_touches = closed.shared(of_touches);
        let mut own = of_touches.iter();
        for touch in touches {
            let along = touch.pushes[stage].iter().zip(own.by_ref());
            let force = along.fold(Vector::zero(), |sum, (along, &size)| sum + along.scaled(size));
            let [a, b] = touch.bodies;
            on_body(a, touch.points[stage], -force, Vector::zero());
            on_body(b, touch.points[stage], force, Vector::zero());
        }
        push_closures(plain, &closed.anchors, &placed[stage], multipliers, &mut on_body, &mut on_freedom);
    }

    fn start_rate_of_spring(&self, number: usize, started: &[Placed<Jet<T>>]) -> T {
        let spring = &self.figures.moving.point_springs[number];
        let gap = end_frame(&spring.b, started).origin - end_frame(&spring.a, started).origin;
        gap.dot(gap).square_root().rate
    }
}

/// The entry of the positions for a scalar degree of freedom.
pub(in crate::derivatives) fn position_of<T>(figures: &Figures<T>, freedom: usize) -> Option<usize> {
    let body = figures.bodies.iter().rfind(|body| body.velocity_index <= freedom)?;
    Some(body.position_index + freedom - body.velocity_index)
}

/// Σ_i weight_i w_i of a scalar.
fn weighted<T: Number>(ahead: &[T], weights: &dyn Fn(usize) -> f64) -> T {
    ahead.iter().enumerate().fold(T::zero(), |sum, (i, ahead)| sum + ahead.times(weights(i)))
}

/// `M w` as a load on a body whose axes are known.
pub(in crate::derivatives) fn momentum<T: Number>(body: &BodyFigures<T>, axes: &Matrix<T>, w: &Twelve<T>) -> Load<T> {
    let force = w.origin.scaled(body.mass) + w.axes.apply(body.moment);
    let mut torque = Vector::zero();
    for (column, axis) in axes.0.iter().enumerate() {
        let pull = w.origin.scaled(body.moment.0[column]) + w.axes.apply(body.second_moments.0[column]);
        torque = torque + axis.cross(pull);
    }
    Load { force, torque }
}
