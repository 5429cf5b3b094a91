//! The impulses of a step of first order: of all limits, contacts and joint friction that may close or hold in it.
//!
//! ```text
//!     v̄ = v_f + Y Wᵀ P,   0 ≤ P_N ⊥ u_N + φ/h ≥ 0        in rounds, until no pair that was far has come near
//! ```

use crate::events::closing::{Closing, impulses_among, limits_in, pressed_in};
use crate::events::finding::speeds::{speed_at, speed_of};
use crate::events::integrator::Eventful;
use crate::events::stepwise::Pushed;
use crate::instant::cone::problem::Law;
use crate::instant::holding::blocks::{Block, Of, Rows, rows_of_contact};
use crate::instant::holding::elements::{ElementJoint, inward};
use crate::instant::holding::moments::{Turning, blocks_of_turning};
use crate::instant::holding::per_pair::PerPair;
use crate::instant::holding::touching::Contact;
use crate::mechanism::description::body_state::WORLD;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// Points move in a step by at most this many times the distance that they would move at the rates of its start.
const MOVES: f64 = 1.25;
/// Rounds in which pairs are added that come near because others push them.
const WIDENED: usize = 4;
/// A step in which it moves by this part of the size of the pair is short enough, however thin the shapes are.
const THIN: f64 = 1e-3;

/// What was seen of a pair.
struct Looked {
    pair: usize,
    /// Its distance (m), and whether that is near enough.
    distance: f64,
    near: bool,
}

/// The gap of a joint on a side after a step with these rates (rad or m).
fn gap_after(joint: &ElementJoint, side: Side, start: &State, step: f64, velocity: &[f64]) -> f64 {
    joint.gap(side, joint.position(start)) + step * inward(side) * velocity[joint.coordinate.freedom]
}

impl Eventful {
    /// Rebounds that a step leaves out, and the energy that they would give back, `½ e² P |γ⁻|` each (J). An impact slower than the fall in one step
    /// has no rebound.
    fn left_out(
        &self,
        blocks: &[Block],
        sides: &[Option<Side>],
        contacts: &[Contact],
        impulses: &[f64],
        before: &[f64],
    ) -> (usize, f64) {
        let slow = 2.0 * self.first_order_length() * self.model.whole.gravity.norm();
        let (mut row, mut count, mut sum) = (0, 0, 0.0);
        for (block, side) in blocks.iter().zip(sides) {
            let restitution = match (block.of, side) {
                (Of::Joint(joint), Some(_)) => self.model.elements.joints[joint].restitution,
                (Of::Joint(_), None) | (Of::Moment { .. }, _) => 0.0,
                (Of::Contact(contact), _) => self.model.touching.pairs[contacts[contact].pair].restitution,
            };
            if restitution > 0.0 && impulses[row] > 0.0 && before[row] < -slow {
                (count, sum) = (count + 1, sum - 0.5 * restitution.powi(2) * impulses[row] * before[row]);
            }
            row += block.rows.len();
        }
        (count, sum)
    }

    /// Blocks that may close or hold in a step of this length from a state, for velocities without it, and their gaps (m or rad). Pairs as far from
    /// each other as `wider` (m) are among them, and so are the limits `reached`. Returns also what was seen of each pair.
    fn closing_within(
        &mut self,
        step: f64,
        start: &State,
        velocity: &[f64],
        wider: &PerPair<f64>,
        reached: &[(usize, Side)],
    ) -> (Closing, Vec<Looked>) {
        let Closing { mut blocks, mut gaps, mut contacts, mut sides } = Closing::default();
        for (index, joint) in self.model.elements.joints.iter().enumerate() {
            let freedom = joint.coordinate.freedom;
            let mut add = |bounds: [f64; 2], side: Option<Side>, gap: f64| {
                blocks.push(Block::of_joint(index, freedom, velocity.len(), side.map_or(1.0, inward), bounds));
                gaps.push(gap);
                sides.push(side);
            };
            if joint.friction > 0.0 {
                let most = step * joint.friction;
                add([-most, most], None, 0.0);
            }
            for side in joint.sides() {
                let gap = joint.gap(side, joint.position(start));
                // One that bears may be pushed by contacts alone.
                let bears = gap <= joint.at_limit(side);
                if bears || reached.contains(&(index, side)) || gap_after(joint, side, start, step, velocity) < 0.0 {
                    add([0.0, f64::INFINITY], Some(side), gap);
                }
            }
        }
        let bodies = body_states(&self.model.whole, start);
        self.look_ahead(&bodies, |body, reach| {
            let fastest = bodies[body].velocity.norm() + bodies[body].angular_velocity.norm() * reach;
            2.0 * step * fastest + 5.0 * step * step
        });
        let mut seen = Vec::with_capacity(self.trial.near.pairs().len());
        for &pair in self.trial.near.pairs() {
            let of = &self.model.touching.pairs[pair];
            let ends = of.parts.iter().flat_map(|(bodies, reach)| bodies.iter().zip(reach));
            let speed = ends.filter_map(|(body, reach)| {
                let state = &bodies[(*body)?];
                Some(state.velocity.norm() + state.angular_velocity.norm() * reach.min(of.size()))
            });
            let within =
                (2.0 * step * speed.sum::<f64>() + 10.0 * step * step).max(wider.get(pair).copied().unwrap_or(0.0));
            let distance = self.model.touching.distance_within(pair, &bodies, within);
            seen.push(Looked { pair, distance, near: distance <= within });
            if distance > within {
                continue;
            }
            for (contact, gap) in self.model.touching.near(pair, &bodies, within) {
                // Contacts that loops keep have no determinate impulse.
                if self.mode.kept.iter().any(|kept| kept.is_at(&contact)) {
                    continue;
                }
                let rows = rows_of_contact(&self.model.whole, &bodies, &contact.joint, of.friction > 0.0);
                let law = Law::of_contact(of.friction, None);
                blocks.push(Block { of: Of::Contact(contacts.len()), law, rows });
                let (number, whole) = (contacts.len(), &self.model.whole);
                let still = Turning::default();
                blocks.extend(blocks_of_turning(whole, &bodies, &contact.joint, &of.moments, number, &still));
                gaps.push(gap);
                gaps.resize(blocks.len(), 0.0);
                contacts.push(contact);
                sides.resize(blocks.len(), None);
            }
        }
        (Closing { blocks, gaps, contacts, sides }, seen)
    }

