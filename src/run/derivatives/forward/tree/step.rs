//! The equations of a step of a tree, joint by joint, and what is off in them.
//!
//! The equations are as in [`crate::derivatives::forward::stage_equations`] without closures and springs between points. Forces on bodies act at
//! their points ([`crate::derivatives::forward::spatial`]). With the motions s of the freedoms they become
//!
//! ```text
//!     s_r(k) · Σ_(bodies behind r) M W_k − h² τ_k = 0         W_k = Σ_i B_ki w_i − h² g                        k = 1..s−1
//!     s_r(s) · Σ_(bodies behind r) M W_s − h b_s τ_s = 0      W_s = q̇(v̄) − q̇₀ − Σ_i ω_i w_i/h − h b_s g
//! ```

use crate::derivatives::equations::figures::Figures;
use crate::derivatives::forward::spatial::{Forces, NOUGHT, Twist};
use crate::derivatives::forward::step::StepProblem;
use crate::derivatives::forward::tree::family::{Family, TreeStage};
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::vector::Vector;
use crate::mechanism::motion::state::State;
use nalgebra::DVector;

/// A step of a tree at some stages.
pub(super) struct TreeStep<'s> {
    pub problem: &'s StepProblem<'s>,
    pub family: &'s Family,
    /// The point of the world that places and motions are seen from: where the lightest bodies start.
    pub reference: Vector<f64>,
    /// The stages 1..s.
    pub stages: Vec<TreeStage>,
    /// q̇₀ and q̇(v̄), with the velocities of the bodies there.
    pub rates: [Vec<Twelve<f64>>; 2],
    pub speeds: [Vec<Twist>; 2],
    /// v̄ (n).
    pub velocities: &'s [f64],
    /// w_i of the stages i = 2..s.
    pub ahead: Vec<Vec<Twelve<f64>>>,
    /// W of all stages.
    pub mixed: Vec<Vec<Twelve<f64>>>,
    /// The forces on each body at all stages, and those on it with all bodies behind it.
    pub single: Vec<Vec<Forces>>,
    pub behind: Vec<Vec<Forces>>,
    /// y_i of all freedoms with a rotor or damper, at all stages.
    pub scalars: Vec<Scalar>,
}

/// A coordinate with a rotor, damper or motor.
pub(super) struct Scalar {
    pub freedom: usize,
    /// At all stages.
    pub values: Vec<f64>,
    /// `y_i − y_0 − h c_i ẏ_0`, i = 2..s.
    pub ahead: Vec<f64>,
    /// As the scheme has them, at all stages.
    pub rates: Vec<f64>,
}

/// Whether these equations are all that a mechanism has: no closures, springs between points and wrenches.
pub(in crate::derivatives) fn is_tree(figures: &Figures<f64>) -> bool {
    figures.loops.is_empty()
        && figures.mimics.is_empty()
        && figures.point_springs.is_empty()
        && figures.wrenches.is_empty()
}

impl<'s> TreeStep<'s> {
    /// With the stages i = 2..s and v̄.
    pub fn new(problem: &'s StepProblem<'s>, family: &'s Family, stages: &[State], velocities: &'s [f64]) -> Self {
        let figures = &problem.figures.plain;
        let (s, h) = (problem.tableau.stages, problem.step);
        let from = among_the_lightest(figures, &TreeStage::at(figures, problem.start, NOUGHT));
        let all = std::iter::once(problem.start).chain(stages);
        let found: Vec<TreeStage> = all.map(|stage| TreeStage::at(figures, stage, from)).collect();
        let speeds = [found[0].speeds(family, &problem.start.velocity), found[s - 1].speeds(family, velocities)];
        let rates = [0, 1].map(|end| {
            let places = &found[end * (s - 1)].places;
            speeds[end].iter().zip(places).map(|(speed, place)| speed.moves(place)).collect::<Vec<Twelve<f64>>>()
        });
        let ahead = (1..s).map(|i| {
            let gone = h * problem.tableau.nodes[i];
            let bodies = found[0].places.iter().zip(&rates[0]).zip(&found[i].places);
            bodies.map(|((begin, rate), at)| at.minus(begin).minus(&rate.scaled(gone))).collect()
        });
        let ahead: Vec<Vec<Twelve<f64>>> = ahead.collect();
        let scalars = scalars(problem, stages);
        let mut step = TreeStep {
            problem,
            family,
            reference: from,
            stages: found,
            rates,
            speeds,
            velocities,
            ahead,
            mixed: Vec::with_capacity(s),
            single: Vec::with_capacity(s),
            behind: Vec::with_capacity(s),
            scalars,
        };
        (0..s).for_each(|stage| step.add_forces(stage));
        step
    }

