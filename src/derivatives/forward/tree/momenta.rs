//! The momenta of velocities on a tree, and how they vary with places and inertial numbers while the velocities stay.
//!
//! ```text
//!     p_r = s_r · Σ_(bodies behind r) M Q̇,        Q̇ = V Q,   V = Σ_(freedoms before) s_f v_f
//!     places displaced by T, freedoms carried by C:       δV = Σ (C_f × s_f) v_f        δQ̇ = δV Q + V (T Q)
//!     δp_r = s_r · Σ (M δQ̇ + δM Q̇ + forces carried by T) + (C_r × s_r) · Σ M Q̇
//! ```
//!
//! Forces, motions and displacements are defined as in a step ([`crate::derivatives::forward::tree::column`]), at one place.

use crate::derivatives::equations::figures::Figures;
use crate::derivatives::forward::figure_slopes::FigureSlopes;
use crate::derivatives::forward::spatial::{Forces, NOUGHT, Twist};
use crate::derivatives::forward::tree::displaced::Displaced;
use crate::derivatives::forward::tree::family::{Family, Freedom, TreeStage};
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use crate::mechanism::motion::state::State;
use nalgebra::{DMatrix, DVector};

/// Velocities of a tree at a place, with their momenta.
pub(in crate::derivatives) struct Momenta<'m> {
    figures: &'m Figures<f64>,
    velocities: &'m [f64],
    family: Family,
    at: TreeStage,
    /// V and Q̇ of all bodies.
    speeds: Vec<Twist>,
    rates: Vec<Twelve<f64>>,
    /// M Q̇ of each body, and with all bodies behind it.
    single: Vec<Forces>,
    behind: Vec<Forces>,
}

impl<'m> Momenta<'m> {
    /// Of velocities (n) at the place of a state.
    pub fn new(figures: &'m Figures<f64>, state: &State, velocities: &'m [f64]) -> Self {
        let all: Vec<usize> = (0..figures.freedoms).collect();
        let family = Family::new(figures, &all);
        let at = TreeStage::at(figures, state, NOUGHT);
        let speeds = at.speeds(&family, velocities);
        let rates: Vec<Twelve<f64>> = speeds.iter().zip(&at.places).map(|(speed, place)| speed.moves(place)).collect();
        let bodies = figures.bodies.iter().zip(at.places.iter().zip(&rates));
        let single: Vec<Forces> = bodies.map(|(body, (place, rate))| Forces::on(body, place, rate)).collect();
        let mut behind = single.clone();
        family.gather(&mut behind, |sum, own| *sum = sum.plus(own));
        Momenta { figures, velocities, family, at, speeds, rates, single, behind }
    }

    /// ∂p/∂q (n × n).
    pub fn by_positions(&self) -> DMatrix<f64> {
        let n = self.figures.freedoms;
        let mut found = DMatrix::zeros(n, n);
        for freedom in 0..n {
            let own = |other: usize| if other == freedom { self.at.motions[freedom] } else { Twist::NONE };
            let displaced = Displaced::of(&self.family, own, None::<fn(usize) -> [Twist; 2]>);
            found.set_column(freedom, &self.varied(&displaced));
        }
        found
    }

    /// ∂p/∂θ (n) of figures.
    pub fn by_figures(&self, slopes: &FigureSlopes) -> DVector<f64> {
        let mut rows = match slopes.frames() {
            None => DVector::zeros(self.figures.freedoms),
            Some(frames) => {
                let of = |body: usize| self.frames_in_world(body, &frames[body]);
                self.varied(&Displaced::of(&self.family, |_| Twist::NONE, Some(of)))
            }
        };
        let forces = self.at.places.iter().zip(&self.rates).zip(slopes.inertial());
        let on = |((place, rate), slope): ((&Twelve<f64>, &Twelve<f64>), &Option<_>)| {
            slope.as_ref().map_or([NOUGHT; 2], |slope| {
                let forces = Forces::on(slope, place, rate);
                [forces.force, forces.about()]
            })
        };
        self.add_along(forces.map(on).collect(), &mut rows);
        for &(freedom, slope) in &slopes.plain.rotors {
            rows[freedom] += slope * self.velocities[freedom];
        }
        rows
    }

    /// The motions in the world of the frames of a joint, on the parent and on the child, from their motions where they are fixed.
    fn frames_in_world(&self, body: usize, motions: &[Twist; 2]) -> [Twist; 2] {
        let figures = &self.figures.bodies[body];
        let world = Twelve { origin: NOUGHT, axes: Matrix::identity() };
        let on = [figures.parent, Some(body)];
        let frames = [&figures.on_parent, &figures.on_child];
        [0, 1].map(|which: usize| {
            let place = on[which].map_or(&world, |body| &self.at.places[body]);
            let origin = place.origin + place.axes.apply(frames[which].origin);
            let turn = place.axes.apply(motions[which].turn);
            Twist { turn, shift: place.axes.apply(motions[which].shift) + origin.cross(turn) }
        })
    }

    /// δp (n) of displaced places.
    fn varied(&self, displaced: &Displaced) -> DVector<f64> {
        let count = self.figures.bodies.len();
        let carried = |body: usize, freedom: &Freedom| {
            displaced.carriers[body][usize::from(freedom.is_rotation)].carries(&self.at.motions[freedom.index])
        };
        let mut speeds: Vec<Twist> = Vec::with_capacity(count);
        let mut loads = Vec::with_capacity(count);
        for body in 0..count {
            let mut speed = self.family.parents[body].map_or(Twist::NONE, |parent| speeds[parent]);
            for freedom in &self.family.own[body] {
                speed = speed.plus(&carried(body, freedom).scaled(self.velocities[freedom.index]));
            }
            let (place, by) = (&self.at.places[body], &displaced.bodies[body]);
            let rate = speed.moves(place).plus(&self.speeds[body].turns(&by.moves(place)));
            let forces = Forces::on(&self.figures.bodies[body], place, &rate);
            loads.push([forces.force, forces.about() + self.single[body].carried(by)]);
            speeds.push(speed);
        }
        let mut rows = DVector::zeros(self.figures.freedoms);
        self.add_along(loads, &mut rows);
        for (body, behind) in self.behind.iter().enumerate() {
            let torque = behind.about();
            for freedom in &self.family.own[body] {
                rows[freedom.index] += carried(body, freedom).power(behind.force, torque);
            }
        }
        rows
    }

    /// Adds forces and torques on bodies along all freedoms.
    fn add_along(&self, mut loads: Vec<[Vector<f64>; 2]>, rows: &mut DVector<f64>) {
        self.family.gather(&mut loads, |sum, own| *sum = [sum[0] + own[0], sum[1] + own[1]]);
        for (own, [force, torque]) in self.family.own.iter().zip(loads) {
            for freedom in own {
                rows[freedom.index] += self.at.motions[freedom.index].power(force, torque);
            }
        }
    }
}
