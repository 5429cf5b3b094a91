//! How the equations of a step of a tree change with its start, its length, its efforts and its numbers.
//!
//! The whole motion along the step is displaced with the start, and the unknowns are what is left of the displacements:
//!
//! ```text
//!     displacement of a freedom at stage i    δq₀ + c_i r,   r = h δv₀ + v₀ δh        velocity at the end  δv₀
//!     T_i = T_0 + c_i 𝒰 + P_i                 𝒰 = Σ s_0 r + h ṡ_0 δq₀               P_i = Σ σ_i δq₀ + c_i (s_i − s_0) r
//!     δw_i = T_0 w_i + P_i q_i + c_i 𝒰 (q_i − q_0)         δq̇ = T q̇ + U q         δW_k = Σ_i β_ki δw_i − δ(h² g)
//!     δ(row r) = s_r · (M δW + δM W)  +  K_k of the displaced places  −  δ(h² τ)
//! ```
//!
//! Differences of whole displacements would lose digits: they are of first order, and δw_i and the unknowns of second. Frames of joints that vary
//! are displaced as freedoms ([`crate::derivatives::forward::tree::displaced`]). Held joints have no velocity.

use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::spatial::{Forces, Twist};
use crate::derivatives::forward::tree::course::{FrameCourse, FreedomCourse};
use crate::derivatives::forward::tree::displaced::Displaced;
use crate::derivatives::forward::tree::step::TreeStep;
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::vector::Vector;
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

/// How the motion of the bodies along a step varies.
struct Variation {
    /// The displacements at all stages.
    stages: Vec<Displaced>,
    /// δw_i of the stages i = 2..s.
    ahead: Vec<Vec<Twelve<f64>>>,
    /// δq̇(v̄) − δq̇₀.
    faster: Vec<Twelve<f64>>,
}