    /// Adds the free accelerations, and the impulses of all blocks that may close in a step, to velocities at its start. A pair that was far may come
    /// near because others push it: it is then looked at as well, and so is a limit beyond which others push a joint. A step that turns out to be too
    /// long is not looked at further, unless it is made all the same: all that very fast bodies may meet would count.
    pub(super) fn pushed(
        &mut self,
        step: f64,
        start: &State,
        free: &[f64],
        velocity: &mut [f64],
        made_anyway: bool,
    ) -> Pushed {
        let mut wider: PerPair<f64> = PerPair::default();
        let mut reached: Vec<(usize, Side)> = Vec::new();
        let mut round = 0;
        loop {
            for ((rate, before), acceleration) in velocity.iter_mut().zip(&start.velocity).zip(free) {
                *rate = before + step * acceleration;
            }
            let (Closing { blocks, gaps, contacts, sides }, seen) =
                self.closing_within(step, start, velocity, &wider, &reached);
            let (mut pressed, mut limits, mut rebounds, mut driven) = (Vec::new(), Vec::new(), (0, 0.0), 0.0);
            if !blocks.is_empty() {
                let rows = Rows::of(&mut self.workspaces.response, start, &blocks);
                let mut rates = rows.rates(velocity);
                let mut row = 0;
                for (block, gap) in blocks.iter().zip(&gaps) {
                    rates[row] += gap / step;
                    row += block.rows.len();
                }
                let impulses = impulses_among(&rows, &rates, &blocks);
                rows.add(&impulses, velocity);
                driven = rows.work_of_belts(&impulses);
                let before = rows.rates(&start.velocity);
                rebounds = self.left_out(&blocks, &sides, &contacts, &impulses, &before);
                pressed = pressed_in(&blocks, &gaps, &contacts, &impulses);
                limits = limits_in(&blocks, &gaps, &sides, &impulses);
            }
            let moving = body_states(&self.model.whole, &State { velocity: velocity.to_vec(), ..start.clone() });
            let (mut part, before) = (1.0_f64, reached.len());
            for (index, joint) in self.model.elements.joints.iter().enumerate() {
                for side in joint.sides() {
                    let is_beyond = gap_after(joint, side, start, step, velocity) < -joint.at_limit(side);
                    if is_beyond && !reached.contains(&(index, side)) {
                        reached.push((index, side));
                    }
                }
            }
            let mut widened = reached.len() > before;
            for &Looked { pair, distance, near } in &seen {
                let of = &self.model.touching.pairs[pair];
                let moves = MOVES * step * speed_of(of, &moving);
                let through = of.breadth.max(THIN * of.size()) + if near { 0.0 } else { distance };
                if near || !made_anyway {
                    part = part.min(if moves > through { 0.5 * through / moves } else { 1.0 });
                }
                if !near && distance <= moves {
                    (*wider.of(pair), widened) = (moves, true);
                }
            }
            if part < 1.0 && !made_anyway {
                let near = Vec::new();
                return Pushed { pressed, limits, near, rebounds, driven, part };
            }
            // Pairs that were left out may come near because others push them.
            let begins = body_states(&self.model.whole, start);
            widened |= self.look_ahead(&begins, |body, reach| {
                MOVES * step * speed_at([moving[body], WORLD], [reach, f64::INFINITY])
            });
            if !widened || round == WIDENED {
                let near = seen.iter().filter(|looked| looked.near).map(|looked| looked.pair).collect();
                return Pushed { pressed, limits, near, rebounds, driven, part };
            }
            round += 1;
        }
    }
}
