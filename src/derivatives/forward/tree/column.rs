//! How the equations of a step of a tree change with its start, its length, its efforts and its numbers, while the coordinates of the stages stay.
//!
//! ```text
//!     δW_k = Σ_i β_ki (δQ_i − δQ_0 − h c_i δq̇_0 − δh c_i q̇_0) − δ(h² g)         δq̇ = δV q + V δq
//!     δ(row r) = s_r · (M δW + δM W)  +  K_k of places that are displaced  −  δ(h² τ)
//! ```
//!
//! Besides the unknowns, all joints are displaced at the start, later the joints that are held, and frames of joints that vary. A frame on
//! the parent moves the joint and the child, as a freedom before the joint does; one on the child moves the child alone. Unknowns are whole
//! displacements, those of the start included.

use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::spatial::{Forces, Twist};
use crate::derivatives::forward::tree::step::TreeStep;
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use nalgebra::{DMatrix, DVector};

/// The changes of a step by a parameter.
pub(super) struct Column<'c> {
    /// Of the start (n each).
    pub positions: &'c [f64],
    pub velocities: &'c [f64],
    /// δh (s per unit).
    pub longer: f64,
    /// Of the efforts from outside at all stages.
    pub efforts: &'c dyn Fn(usize, usize) -> f64,
    pub figures: Option<&'c FigureSlopes>,
}

/// How the bodies of a stage are displaced.
struct Displaced {
    /// Each body, and what carries the slides and the rotations of its joint.
    bodies: Vec<Twist>,
    carriers: Vec<[Twist; 2]>,
}

/// A motion about a point of a body, in the world: the turn and the velocity of the point, both in the body.
fn in_world(place: &Twelve<f64>, at: Vector<f64>, of: &Twist) -> Twist {
    let (turn, speed) = (place.axes.apply(of.turn), place.axes.apply(of.shift));
    let point = place.origin + place.axes.apply(at);
    Twist { turn, shift: speed + point.cross(turn) }
}

