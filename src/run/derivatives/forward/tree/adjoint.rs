//! The transpose of [`crate::derivatives::forward::tree::column`]: what a weighted sum of the equations of a step depends on, all numbers at once.
//!
//! With weights μ of the rows, Y is the motion `Σ_r μ_r s_r` of a body in a stage, and A the 12 numbers of its velocity field:
//!
//! ```text
//!     Σ_r μ_r s_r · ∫ f = ∫ (a + Α u) · (w + Ω u) dm        cotangents    of m: a·w    of p: Ωᵀ a + Αᵀ w    of P: Αᵀ Ω
//!                                                            of (w, Ω): the momentum of A
//! ```
//!
//! From the forces they go on to the parts of the motion along the step, and from there to frames, coordinates and velocities, against the order in
//! which a column is computed.

use crate::derivatives::equations::figures::BodyFigures;
use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::spatial::{Forces, NOUGHT, Twist, trace, transposed};
use crate::derivatives::forward::tree::course::{Course, FrameCourse, FreedomCourse};
use crate::derivatives::forward::tree::displaced::{Displaced, JointCotangents};
use crate::derivatives::forward::tree::step::TreeStep;
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use nalgebra::DVector;

/// Cotangents of what is given in a step.
pub(in crate::derivatives) struct Cotangents {
    /// Of the start (n each).
    pub positions: Vec<f64>,
    pub velocities: Vec<f64>,
    /// Of h.
    pub longer: f64,
    /// Of the efforts from outside at all stages (n each).
    pub efforts: Vec<Vec<f64>>,
}

/// Cotangents of constant numbers, summed over steps.
#[derive(Clone, Debug)]
pub(in crate::derivatives) struct FigureCotangents {
    gravity: Vector<f64>,
    /// m, p and P of each body.
    inertial: Vec<(f64, Vector<f64>, Matrix<f64>)>,
    /// The frames of its joint; empty if none varies.
    frames: Vec<[Twist; 2]>,
}

impl FigureCotangents {
    /// Zero, of a number of bodies, for parameters with these derivatives of figures.
    pub fn zero(bodies: usize, slopes: &[Option<FigureSlopes>]) -> Self {
        let varies = slopes.iter().flatten().any(|slopes| slopes.frames().is_some());
        FigureCotangents {
            gravity: NOUGHT,
            inertial: vec![(0.0, NOUGHT, Matrix([NOUGHT; 3])); bodies],
            frames: vec![[Twist::NONE; 2]; if varies { bodies } else { 0 }],
        }
    }

    /// The derivative by a parameter.
    pub fn by(&self, slopes: &FigureSlopes) -> f64 {
        let mut sum = self.gravity.dot(slopes.plain.gravity);
        for ((mass, moment, second), body) in self.inertial.iter().zip(slopes.inertial()) {
            let Some(body) = body else { continue };
            sum += mass * body.mass + moment.dot(body.moment) + product(second, &body.second_moments);
        }
        let frames = slopes.frames().into_iter().flatten();
        for (own, by) in self.frames.iter().zip(frames) {
            sum += own.iter().zip(by).map(|(own, by)| own.dot(by)).sum::<f64>();
        }
        sum
    }
}

/// The sum of the products of all entries.
fn product(one: &Matrix<f64>, other: &Matrix<f64>) -> f64 {
    one.0[0].dot(other.0[0]) + one.0[1].dot(other.0[1]) + one.0[2].dot(other.0[2])
}

/// The cotangent of a motion that carries another one, where the power of the change on (F, N) counts.
fn of_carrier(carried: &Twist, force: Vector<f64>, torque: Vector<f64>) -> Twist {
    Twist { turn: carried.shift.cross(force) + carried.turn.cross(torque), shift: carried.turn.cross(force) }
}

/// The cotangent of a motion of a place.
fn of_motion(place: &Twelve<f64>, own: &Twelve<f64>) -> Twist {
    let of_axis = |c: usize| place.axes.0[c].cross(own.axes.0[c]);
    let turn = place.origin.cross(own.origin) + of_axis(0) + of_axis(1) + of_axis(2);
    Twist { turn, shift: own.origin }
}

/// The momentum of (w, Ω) of a body.
fn momentum(body: &BodyFigures<f64>, of: &Twelve<f64>) -> Twelve<f64> {
    let axis = |c: usize| of.origin.scaled(body.moment.0[c]) + of.axes.apply(body.second_moments.0[c]);
    let axes = Matrix([axis(0), axis(1), axis(2)]);
    Twelve { origin: of.origin.scaled(body.mass) + of.axes.apply(body.moment), axes }
}

/// The same of a rate, which shifts do not change.
fn of_turn(rate: &Twelve<f64>, own: &Twelve<f64>) -> Twist {
    Twist { shift: NOUGHT, ..of_motion(rate, own) }
}

fn dot(one: &Twelve<f64>, other: &Twelve<f64>) -> f64 {
    one.origin.dot(other.origin) + product(&one.axes, &other.axes)
}

