//! The transpose of [`crate::derivatives::forward::tree::column`]: what a weighted sum of the equations of a step depends on, all numbers at once.
//!
//! With weights μ of the rows, Y is the motion `Σ_r μ_r s_r` of a body in a stage, and A the 12 numbers of its velocity field:
//!
//! ```text
//!     Σ_r μ_r s_r · ∫ f = ∫ (a + Α u) · (w + Ω u) dm        cotangents    of m: a·w    of p: Ωᵀ a + Αᵀ w    of P: Αᵀ Ω
//!                                                            of (w, Ω): the momentum of A
//! ```
//!
//! From the forces they go on to rates and places, and from there to frames, coordinates and velocities, against the order in which a column is
//! computed.

use crate::derivatives::equations::figures::BodyFigures;
use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::spatial::{Forces, NOUGHT, Twist, trace, transposed};
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
    /// The frames of its joint.
    frames: Vec<[Twist; 2]>,
}

impl FigureCotangents {
    /// Zero, of a number of bodies.
    pub fn zero(bodies: usize) -> Self {
        FigureCotangents {
            gravity: NOUGHT,
            inertial: vec![(0.0, NOUGHT, Matrix([NOUGHT; 3])); bodies],
            frames: vec![[Twist::NONE; 2]; bodies],
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
            sum += own.iter().zip(by).map(|(own, by)| own.turn.dot(by.turn) + own.shift.dot(by.shift)).sum::<f64>();
        }
        sum
    }
}

/// The sum of the products of all entries.
fn product(one: &Matrix<f64>, other: &Matrix<f64>) -> f64 {
    (0..3).map(|column| one.0[column].dot(other.0[column])).sum()
}

/// The cotangent of a motion that carries another one, where the power of the change on (F, N) counts.
fn of_carrier(carried: &Twist, force: Vector<f64>, torque: Vector<f64>) -> Twist {
    Twist { turn: carried.shift.cross(force) + carried.turn.cross(torque), shift: carried.turn.cross(force) }
}

/// The cotangent of a motion of a place.
fn of_motion(place: &Twelve<f64>, own: &Twelve<f64>) -> Twist {
    let axes = (0..3).fold(place.origin.cross(own.origin), |sum, c| sum + place.axes.0[c].cross(own.axes.0[c]));
    Twist { turn: axes, shift: own.origin }
}

/// The momentum of (w, Ω) of a body.
fn momentum(body: &BodyFigures<f64>, of: &Twelve<f64>) -> Twelve<f64> {
    let axes = [0, 1, 2].map(|c| of.origin.scaled(body.moment.0[c]) + of.axes.apply(body.second_moments.0[c]));
    Twelve { origin: of.origin.scaled(body.mass) + of.axes.apply(body.moment), axes: Matrix(axes) }
}

fn dot(one: &Twelve<f64>, other: &Twelve<f64>) -> f64 {
    one.origin.dot(other.origin) + product(&one.axes, &other.axes)
}

/// The cotangents of the displacements of a stage.
struct Displacing {
    bodies: Vec<Twist>,
    carriers: Vec<[Twist; 2]>,
}

