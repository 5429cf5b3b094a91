//! Puts contacts and limits that have borne a step of first order exactly onto each other.

use crate::events::closing::{Bearing, Pressed};
use crate::events::integrator::Eventful;
use crate::instant::cone::bounded::minimise;
use crate::instant::holding::blocks::{Row, Rows, row_of_freedom, rows_of_contact};
use crate::instant::holding::elements::inward;
use crate::instant::start::assembly::assemble_nearby;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;

/// The most rounds in which contacts that have pressed are put onto each other.
const LANDINGS: usize = 4;
/// The rounds end when the gaps are at most this part of the size of their pair. Contacts that are farther apart than `NEAR` of it have parted.
const LANDED: f64 = 1e-13;
const NEAR: f64 = 1e-4;
/// A limit is reached if its gap is at most this many times the gap that counts as being on it.
const NEARLY: f64 = 100.0;

impl Eventful {
    /// Puts contacts that have pressed in a step onto each other, and joints onto the limits that have borne them, by the least motion. Their
    /// velocities are projected as well: held contacts hold still, and sliding ones keep a normal rate of zero. Normals turn in a step, and a
    /// remaining gap would fall back in the next step as an impact.
    pub(super) fn land(&mut self, pressed: &[Pressed], limits: &[Bearing], state: &mut State) {
        let joints = &self.model.elements.joints;
        let limit_gap = |limit: &Bearing, state: &State| {
            let joint = &joints[limit.joint];
            joint.gap(limit.side, joint.position(state))
        };
        let limit_row = |limit: &Bearing, count: usize| {
            row_of_freedom(count, joints[limit.joint].coordinate.freedom, inward(limit.side))
        };
        let of = |pressed: &Pressed| &self.model.touching.pairs[pressed.contact.pair];
        for _ in 0..LANDINGS {
            let bodies = body_states(&self.model.whole, state);
            let gap = |pressed: &&Pressed| touch_motion(&pressed.contact.joint, &bodies).gap;
            let near = |pressed: &&Pressed| gap(pressed).abs() <= of(pressed).within(NEAR);
            let landing: Vec<&Pressed> = pressed.iter().filter(near).collect();
            let mut gaps: Vec<f64> = landing.iter().map(gap).collect();
            let landed = landing.iter().zip(&gaps).all(|(pressed, gap)| gap.abs() <= of(pressed).within(LANDED));
            let on_limit = |limit: &Bearing| limit_gap(limit, state).abs() <= joints[limit.joint].at_limit(limit.side);
            if landed && limits.iter().all(on_limit) {
                break;
            }
            let normal =
                |pressed: &&Pressed| rows_of_contact(&self.model.whole, &bodies, &pressed.contact.joint, false);
            let mut rows: Vec<Row> = landing.iter().flat_map(normal).collect();
            rows.extend(limits.iter().map(|limit| limit_row(limit, state.velocity.len())));
            gaps.extend(limits.iter().map(|limit| limit_gap(limit, state)));
            let rows = Rows::new(&mut self.workspaces.response, state, rows);
            let mut change = vec![0.0; state.velocity.len()];
            rows.add(&pull(&rows, &gaps), &mut change);
            state.displace(&self.model.whole, &change);
            let _ = assemble_nearby(&self.model.whole, state);
        }
        let bodies = body_states(&self.model.whole, state);
        let closed = pressed.iter().filter(|pressed| {
            let now = touch_motion(&pressed.contact.joint, &bodies).gap.abs();
            pressed.gap.abs().max(now) <= of(pressed).closed_anew()
        });
        let rows = closed
            .flat_map(|pressed| rows_of_contact(&self.model.whole, &bodies, &pressed.contact.joint, pressed.holds));
        let mut rows: Vec<Row> = rows.collect();
        let bears = |limit: &&Bearing| limit.gap <= joints[limit.joint].at_limit(limit.side);
        rows.extend(limits.iter().filter(bears).map(|limit| limit_row(limit, state.velocity.len())));
        if !rows.is_empty() {
            let rows = Rows::new(&mut self.workspaces.response, state, rows);
            rows.add(&pull(&rows, &rows.rates(&state.velocity)), &mut state.velocity);
        }
        for limit in limits {
            let joint = &joints[limit.joint];
            if limit_gap(limit, state).abs() <= NEARLY * joint.at_limit(limit.side) {
                joint.put_on(limit.side, state);
            }
            if bears(&limit) {
                state.velocity[joint.coordinate.freedom] = 0.0;
            }
        }
    }
}

/// The efforts along rows that bring these values of them to zero, with the least change of the vector that the rows act on.
fn pull(rows: &Rows, values: &[f64]) -> Vec<f64> {
    minimise(&rows.square, values, &vec![(f64::NEG_INFINITY, f64::INFINITY); values.len()]).efforts
}
