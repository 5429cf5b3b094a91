//! The contacts that are reported: where bodies touch, and the forces between them.
//!
//! If several forces fit the law, the report has the forces of least compliance ([`crate::instant::cone`]), which are unique and do not pinch. If a
//! contact slides, it has the forces of the steps ([`crate::events::forces::closed_forces`]), because each pressure gives another motion.

use crate::events::forces::closed_forces::Closing;
use crate::events::modes::mode::Mode;
use crate::events::modes::present::Present;
use crate::instant::cone::problem::{Law, Unsolved, outside_cone};
use crate::instant::cone::{least_compliance, solve};
use crate::instant::dynamics::response::Response;
use crate::instant::holding::blocks::Of;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;

/// Forces outside their cones by less than this part of the largest are inside.
const ROUNDING: f64 = 1e-12;

/// Works out the forces that are reported, of one state after another.
#[derive(Clone)]
pub(crate) struct Reporting {
    response: Response,
    /// The state, the efforts and the mode of the last call.
    state: Option<(State, Vec<f64>, Mode)>,
    /// The forces on all rows then: where the next solution begins.
    forces: Vec<f64>,
    found: Vec<[f64; 3]>,
}

impl Reporting {
    /// For a mechanism.
    pub fn new(mechanism: &Mechanism) -> Self {
        Reporting { response: Response::new(mechanism), state: None, forces: Vec::new(), found: Vec::new() }
    }

    /// The forces at the closed contacts of a mode (N), along normals and tangents. If several fit the law, the ones of least compliance are taken.
    pub fn forces(&mut self, at: &Present, state: &State, efforts: &[f64], unique: bool) -> &[[f64; 3]] {
        // The forces of the same state are kept.
        let same = |(known, before, mode): &(State, Vec<f64>, Mode)| {
            known.position == state.position
                && known.velocity == state.velocity
                && before == efforts
                && mode.is_like(at.mode)
        };
        if self.found.len() == at.mode.contacts.len() && self.state.as_ref().is_some_and(same) {
            return &self.found;
        }
        let mut held = Closing::at(at, &mut self.response, state, efforts);
        let laws = held.laws();
        let slides = laws.iter().any(|law| matches!(law, Law::Sliding { .. }));
        // Sliding contacts move under the forces of the steps.
        let of_steps = (unique || slides).then(|| held.forces(unique));
        self.forces = if let Some(forces) = of_steps.filter(|forces| unique || fit(&laws, forces)) {
            forces
        } else {
            held.bound_moments(&held.forces(false));
            let problem = held.problem(&laws);
            match solve(&problem, Some(&self.forces)) {
                Ok(answer) => least_compliance(&problem, &answer),
                Err(Unsolved::Stopped { best }) => best.forces,
                Err(_) => held.forces(false),
            }
        };
        self.found.clear();
        let mut row = 0;
        for block in &held.blocks {
            if let Of::Contact(_) = block.of {
                let mut force = [0.0; 3];
                force[..block.rows.len()].copy_from_slice(&self.forces[row..row + block.rows.len()]);
                self.found.push(force);
            }
            row += block.rows.len();
        }
        self.state = Some((state.clone(), efforts.to_vec(), at.mode.clone()));
        &self.found
    }
}

/// Whether forces are within the cones and bounds of these laws, but for rounding.
fn fit(laws: &[Law], forces: &[f64]) -> bool {
    let rounding = ROUNDING * forces.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
    let mut row = 0;
    laws.iter().all(|law| {
        let own = &forces[row..];
        row += law.rows();
        match *law {
            Law::Interval { lower, upper } => own[0] >= lower - rounding && own[0] <= upper + rounding,
            Law::Sliding { .. } => own[0] >= -rounding,
            Law::Contact { friction } => outside_cone(friction, [own[0], own[1], own[2]]) <= rounding,
        }
    })
}