impl TreeStep<'_> {
    /// The cotangents of `−Σ μ_r R_r`; the cotangents of figures are added to `figures`; `efforts` are all efforts at the stages.
    pub fn pull_back(
        &self,
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
        let none = || vec![Twelve::zero(); count];
        let mut places: Vec<Vec<Twelve<f64>>> = (0..s).map(|_| none()).collect();
        let (mut start_rates, mut end_rates) = (none(), none());
        let mut displacing: Vec<Displacing> = Vec::with_capacity(s);
        for stage in 0..s {
            let own_weights = self.weights(stage);
            let is_end = stage + 1 == s;
            let total: f64 = own_weights.iter().sum();
            let gone: f64 = own_weights.iter().zip(&tableau.nodes[1..]).map(|(weight, node)| weight * node).sum();
            let factor_rate = if is_end { tableau.weights[s - 1] } else { 2.0 * h };
            let at = &self.stages[stage];
            let weight = |row: Option<usize>| row.map_or(0.0, |row| -weights[stage * free + row]);
            let mut motions: Vec<Twist> = Vec::with_capacity(count);
            let mut own = Displacing { bodies: Vec::with_capacity(count), carriers: Vec::with_capacity(count) };
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
                found.longer -= gone * dot(&of_w, &self.rates[0][body]);
                start_rates[body] = start_rates[body].plus(&of_w.scaled(-h * gone));
                if is_end {
                    start_rates[body] = start_rates[body].minus(&of_w);
                    end_rates[body] = of_w;
                    for (ahead, weight) in self.ahead.iter().zip(&own_weights) {
                        found.longer -= weight / h * dot(&of_w, &ahead[body]);
                    }
                }
                places[0][body] = places[0][body].plus(&of_w.scaled(-total));
                for (i, weight) in own_weights.iter().enumerate() {
                    places[i + 1][body] = places[i + 1][body].plus(&of_w.scaled(*weight));
                }
            }
            displacing.push(own);
            self.pull_scalars(stage, &own_weights, &|row| -weights[stage * free + row], &mut found);
        }
        self.pull_rates(0, &start_rates, &mut displacing[0], &mut places[0], &mut found.velocities);
        let mut of_end = vec![0.0; n];
        self.pull_rates(1, &end_rates, &mut displacing[s - 1], &mut places[s - 1], &mut of_end);
        for (stage, own) in displacing.into_iter().enumerate() {
            self.pull_displacements(stage, own, &places[stage], figures, &mut found.positions);
        }
        found
    }

    /// Goes on from δq̇ of all bodies at the start (0) or the end (1).
    fn pull_rates(
        &self,
        end: usize,
        rates: &[Twelve<f64>],
        own: &mut Displacing,
        places: &mut [Twelve<f64>],
        velocities: &mut [f64],
    ) {
        let at = &self.stages[end * (self.stages.len() - 1)];
        let rate_of = [&self.problem.start.velocity[..], self.velocities][end];
        let mut faster: Vec<Twist> = at.places.iter().zip(rates).map(|(place, rate)| of_motion(place, rate)).collect();
        self.family.gather(&mut faster, |sum, own| *sum = sum.plus(own));
        for (body, whole) in faster.iter().enumerate() {
            // V × δq, transposed.
            let turned = self.speeds[end][body].turns(&rates[body]);
            places[body] = places[body].minus(&turned);
            for freedom in &self.family.own[body] {
                let motion = &at.motions[freedom.index];
                velocities[freedom.index] += motion.shift.dot(whole.shift) + motion.turn.dot(whole.turn);
                let by = of_carrier(&motion.scaled(rate_of[freedom.index]), whole.shift, whole.turn);
                let carrier = &mut own.carriers[body][usize::from(freedom.is_rotation)];
                *carrier = carrier.plus(&by);
            }
        }
    }

    /// Goes on from the displacements of a stage.
    fn pull_displacements(
        &self,
        stage: usize,
        mut own: Displacing,
        places: &[Twelve<f64>],
        figures: &mut FigureCotangents,
        positions: &mut [f64],
    ) {
        let at = &self.stages[stage];
        let world = Twelve { origin: NOUGHT - self.reference, axes: Matrix::identity() };
        for body in (0..places.len()).rev() {
            let place = &at.places[body];
            let mut whole = own.bodies[body].plus(&of_motion(place, &places[body]));
            let bodies = &self.problem.figures.plain.bodies[body];
            let on_child = in_frame(place, bodies.on_child.origin, &whole).scaled(-1.0);
            whole = whole.plus(&own.carriers[body][1]);
            for freedom in &self.family.own[body] {
                // Later the unknowns are whole displacements, but for joints that are held.
                if stage == 0 || freedom.row.is_none() {
                    let motion = &at.motions[freedom.index];
                    positions[freedom.index] += motion.shift.dot(whole.shift) + motion.turn.dot(whole.turn);
                }
            }
            whole = whole.plus(&own.carriers[body][0]);
            let parent = self.family.parents[body];
            let carried = parent.map_or(&world, |parent| &at.places[parent]);
            let on_parent = in_frame(carried, bodies.on_parent.origin, &whole);
            let [of_parent, of_child] = &mut figures.frames[body];
            (*of_parent, *of_child) = (of_parent.plus(&on_parent), of_child.plus(&on_child));
            if let Some(parent) = parent {
                own.bodies[parent] = own.bodies[parent].plus(&whole);
            }
        }
    }

    /// Rotors, dampers, springs and motors.
    fn pull_scalars(&self, stage: usize, weights: &[f64], row_weight: &dyn Fn(usize) -> f64, found: &mut Cotangents) {
        let (s, h, tableau) = (self.stages.len(), self.problem.step, self.problem.tableau);
        let start = &self.problem.start.velocity;
        let mut pull = |freedom: usize, by: f64, weights: &[f64]| {
            for (weight, node) in weights.iter().zip(&tableau.nodes[1..]) {
                found.positions[freedom] -= by * weight;
                found.velocities[freedom] -= by * weight * h * node;
                found.longer -= by * weight * node * start[freedom];
            }
        };
        let gained = |weights: &[f64], ahead: &[f64]| -> f64 {
            weights.iter().zip(ahead).map(|(weight, ahead)| weight * ahead).sum()
        };
        let (mut faster, mut longer) = (Vec::new(), 0.0);
        for (freedom, armature, scalar) in self.rotors() {
            let Some(row) = self.row(freedom) else { continue };
            let by = armature * row_weight(row);
            pull(freedom, by, weights);
            if stage + 1 == s {
                faster.push((freedom, -by));
                longer -= by * gained(weights, &scalar.ahead) / h;
            }
        }
        let of_rates = &tableau.velocity[stage * (s - 1)..][..s - 1];
        for (freedom, coefficient) in self.dampers() {
            let (Some(row), Some(scalar)) = (self.row(freedom), self.scalar(freedom)) else { continue };
            let by = self.factor(stage) * coefficient * row_weight(row);
            pull(freedom, by / h, of_rates);
            faster.push((freedom, by));
            longer -= by * gained(of_rates, &scalar.ahead) / (h * h);
        }
        found.longer += longer;
        faster.into_iter().for_each(|(freedom, by)| found.velocities[freedom] += by);
        if stage == 0 {
            for (freedom, coefficient) in self.springs() {
                let Some(row) = self.row(freedom) else { continue };
                found.positions[freedom] += self.factor(stage) * coefficient * row_weight(row);
            }
        }
    }
}

/// The cotangent of a motion about a point of a body, in the body, from the cotangent in the world.
fn in_frame(place: &Twelve<f64>, at: Vector<f64>, whole: &Twist) -> Twist {
    let point = place.origin + place.axes.apply(at);
    let turn = whole.turn + whole.shift.cross(point);
    Twist { turn: transposed(&place.axes, turn), shift: transposed(&place.axes, whole.shift) }
}