/// The cotangents of the parts of [`crate::derivatives::forward::tree::column`].
struct Parts {
    /// Of the displacements at all stages, where forces stay.
    stages: Vec<Displaced>,
    /// Of δw_i at the stages i = 2..s.
    ahead: Vec<Vec<Twelve<f64>>>,
    /// Of δq̇(v̄) − δq̇₀.
    faster: Vec<Twelve<f64>>,
    /// Of r (n).
    gone: Vec<f64>,
}

impl TreeStep<'_> {
    /// The cotangents of `−Σ μ_r R_r`; the cotangents of figures are added to `figures`; `efforts` are all efforts at the stages.
    pub fn pull_back(
        &self,
        courses: &[FreedomCourse],
        efforts: &[Vec<f64>],
        weights: &DVector<f64>,
        figures: &mut FigureCotangents,
    ) -> Cotangents {
        let (s, h, tableau) = (self.stages.len(), self.problem.step, self.problem.tableau);
        let plain = &self.problem.figures.plain;
        let (free, count, n) = (self.problem.mode.free.len(), plain.bodies.len(), plain.freedoms);
        let mut found = Cotangents {
            positions: vec![0.0; n],
            velocities: vec![0.0; n],
            longer: 0.0,
            efforts: vec![vec![0.0; n]; s],
        };
        let mut parts = Parts {
            stages: Vec::with_capacity(s),
            ahead: Vec::with_capacity(s - 1),
            faster: Vec::with_capacity(count),
            gone: vec![0.0; n],
        };
        // The weights of w_i in all stages, and the cotangents of W.
        let weights_ahead: Vec<Vec<f64>> = (0..s).map(|stage| self.weights(stage)).collect();
        let mut of_mixed: Vec<Twelve<f64>> = Vec::with_capacity(s * count);
        for stage in 0..s {
            let own_weights = &weights_ahead[stage];
            let is_end = stage + 1 == s;
            let factor_rate = if is_end { tableau.weights[s - 1] } else { 2.0 * h };
            let at = &self.stages[stage];
            let weight = |row: Option<usize>| row.map_or(0.0, |row| -weights[stage * free + row]);
            let mut motions: Vec<Twist> = Vec::with_capacity(count);
            let mut own = Displaced { bodies: Vec::with_capacity(count), carriers: Vec::with_capacity(count) };
            for body in 0..count {
                let behind = &self.behind[stage][body];
                let about = behind.about();
                let mut motion = self.family.parents[body].map_or(Twist::NONE, |parent| motions[parent]);
                let mut carriers = [Twist::NONE; 2];
                for freedom in &self.family.own[body] {
                    let by = weight(freedom.row);
                    let twist = at.motions[freedom.index].scaled(by);
                    motion = motion.plus(&twist);
                    let carrier = &mut carriers[usize::from(freedom.is_rotation)];
                    *carrier = carrier.plus(&of_carrier(&twist, behind.force, about));
                    found.efforts[stage][freedom.index] -= by * self.factor(stage);
                    found.longer -= by * factor_rate * efforts[stage][freedom.index];
                }
                motions.push(motion);
                own.carriers.push(carriers);
                let single: &Forces = &self.single[stage][body];
                own.bodies.push(Twist {
                    turn: transposed(&single.moments, motion.turn) - motion.turn.scaled(trace(&single.moments)),
                    shift: single.force.cross(motion.turn),
                });
                let field = motion.moves(&at.places[body]);
                let mixed = &self.mixed[stage][body];
                let (mass, moment, second) = &mut figures.inertial[body];
                *mass += field.origin.dot(mixed.origin);
                *moment = *moment + transposed(&mixed.axes, field.origin) + transposed(&field.axes, mixed.origin);
                for c in 0..3 {
                    // Column c of Αᵀ Ω.
                    second.0[c] = second.0[c] + transposed(&field.axes, mixed.axes.0[c]);
                }
                let of_w = momentum(&plain.bodies[body], &field);
                figures.gravity = figures.gravity + of_w.origin.scaled(-self.factor(stage));
                found.longer -= factor_rate * of_w.origin.dot(plain.gravity);
                if is_end {
                    parts.faster.push(of_w);
                    for i in 0..own_weights.len() {
                        found.longer -= own_weights[i] / h * dot(&of_w, &self.ahead[i][body]);
                    }
                }
                of_mixed.push(of_w);
            }
            parts.stages.push(own);
            let row_weight = |row: usize| -weights[stage * free + row];
            self.pull_scalars(stage, own_weights, &row_weight, &mut parts.gone, &mut found);
        }
        for i in 0..s - 1 {
            let of_stages = |body: usize| {
                let stages = weights_ahead.iter().enumerate();
                stages.fold(Twelve::zero(), |sum, (stage, weights)| {
                    sum.plus(&of_mixed[stage * count + body].scaled(weights[i]))
                })
            };
            parts.ahead.push((0..count).map(of_stages).collect());
        }
        self.pull_variation(courses, parts, figures, &mut found);
        found
    }

    /// Goes on from the parts to the start, the length and the frames.
    fn pull_variation(
        &self,
        courses: &[FreedomCourse],
        mut parts: Parts,
        figures: &mut FigureCotangents,
        found: &mut Cotangents,
    ) {
        let (s, h, nodes) = (self.stages.len(), self.problem.step, &self.problem.tableau.nodes);
        let count = self.family.parents.len();
        let (mut begin, mut going) = (Displaced::none(count), Displaced::none(count));
        let mut rates = Displaced::none(count);
        begin.add(&parts.stages[0], 1.0);
        for (i, ahead) in parts.ahead.iter().enumerate() {
            let (node, places, own) = (nodes[i + 1], &self.stages[i + 1].places, &mut parts.stages[i + 1]);
            begin.add(own, 1.0);
            going.add(own, node);
            for body in 0..count {
                let add = |to: &mut Displaced, by: Twist| to.bodies[body] = to.bodies[body].plus(&by);
                let moved = self.moved(i, body);
                add(&mut begin, of_turn(&self.ahead[i][body], &ahead[body]));
                add(&mut going, of_turn(&moved, &ahead[body]).scaled(node));
                add(own, of_motion(&places[body], &ahead[body]));
                if i + 2 == s {
                    let ([begun, ended], faster) = ([&self.rates[0][body], &self.rates[1][body]], &parts.faster[body]);
                    let of_start = of_turn(&moved, faster).scaled(1.0 / h);
                    add(&mut begin, of_turn(&ended.minus(begun), faster));
                    add(&mut going, of_turn(ended, faster).plus(&of_start));
                    add(own, of_turn(ended, faster));
                    add(&mut rates, of_motion(&places[body], faster));
                    found.longer -= of_start.dot(&self.speeds[0][body]);
                }
            }
        }
        let begin = begin.pulled(self.family);
        let going = going.pulled(self.family);
        let rates = rates.pulled(self.family);
        let stages: Vec<Vec<JointCotangents>> =
            parts.stages.into_iter().skip(1).map(|own| own.pulled(self.family)).collect();
        for (body, own) in self.family.own.iter().enumerate() {
            for freedom in own {
                let FreedomCourse { kept, later, rates: [by_start, by_gone] } = &courses[freedom.index];
                let (going, rates) = (&going[body].own, &rates[body].own);
                let mut start = kept.begin.dot(&begin[body].own) + kept.gone.dot(going) + by_start.dot(rates);
                let mut gone = self.stages[0].motions[freedom.index].dot(going) + by_gone.dot(rates);
                for (i, stage) in stages.iter().enumerate() {
                    start += kept.ahead[i].dot(&stage[body].own);
                    gone += nodes[i + 1] * later[i].dot(&stage[body].own);
                }
                found.positions[freedom.index] += start;
                parts.gone[freedom.index] += gone;
                found.velocities[freedom.index] += later[s - 2].dot(rates);
            }
            let Some(frames) = figures.frames.get_mut(body) else { continue };
            for (which, frame) in frames.iter_mut().enumerate() {
                let ahead = stages.iter().map(|stage| stage[body].frames[which]).collect();
                let course = Course { begin: begin[body].frames[which], gone: going[body].frames[which], ahead };
                let of = FrameCourse { course, rate: rates[body].frames[which] };
                *frame = frame.plus(&self.frame_cotangent(body, which, &of));
            }
        }
        for (freedom, by) in parts.gone.iter().enumerate() {
            self.pull_gone(freedom, *by, found);
        }
    }

    /// Goes on from r of a freedom.
    pub fn pull_gone(&self, freedom: usize, by: f64, found: &mut Cotangents) {
        if self.row(freedom).is_some() {
            found.velocities[freedom] += self.problem.step * by;
            found.longer += self.problem.start.velocity[freedom] * by;
        } else {
            found.velocities[freedom] = 0.0;
        }
    }

    /// Rotors, dampers, springs and motors.
    fn pull_scalars(
        &self,
        stage: usize,
        weights: &[f64],
        row_weight: &dyn Fn(usize) -> f64,
        gone: &mut [f64],
        found: &mut Cotangents,
    ) {
        let (s, h, tableau) = (self.stages.len(), self.problem.step, self.problem.tableau);
        let gained = |weights: &[f64], ahead: &[f64]| -> f64 {
            weights.iter().zip(ahead).map(|(weight, ahead)| weight * ahead).sum()
        };
        if stage + 1 == s {
            for (freedom, armature, scalar) in self.rotors() {
                let Some(row) = self.row(freedom) else { continue };
                found.longer -= armature * row_weight(row) * gained(weights, &scalar.ahead) / h;
            }
        }
        let of_rates = &tableau.velocity[stage * (s - 1)..][..s - 1];
        for (freedom, coefficient) in self.dampers() {
            let (Some(row), Some(scalar)) = (self.row(freedom), self.scalar(freedom)) else { continue };
            let by = self.factor(stage) * coefficient * row_weight(row);
            found.velocities[freedom] += by;
            found.longer -= by * gained(of_rates, &scalar.ahead) / (h * h);
        }
        for (freedom, coefficient) in self.springs() {
            let Some(row) = self.row(freedom) else { continue };
            let by = self.factor(stage) * coefficient * row_weight(row);
            found.positions[freedom] += by;
            gone[freedom] += tableau.nodes[stage] * by;
        }
    }
}