impl TreeStep<'_> {
    /// −δR of the motion equations, a column for each parameter.
    pub fn right(&self, efforts: &[Vec<f64>], columns: &[Column]) -> DMatrix<f64> {
        let courses = self.courses();
        let mut right = DMatrix::zeros(self.stages.len() * self.problem.mode.free.len(), columns.len());
        for (number, column) in columns.iter().enumerate() {
            right.set_column(number, &-self.change(&courses, efforts, column));
        }
        right
    }

    /// δR.
    fn change(&self, courses: &[FreedomCourse], efforts: &[Vec<f64>], column: &Column) -> DVector<f64> {
        let (s, tableau, h) = (self.stages.len(), self.problem.tableau, self.problem.step);
        let figures = &self.problem.figures.plain;
        let (free, longer) = (self.problem.mode.free.len(), column.longer);
        let frames = column.figures.and_then(|slopes| slopes.frames());
        let starts = column.positions.iter().chain(column.velocities);
        let moves = frames.is_some() || longer != 0.0 || starts.into_iter().any(|part| *part != 0.0);
        let varies = moves.then(|| self.variation(courses, column, frames));
        let mut change = DVector::zeros(s * free);
        for stage in 0..s {
            let weights = self.weights(stage);
            let is_end = stage + 1 == s;
            // ∂/∂h of h², h b_s, and of 1/h in the weights of the end.
            let factor_rate = if is_end { tableau.weights[s - 1] } else { 2.0 * h };
            let mut loads: Vec<[Vector<f64>; 2]> = Vec::with_capacity(figures.bodies.len());
            for body in 0..figures.bodies.len() {
                let own = column.figures.and_then(|slopes| slopes.inertial()[body].as_ref());
                let mut w = Twelve::zero();
                if let Some(varies) = &varies {
                    if is_end {
                        w = varies.faster[body];
                        for i in 0..weights.len() {
                            w = w.plus(&self.ahead[i][body].scaled(-longer * weights[i] / h));
                        }
                    }
                    for i in 0..weights.len() {
                        w = w.plus(&varies.ahead[i][body].scaled(weights[i]));
                    }
                    w.origin = w.origin + figures.gravity.scaled(-longer * factor_rate);
                }
                if let Some(slopes) = column.figures {
                    w.origin = w.origin + slopes.plain.gravity.scaled(-self.factor(stage));
                }
                let place = &self.stages[stage].places[body];
                let mut forces = Forces::on(&figures.bodies[body], place, &w);
                if let Some(slope) = own {
                    forces = forces.plus(&Forces::on(slope, place, &self.mixed[stage][body]));
                }
                let mut torque = forces.about();
                if let Some(varies) = &varies {
                    torque = torque + self.single[stage][body].carried(&varies.stages[stage].bodies[body]);
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
                    if let Some(varies) = &varies {
                        let carrier = &varies.stages[stage].carriers[body][usize::from(freedom.is_rotation)];
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

    /// r of a freedom.
    fn gone(&self, column: &Column, freedom: usize) -> f64 {
        if self.row(freedom).is_none() {
            return 0.0;
        }
        self.problem.step * column.velocities[freedom] + column.longer * self.problem.start.velocity[freedom]
    }

    /// How the bodies move along with the start.
    fn variation(&self, courses: &[FreedomCourse], column: &Column, frames: Option<&[[Twist; 2]]>) -> Variation {
        let (s, h, nodes) = (self.stages.len(), self.problem.step, &self.problem.tableau.nodes);
        let start = column.positions;
        let gone: Vec<f64> = (0..start.len()).map(|freedom| self.gone(column, freedom)).collect();
        let frames: Option<Vec<[FrameCourse; 2]>> = frames.map(|frames| {
            let of = |(body, [parent, child]): (usize, &[Twist; 2])| {
                [self.frame_course(body, 0, parent), self.frame_course(body, 1, child)]
            };
            frames.iter().enumerate().map(of).collect()
        });
        let of = |freedom: &dyn Fn(usize) -> Twist, frame: &dyn Fn(&FrameCourse) -> Twist| {
            let frames = frames.as_ref().map(|frames| {
                |body: usize| {
                    let [parent, child]: &[FrameCourse; 2] = &frames[body];
                    [frame(parent), frame(child)]
                }
            });
            Displaced::of(self.family, freedom, frames)
        };
        let begin = of(&|f| courses[f].kept.begin.scaled(start[f]), &|frame| frame.course.begin);
        let going =
            of(&|f| courses[f].kept.gone.scaled(start[f]).plus(&self.stages[0].motions[f].scaled(gone[f])), &|frame| {
                frame.course.gone
            });
        let mut ahead = Vec::with_capacity(s - 1);
        let mut faster = Vec::new();
        let mut stages = Vec::with_capacity(s);
        for i in 0..s - 1 {
            let (node, places) = (nodes[i + 1], &self.stages[i + 1].places);
            let own = of(
                &|f| {
                    let FreedomCourse { kept, later, .. } = &courses[f];
                    kept.ahead[i].scaled(start[f]).plus(&later[i].scaled(node * gone[f]))
                },
                &|frame| frame.course.ahead[i],
            );
            let bodies = 0..places.len();
            let change = |body: usize| {
                let moved = self.moved(i, body);
                let of_start = begin.bodies[body].turns(&self.ahead[i][body]);
                let of_going = going.bodies[body].scaled(node).turns(&moved);
                own.bodies[body].moves(&places[body]).plus(&of_start).plus(&of_going)
            };
            ahead.push(bodies.clone().map(change).collect());
            if i + 2 == s {
                let rates = of(
                    &|f| {
                        let FreedomCourse { later, rates: [by_start, by_gone], .. } = &courses[f];
                        let speed = if self.row(f).is_some() { column.velocities[f] } else { 0.0 };
                        let own = by_start.scaled(start[f]).plus(&by_gone.scaled(gone[f]));
                        own.plus(&later[i].scaled(speed))
                    },
                    &|frame| frame.rate,
                );
                let change = |body: usize| {
                    let [begun, ended] = [&self.rates[0][body], &self.rates[1][body]];
                    let moved = self.moved(i, body);
                    let by_length = self.speeds[0][body].scaled(-column.longer);
                    let of_start = going.bodies[body].plus(&by_length).scaled(1.0 / h);
                    let later = going.bodies[body].plus(&own.bodies[body]);
                    let turned = begin.bodies[body].turns(&ended.minus(begun)).plus(&later.turns(ended));
                    turned.plus(&of_start.turns(&moved)).plus(&rates.bodies[body].moves(&places[body]))
                };
                faster = bodies.map(change).collect();
            }
            let mut whole = own;
            whole.add(&begin, 1.0);
            whole.add(&going, node);
            stages.push(whole);
        }
        stages.insert(0, begin);
        Variation { stages, ahead, faster }
    }

    /// Rotors, dampers, springs and motors.
    fn add_scalar_changes(&self, stage: usize, column: &Column, weights: &[f64], change: &mut DVector<f64>) {
        let (s, h, tableau) = (self.stages.len(), self.problem.step, self.problem.tableau);
        let (longer, free) = (column.longer, self.problem.mode.free.len());
        let is_end = stage + 1 == s;
        // Scalars are displaced along straight lines.
        for (freedom, armature, scalar) in self.rotors() {
            let Some(row) = self.row(freedom) else { continue };
            let gained: f64 = weights.iter().zip(&scalar.ahead).map(|(weight, ahead)| weight * ahead).sum();
            if is_end {
                change[stage * free + row] -= armature * longer * gained / h;
            }
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
            add(freedom, -coefficient * (column.velocities[freedom] - longer * gained / (h * h)));
        }
        for (freedom, coefficient) in self.springs() {
            let moved = column.positions[freedom] + tableau.nodes[stage] * self.gone(column, freedom);
            add(freedom, -coefficient * moved);
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
}