    /// `Σ_i weight_i w_i` in a stage, where the weights have their sign and length.
    pub fn weights(&self, stage: usize) -> Vec<f64> {
        let (s, tableau) = (self.problem.tableau.stages, self.problem.tableau);
        if stage + 1 < s {
            return tableau.b_matrix[stage * (s - 1)..][..s - 1].to_vec();
        }
        tableau.momentum_weights.iter().map(|weight| -weight / self.problem.step).collect()
    }

    /// The factor of forces and efforts in a stage.
    pub fn factor(&self, stage: usize) -> f64 {
        self.problem.factor(stage)
    }

    fn add_forces(&mut self, stage: usize) {
        let weights = self.weights(stage);
        let figures = &self.problem.figures.plain;
        let fall = figures.gravity.scaled(-self.factor(stage));
        let is_end = stage + 1 == self.stages.len();
        let bodies = figures.bodies.len();
        let mut mixed = Vec::with_capacity(bodies);
        for body in 0..bodies {
            let mut sum = Twelve::zero();
            if is_end {
                sum = self.rates[1][body].minus(&self.rates[0][body]);
            }
            for i in 0..weights.len() {
                sum = sum.plus(&self.ahead[i][body].scaled(weights[i]));
            }
            sum.origin = sum.origin + fall;
            mixed.push(sum);
        }
        let places = &self.stages[stage].places;
        let single: Vec<Forces> =
            (0..bodies).map(|body| Forces::on(&figures.bodies[body], &places[body], &mixed[body])).collect();
        let mut behind = single.clone();
        self.family.gather(&mut behind, |sum, own| *sum = sum.plus(own));
        self.mixed.push(mixed);
        self.single.push(single);
        self.behind.push(behind);
    }

    /// The residuals of the equations: of the stages k = 1..s−1, then of the end.
    pub fn residual(&self, efforts: &[Vec<f64>]) -> DVector<f64> {
        let free = self.problem.mode.free.len();
        let mut rows = DVector::zeros(self.stages.len() * free);
        for (stage, behind) in self.behind.iter().enumerate() {
            let (motions, factor) = (&self.stages[stage].motions, self.factor(stage));
            for (forces, own) in behind.iter().zip(&self.family.own) {
                let torque = forces.about();
                for freedom in own {
                    let Some(row) = freedom.row else { continue };
                    rows[stage * free + row] =
                        motions[freedom.index].power(forces.force, torque) - factor * efforts[stage][freedom.index];
                }
            }
            for (freedom, armature, scalar) in self.rotors() {
                let Some(row) = self.row(freedom) else { continue };
                let gained: f64 =
                    self.weights(stage).iter().zip(&scalar.ahead).map(|(weight, ahead)| weight * ahead).sum();
                let faster = match stage + 1 == self.stages.len() {
                    true => self.velocities[freedom] - self.problem.start.velocity[freedom],
                    false => 0.0,
                };
                rows[stage * free + row] += armature * (gained + faster);
            }
        }
        rows
    }

    /// The velocities of the carriers of all freedoms at the start (0) or the end (1): of the body before the joint, and for rotations with the
    /// slides of the joint.
    pub fn carrier_speeds(&self, end: usize) -> Vec<Twist> {
        let stage = &self.stages[end * (self.stages.len() - 1)];
        let velocities = [&self.problem.start.velocity[..], self.velocities][end];
        let mut carriers = vec![Twist::NONE; stage.motions.len()];
        for (parent, own) in self.family.parents.iter().zip(&self.family.own) {
            let mut carrier = parent.map_or(Twist::NONE, |parent| self.speeds[end][parent]);
            for freedom in own.iter().filter(|freedom| !freedom.is_rotation) {
                carriers[freedom.index] = carrier;
            }
            for freedom in own.iter().filter(|freedom| !freedom.is_rotation) {
                carrier = carrier.plus(&stage.motions[freedom.index].scaled(velocities[freedom.index]));
            }
            for freedom in own.iter().filter(|freedom| freedom.is_rotation) {
                carriers[freedom.index] = carrier;
            }
        }
        carriers
    }

    /// The entry of a freedom among those that move.
    pub fn row(&self, freedom: usize) -> Option<usize> {
        self.problem.mode.free.binary_search(&freedom).ok()
    }

    /// The rotors: freedom, armature, and the coordinate.
    pub fn rotors(&self) -> impl Iterator<Item = (usize, f64, &Scalar)> {
        let rotors = self.problem.figures.plain.rotors.iter();
        rotors.filter_map(|&(freedom, armature)| Some((freedom, armature, self.scalar(freedom)?)))
    }

    pub fn scalar(&self, freedom: usize) -> Option<&Scalar> {
        self.scalars.iter().find(|scalar| scalar.freedom == freedom)
    }

