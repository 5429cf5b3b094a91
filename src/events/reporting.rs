//! The contacts that are reported: where bodies touch, and the forces between them.
//!
//! Where several forces fit the law those of least compliance are told ([`crate::instant::cone`]), which are unique and do not pinch.

use crate::events::closed_forces::{Chosen, blocks, offsets};
use crate::events::present::Present;
use crate::instant::blocks::{Of, Rows};
use crate::instant::cone::problem::{Law, Problem, Unsolved};
use crate::instant::cone::{least_compliance, solve};
use crate::instant::response::Response;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// Works out the forces that are reported, of one state after another.
pub(crate) struct Reporting {
    response: Response,
    /// The state and efforts that were asked for last.
    state: Option<(State, Vec<f64>)>,
    /// The forces on all rows then: where the next solution begins.
    forces: Vec<f64>,
    found: Vec<[f64; 3]>,
}

impl Reporting {
    /// For a mechanism.
    pub fn new(mechanism: &Mechanism) -> Self {
        Reporting { response: Response::new(mechanism), state: None, forces: Vec::new(), found: Vec::new() }
    }

    /// The forces at the closed contacts of a mode (N), along normals and tangents. Where several fit the law those of least compliance.
    pub fn forces(&mut self, at: &Present, state: &State, efforts: &[f64], unique: bool) -> &[[f64; 3]] {
        // What is held stays where it is.
        let same = |(known, before): &(State, Vec<f64>)| {
            known.position == state.position && known.velocity == state.velocity && before == efforts
        };
        if self.found.len() == at.mode.contacts.len() && self.state.as_ref().is_some_and(same) {
            return &self.found;
        }
        let bodies = body_states(at.whole, state);
        let blocks = blocks(at, &bodies);
        let rows = Rows::of(&mut self.response, state, &blocks);
        let offset = offsets(at, &mut self.response, state, efforts, &blocks, &bodies);
        self.forces = if unique {
            Chosen::new(&blocks).solve(&rows.square, &offset, true)
        } else {
            let laws: Vec<Law> = blocks.iter().map(|block| block.law).collect();
            let problem = Problem { mobility: &rows.square, free: &offset, laws: &laws };
            match solve(&problem, Some(&self.forces)) {
                Ok(answer) => least_compliance(&problem, &answer),
                Err(Unsolved::Stopped { best }) => best.forces,
                Err(_) => Chosen::new(&blocks).solve(&rows.square, &offset, false),
            }
        };
        self.found.clear();
        let mut row = 0;
        for block in &blocks {
            if let Of::Contact(_) = block.of {
                let mut force = [0.0; 3];
                force[..block.rows.len()].copy_from_slice(&self.forces[row..row + block.rows.len()]);
                self.found.push(force);
            }
            row += block.rows.len();
        }
        self.state = Some((state.clone(), efforts.to_vec()));
        &self.found
    }
}
