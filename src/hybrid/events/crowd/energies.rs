//! No step of a crowd gains energy.
//!
//! ```text
//!     E⁺ ≤ E + W         of each group of trees that touch:  the rates are scaled by √((T − gain)/T)
//! ```
//!
//! W is the work of motors, efforts and forces without a potential (J). A gain that is larger than the kinetic energy T, as of a lift of bodies at rest, is a debt of the next motion.
//! All trees are one group if forces act between bodies, or loads.

use crate::crowd::islands::groups;
use crate::crowd::tree::Tree;
use crate::crowd::trees::Trees;
use crate::events::crowd::contacts::Contacts;
use crate::events::effects::resting::work_of_forces;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::energy::energy_with_forces;
use crate::mechanism::motion::state::State;

/// A gain of this part of the energies is rounding.
const ROUNDING: f64 = 1e-15;

/// The energies of the trees at the start of a step, and their debts.
#[derive(Clone)]
pub(super) struct Energies {
    /// Whether forces act that do not belong to one tree.
    together: bool,
    potential: Vec<f64>,
    kinetic: Vec<f64>,
    debt: Vec<f64>,
    /// The energies of the whole where the step begins and where it ends (J).
    total: [f64; 2],
}

impl Energies {
    pub fn new(mechanism: &Mechanism) -> Self {
        let forces = &mechanism.forces;
        let in_joints =
            forces.joint_loads.is_empty() && forces.joint_courses.is_empty() && forces.gravity_compensations.is_empty();
        let on_links = forces.wrenches.is_empty() && forces.link_loads.is_empty() && forces.drags.is_empty();
        let together = !(in_joints && on_links && forces.point_springs.is_empty());
        Energies { together, potential: Vec::new(), kinetic: Vec::new(), debt: Vec::new(), total: [0.0; 2] }
    }

    /// Takes the energies of a state in which a step begins, and that places the bodies, where the last step did not end.
    pub fn place(&mut self, mechanism: &Mechanism, state: &State, bodies: &[BodyState], trees: &Trees) {
        self.debt.resize(trees.trees.len(), 0.0);
        self.potential = potentials(mechanism, state, bodies, trees);
        self.total[1] = energy_with_forces(mechanism, &state.position, bodies).total();
    }

    /// The kinetic energy of rates (J).
    pub fn kinetic_of(&self, trees: &Trees, velocity: &[f64]) -> f64 {
        kinetics(trees, velocity).iter().sum()
    }

    /// Takes the energies where a step begins, with the trees placed there.
    pub fn begin(&mut self, trees: &Trees, velocity: &[f64]) {
        self.total[0] = self.total[1];
        self.kinetic = kinetics(trees, velocity);
    }

    /// The work of forces without a potential in a step (s) with this middle (J).
    pub fn work_of_forces(&self, mechanism: &Mechanism, middle: Option<&State>, step: f64) -> f64 {
        middle.filter(|_| self.together).map_or(0.0, |middle| work_of_forces(mechanism, middle, step))
    }

    /// Scales the rates at the end of a step of each group that has gained energy beside its work along the freedoms (J); returns the energy taken (J).
    pub fn bound(
        &mut self,
        trees: &Trees,
        mechanism: &Mechanism,
        state: &mut State,
        bodies: &[BodyState],
        work: &[f64],
        contacts: [&Contacts; 2],
    ) -> f64 {
        let potential = potentials(mechanism, state, bodies, trees);
        let kinetic = kinetics(trees, &state.velocity);
        let groups = if self.together {
            vec![(0..trees.trees.len()).collect()]
        } else {
            let sides = contacts.into_iter().flat_map(|contacts| contacts.list.iter().map(|candidate| candidate.sides));
            groups(trees.trees.len(), sides)
        };
        let mut taken = 0.0;
        for group in groups {
            let sum = |values: &[f64]| group.iter().map(|&tree| values[tree]).sum::<f64>();
            let freedoms = group.iter().flat_map(|&tree| &trees.trees[tree].all);
            let worked: f64 = freedoms.clone().map(|&freedom| work[freedom]).sum();
            let own = sum(&kinetic);
            let gained = own - sum(&self.kinetic) + sum(&potential) - sum(&self.potential) - worked;
            let size = own + sum(&self.kinetic) + worked.abs();
            let owed = gained + sum(&self.debt);
            group.iter().for_each(|&tree| self.debt[tree] = 0.0);
            if owed <= ROUNDING * size {
                continue;
            }
            let paid = owed.min(own);
            self.debt[group[0]] = owed - paid;
            taken += paid;
            let factor = if own > 0.0 { ((own - paid) / own).max(0.0).sqrt() } else { 0.0 };
            freedoms.for_each(|&freedom| state.velocity[freedom] *= factor);
        }
        self.potential = potential;
        taken
    }

    /// The energy that a step has lost beside a work (J), whose end places the bodies.
    pub fn lost(&mut self, mechanism: &Mechanism, end: &State, bodies: &[BodyState], work: f64) -> f64 {
        self.total[1] = energy_with_forces(mechanism, &end.position, bodies).total();
        self.total[0] + work - self.total[1]
    }
}

/// ½ vᵀ M v of each tree (J).
fn kinetics(trees: &Trees, velocity: &[f64]) -> Vec<f64> {
    let of = |tree: &Tree| {
        let own = || tree.freedoms.iter().map(|&freedom| velocity[freedom]);
        let rows = tree.mass.chunks_exact(tree.freedoms.len().max(1));
        let momenta = rows.map(|row| row.iter().zip(own()).map(|(entry, rate)| entry * rate).sum::<f64>());
        0.5 * own().zip(momenta).map(|(rate, momentum)| rate * momentum).sum::<f64>()
    };
    trees.trees.iter().map(of).collect()
}

/// The potential energy of gravity and joint springs of each tree, and of all other forces in the first (J).
fn potentials(mechanism: &Mechanism, state: &State, bodies: &[BodyState], trees: &Trees) -> Vec<f64> {
    let mut of = vec![0.0; trees.trees.len()];
    for (index, body) in mechanism.bodies.iter().enumerate() {
        of[trees.of_body[index]] -= body.mass * mechanism.gravity.dot(&bodies[index].position);
    }
    let mut springs = 0.0;
    for spring in &mechanism.forces.joint_springs {
        let energy = spring.energy(state.position[spring.coordinate.position]);
        springs += energy;
        of[trees.of_freedom[spring.coordinate.freedom].0] += energy;
    }
    if let Some(first) = of.first_mut().filter(|_| mechanism.forces.joint_springs.len() < count_of_forces(mechanism)) {
        let all = energy_with_forces(mechanism, &state.position, bodies);
        *first += all.spring + all.load - springs;
    }
    of
}

fn count_of_forces(mechanism: &Mechanism) -> usize {
    let forces = &mechanism.forces;
    forces.joint_springs.len() + forces.point_springs.len() + forces.wrenches.len() + forces.joint_loads.len()
}