    /// Dampers and motors: freedom, and the coefficient of its rate.
    pub fn dampers(&self) -> impl Iterator<Item = (usize, f64)> {
        let drives = self.problem.mode.drives(&self.problem.figures.laws);
        let driven = drives.into_iter().map(|drive| (drive.coordinate.freedom, drive.kd));
        self.problem.figures.plain.dampers.iter().copied().chain(driven)
    }

    /// Springs and motors: freedom, and the coefficient of its place.
    pub fn springs(&self) -> impl Iterator<Item = (usize, f64)> {
        let drives = self.problem.mode.drives(&self.problem.figures.laws);
        let driven = drives.into_iter().map(|drive| (drive.coordinate.freedom, drive.kp));
        let springs = self.problem.figures.plain.springs.iter();
        springs.map(|spring| (spring.coordinate.freedom, spring.stiffness)).chain(driven)
    }
}

/// `Σ r_b / m_b² / Σ 1 / m_b²` of the centres of mass r_b: moments of light bodies about a distant point would be small differences of large
/// numbers. The point lies between light bodies of the same mass, as hands and feet.
fn among_the_lightest(figures: &Figures<f64>, at: &TreeStage) -> Vector<f64> {
    let heavy = || figures.bodies.iter().zip(&at.places).filter(|(body, _)| body.mass > 0.0);
    let least = heavy().fold(f64::INFINITY, |least, (body, _)| least.min(body.mass));
    let (mut sum, mut whole) = (NOUGHT, 0.0);
    for (body, place) in heavy() {
        let weight = (least / body.mass).powi(2);
        sum = sum + (place.origin + place.axes.apply(body.moment.scaled(1.0 / body.mass))).scaled(weight);
        whole += weight;
    }
    if whole > 0.0 { sum.scaled(1.0 / whole) } else { NOUGHT }
}

/// The coordinates with rotors, dampers, springs or motors.
fn scalars(problem: &StepProblem, stages: &[State]) -> Vec<Scalar> {
    let figures = &problem.figures.plain;
    let rotors = figures.rotors.iter().map(|&(freedom, _)| freedom);
    let dampers = figures.dampers.iter().map(|&(freedom, _)| freedom);
    let springs = figures.springs.iter().map(|spring| spring.coordinate.freedom);
    let motors = problem.mode.motors.iter().map(|(_, coordinate)| coordinate.freedom);
    let mut freedoms: Vec<usize> = rotors.chain(dampers).chain(springs).chain(motors).collect();
    freedoms.sort_unstable();
    freedoms.dedup();
    let (tableau, h) = (problem.tableau, problem.step);
    let of = |freedom: usize| {
        let position = crate::derivatives::forward::stage_equations::position_of(figures, freedom)?;
        let value = |state: &State| state.position[position] + state.compensation[position];
        let values: Vec<f64> = std::iter::once(problem.start).chain(stages).map(value).collect();
        let start_rate = problem.start.velocity[freedom];
        let ahead = (1..tableau.stages).map(|i| values[i] - values[0] - h * tableau.nodes[i] * start_rate);
        let ahead: Vec<f64> = ahead.collect();
        let rate = |stage: usize| {
            let weights = &tableau.velocity[stage * (tableau.stages - 1)..][..tableau.stages - 1];
            start_rate + weights.iter().zip(&ahead).map(|(weight, ahead)| weight * ahead).sum::<f64>() / h
        };
        let rates = (0..tableau.stages).map(rate).collect();
        Some(Scalar { freedom, values, ahead, rates })
    };
    freedoms.into_iter().filter_map(of).collect()
}

/// The efforts along all freedoms at all stages: those from outside, of springs, motors, dampers and loads.
pub(super) fn efforts(step: &TreeStep) -> Vec<Vec<f64>> {
    let (problem, figures) = (step.problem, &step.problem.figures.plain);
    let mut all: Vec<Vec<f64>> = problem.efforts.iter().map(|efforts| efforts.iter().copied().collect()).collect();
    for (stage, efforts) in all.iter_mut().enumerate() {
        for spring in &figures.springs {
            let Some(scalar) = step.scalar(spring.coordinate.freedom) else { continue };
            efforts[spring.coordinate.freedom] -= spring.stiffness * (scalar.values[stage] - spring.rest);
        }
        for drive in problem.mode.drives(&problem.figures.laws) {
            let Some(scalar) = step.scalar(drive.coordinate.freedom) else { continue };
            efforts[drive.coordinate.freedom] -= drive.kp * scalar.values[stage];
        }
        for (freedom, coefficient) in step.dampers() {
            let Some(scalar) = step.scalar(freedom) else { continue };
            efforts[freedom] -= coefficient * scalar.rates[stage];
        }
        figures.loads.iter().for_each(|&(freedom, effort)| efforts[freedom] += effort);
    }
    all
}