impl TreeStep<'_> {
    /// −δR of the motion equations, a column for each parameter.
    pub fn right(&self, efforts: &[Vec<f64>], columns: &[Column]) -> DMatrix<f64> {
        let mut right = DMatrix::zeros(self.stages.len() * self.problem.mode.free.len(), columns.len());
        for (number, column) in columns.iter().enumerate() {
            right.set_column(number, &-self.change(efforts, column));
        }
        right
    }

    /// δR.
    fn change(&self, efforts: &[Vec<f64>], column: &Column) -> DVector<f64> {
        let (s, tableau, h) = (self.stages.len(), self.problem.tableau, self.problem.step);
        let figures = &self.problem.figures.plain;
        let free = self.problem.mode.free.len();
        let (start, longer) = (&self.problem.start.velocity, column.longer);
        let frames = column.figures.and_then(|slopes| slopes.frames());
        let moves = frames.is_some() || column.positions.iter().chain(column.velocities).any(|part| *part != 0.0);
        let is_held = |freedom: usize| self.row(freedom).is_none();
        let held: Vec<f64> = column
            .positions
            .iter()
            .enumerate()
            .map(|(freedom, part)| if is_held(freedom) { *part } else { 0.0 })
            .collect();
        let later = frames.is_some() || held.iter().any(|part| *part != 0.0);
        let nothing = vec![0.0; held.len()];
        let none = || vec![Twelve::zero(); figures.bodies.len()];
        let displaced: Vec<Option<Displaced>> = (0..s)
            .map(|stage| match stage {
                0 => moves.then(|| self.displaced(0, column.positions, frames)),
                stage => later.then(|| self.displaced(stage, &held, frames)),
            })
            .collect();
        let moved = |stage: usize| {
            displaced[stage].as_ref().map(|of| {
                of.bodies
                    .iter()
                    .zip(&self.stages[stage].places)
                    .map(|(by, place)| by.moves(place))
                    .collect::<Vec<Twelve<f64>>>()
            })
        };
        let places: Vec<Option<Vec<Twelve<f64>>>> = (0..s).map(moved).collect();
        let start_rates =
            displaced[0].as_ref().map_or_else(none, |of| self.rate_changes(0, start, column.velocities, of));
        let end_rates = displaced[s - 1].as_ref().map(|of| self.rate_changes(1, self.velocities, &nothing, of));
        let mut change = DVector::zeros(s * free);
        for stage in 0..s {
            let weights = self.weights(stage);
            let is_end = stage + 1 == s;
            let total: f64 = weights.iter().sum();
            let gone: f64 = weights.iter().zip(&tableau.nodes[1..]).map(|(weight, node)| weight * node).sum();
            // ∂/∂h of h², h b_s, and of 1/h in the weights of the end.
            let factor_rate = if is_end { tableau.weights[s - 1] } else { 2.0 * h };
            let mut loads: Vec<[Vector<f64>; 2]> = Vec::with_capacity(figures.bodies.len());
            for body in 0..figures.bodies.len() {
                let own = column.figures.and_then(|slopes| slopes.inertial()[body].as_ref());
                let mut w = start_rates[body].scaled(-h * gone);
                w = w.plus(&self.rates[0][body].scaled(-longer * gone));
                if is_end {
                    w = w.minus(&start_rates[body]);
                    if let Some(rates) = &end_rates {
                        w = w.plus(&rates[body]);
                    }
                    if longer != 0.0 {
                        for (ahead, weight) in self.ahead.iter().zip(&weights) {
                            w = w.plus(&ahead[body].scaled(-longer * weight / h));
                        }
                    }
                }
                if let Some(begin) = &places[0] {
                    w = w.plus(&begin[body].scaled(-total));
                }
                for (i, weight) in weights.iter().enumerate() {
                    if let Some(at) = &places[i + 1] {
                        w = w.plus(&at[body].scaled(*weight));
                    }
                }
                w.origin = w.origin + figures.gravity.scaled(-longer * factor_rate);
                if let Some(slopes) = column.figures {
                    w.origin = w.origin + slopes.plain.gravity.scaled(-self.factor(stage));
                }
                let place = &self.stages[stage].places[body];
                let mut forces = Forces::on(&figures.bodies[body], place, &w);
                if let Some(slope) = own {
                    forces = forces.plus(&Forces::on(slope, place, &self.mixed[stage][body]));
                }
                let mut torque = forces.about();
                if let Some(of) = &displaced[stage] {
                    torque = torque + self.single[stage][body].carried(&of.bodies[body]);
                }
                loads.push([forces.force, torque]);
            }
            self.family.gather(&mut loads, |sum, own| *sum = [sum[0] + own[0], sum[1] + own[1]]);
            for (body, [force, torque]) in loads.iter().enumerate() {
                let behind = &self.behind[stage][body];
                let about = behind.about();
                for freedom in &self.family.own[body] {
                    let Some(row) = freedom.row else { continue };
                    let motion = &self.stages[stage].motions[freedom.index];
                    let mut sum = motion.power(*force, *torque);
                    if let Some(of) = &displaced[stage] {
                        let carrier = &of.carriers[body][usize::from(freedom.is_rotation)];
                        sum += carrier.carries(motion).power(behind.force, about);
                    }
                    let effort = (column.efforts)(stage, freedom.index);
                    sum -= self.factor(stage) * effort + longer * factor_rate * efforts[stage][freedom.index];
                    change[stage * free + row] += sum;
                }
            }
            self.add_scalar_changes(stage, column, &weights, &mut change);
        }
        change
    }

    /// Rotors, dampers, springs and motors.
    fn add_scalar_changes(&self, stage: usize, column: &Column, weights: &[f64], change: &mut DVector<f64>) {
        let (s, h, tableau) = (self.stages.len(), self.problem.step, self.problem.tableau);
        let (start, longer, free) = (&self.problem.start.velocity, column.longer, self.problem.mode.free.len());
        let is_end = stage + 1 == s;
        // Of Σ_i weight_i (y_i − y_0 − h c_i ẏ_0).
        let ahead = |freedom: usize, weights: &[f64]| {
            let (place, rate) = (column.positions[freedom], column.velocities[freedom]);
            let nodes = weights.iter().zip(&tableau.nodes[1..]);
            nodes
                .map(|(weight, node)| weight * (-place - h * node * rate - longer * node * start[freedom]))
                .sum::<f64>()
        };
        for (freedom, armature, scalar) in self.rotors() {
            let Some(row) = self.row(freedom) else { continue };
            let gained: f64 = weights.iter().zip(&scalar.ahead).map(|(weight, ahead)| weight * ahead).sum();
            let mut sum = ahead(freedom, weights);
            if is_end {
                sum -= column.velocities[freedom] + longer * gained / h;
            }
            change[stage * free + row] += armature * sum;
        }
        let mut add = |freedom: usize, effort: f64| {
            if let Some(row) = self.row(freedom) {
                change[stage * free + row] -= self.factor(stage) * effort;
            }
        };
        let of_rates = &tableau.velocity[stage * (s - 1)..][..s - 1];
        for (freedom, coefficient) in self.dampers() {
            let Some(scalar) = self.scalar(freedom) else { continue };
            let gained: f64 = of_rates.iter().zip(&scalar.ahead).map(|(weight, ahead)| weight * ahead).sum();
            let rate = column.velocities[freedom] + ahead(freedom, of_rates) / h - longer * gained / (h * h);
            add(freedom, -coefficient * rate);
        }
        if stage == 0 {
            for (freedom, coefficient) in self.springs() {
                add(freedom, -coefficient * column.positions[freedom]);
            }
        }
        if let Some(slopes) = column.figures.filter(|slopes| slopes.changes_laws()) {
            self.add_law_changes(stage, slopes, weights, change);
        }
    }

    /// δR of springs, dampers, motors, loads and rotors that change.
    pub(super) fn law_changes(&self, slopes: &FigureSlopes) -> DVector<f64> {
        let mut change = DVector::zeros(self.stages.len() * self.problem.mode.free.len());
        for stage in 0..self.stages.len() {
            self.add_law_changes(stage, slopes, &self.weights(stage), &mut change);
        }
        change
    }

    fn add_law_changes(&self, stage: usize, slopes: &FigureSlopes, weights: &[f64], change: &mut DVector<f64>) {
        let free = self.problem.mode.free.len();
        for (number, (freedom, _, scalar)) in self.rotors().enumerate() {
            let Some(row) = self.row(freedom) else { continue };
            let mut whole: f64 = weights.iter().zip(&scalar.ahead).map(|(weight, ahead)| weight * ahead).sum();
            if stage + 1 == self.stages.len() {
                whole += self.velocities[freedom] - self.problem.start.velocity[freedom];
            }
            change[stage * free + row] += slopes.plain.rotors[number].1 * whole;
        }
        let mut add = |freedom: usize, effort: f64| {
            if let Some(row) = self.row(freedom) {
                change[stage * free + row] -= self.factor(stage) * effort;
            }
        };
        let figures = &self.problem.figures.plain;
        for (spring, slope) in figures.springs.iter().zip(&slopes.plain.springs) {
            let freedom = spring.coordinate.freedom;
            let Some(scalar) = self.scalar(freedom) else { continue };
            add(freedom, spring.stiffness * slope.rest - slope.stiffness * (scalar.values[stage] - spring.rest));
        }
        for &(freedom, slope) in &slopes.plain.dampers {
            let Some(scalar) = self.scalar(freedom) else { continue };
            add(freedom, -slope * scalar.rates[stage]);
        }
        for drive in self.problem.mode.drives(&slopes.laws) {
            let Some(scalar) = self.scalar(drive.coordinate.freedom) else { continue };
            add(drive.coordinate.freedom, -drive.kp * scalar.values[stage] - drive.kd * scalar.rates[stage]);
        }
        slopes.plain.loads.iter().for_each(|&(freedom, slope)| add(freedom, slope));
    }

    fn displaced(&self, stage: usize, positions: &[f64], frames: Option<&[[Twist; 2]]>) -> Displaced {
        let (figures, at) = (&self.problem.figures.plain, &self.stages[stage]);
        let count = figures.bodies.len();
        let mut found = Displaced { bodies: Vec::with_capacity(count), carriers: Vec::with_capacity(count) };
        let world = Twelve { origin: Vector([0.0; 3]) - self.reference, axes: Matrix::identity() };
        for body in 0..count {
            let parent = self.family.parents[body];
            let mut by = parent.map_or(Twist::NONE, |parent| found.bodies[parent]);
            if let Some(frames) = frames {
                let place = parent.map_or(&world, |parent| &at.places[parent]);
                by = by.plus(&in_world(place, figures.bodies[body].on_parent.origin, &frames[body][0]));
            }
            let before = by;
            let own = &self.family.own[body];
            for freedom in own.iter().filter(|freedom| !freedom.is_rotation) {
                by = by.plus(&at.motions[freedom.index].scaled(positions[freedom.index]));
            }
            for freedom in own.iter().filter(|freedom| freedom.is_rotation) {
                by = by.plus(&at.motions[freedom.index].scaled(positions[freedom.index]));
            }
            found.carriers.push([before, by]);
            if let Some(frames) = frames {
                // A frame on the child stays, and the child moves the other way.
                let place = &at.places[body];
                by = by.plus(&in_world(place, figures.bodies[body].on_child.origin, &frames[body][1]).scaled(-1.0));
            }
            found.bodies.push(by);
        }
        found
    }

    /// δq̇ of all bodies, at the start (0) or the end (1), with changes of the velocities.
    fn rate_changes(&self, end: usize, velocities: &[f64], slopes: &[f64], of: &Displaced) -> Vec<Twelve<f64>> {
        let stage = end * (self.stages.len() - 1);
        let at = &self.stages[stage];
        let mut faster: Vec<Twist> = Vec::with_capacity(at.places.len());
        let mut all = Vec::with_capacity(at.places.len());
        for (body, place) in at.places.iter().enumerate() {
            let mut own = self.family.parents[body].map_or(Twist::NONE, |parent| faster[parent]);
            for freedom in &self.family.own[body] {
                let motion = &at.motions[freedom.index];
                let carrier = &of.carriers[body][usize::from(freedom.is_rotation)];
                own = own.plus(&carrier.carries(motion).scaled(velocities[freedom.index]));
                own = own.plus(&motion.scaled(slopes[freedom.index]));
            }
            faster.push(own);
            let moved = of.bodies[body].moves(place);
            all.push(own.moves(place).plus(&self.speeds[end][body].turns(&moved)));
        }
        all
    }
}
