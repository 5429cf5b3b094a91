//! The contacts of an event: which of them meet, as elements of the impact problem, and how they come to rest.
//!
//! ```text
//!     met:      n, t₁, t₂ of every contact with |φ| ≤ 1e-11 of its size, or of a pair that rebounds with φ ≤ −1e-8 φ̇ and 1e-9 of its size
//!     closed:   γ = φ̇ ≤ rest                          it may stay
//!     at rest:  closed, and |u_T| ≤ rest              friction may hold it
//! ```
//!
//! `rim_points.rs` adds the points that flat ends lack. `seizing.rs` stops contacts that slide and jam.

use crate::events::effects::decision::{Candidate, Decided, Scene, Yielding};
use crate::events::effects::immobile::at_dead_points;
use crate::events::effects::impact::Meeting;
use crate::events::effects::memory::Found;
use crate::events::effects::planar_rims::{land_opposite, point_that_begins, touching_point};
use crate::events::effects::resting::{bring_rows_to_rest, energy, joints_at_rest, keep_from_gaining};
use crate::events::finding::watched::Watched;
use crate::events::modes::mode::{Closed, Mode};
use crate::events::modes::tolerances::{
    BEYOND_LIMIT, BRIEF_SLIP, SHORTEST, SLIPS_TOGETHER, SLOWEST_SLIP, STOPPED_SLIP, slip_at_rest,
};
use crate::instant::cone::bounded::minimise;
use crate::instant::cone::problem::Law;
use crate::instant::holding::blocks::{Block, Of, Row, Rows, row_of_freedom, rows_of_contact};
use crate::instant::holding::elements::{ElementJoint, inward};
use crate::instant::holding::moments::Turning;
use crate::instant::holding::touching::{Contact, TOUCHED};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::contact::{Feature, Moments};
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::motion::touches::touch_motion;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// Overlaps of more than this part of the size of a pair are moved apart.
const OVERLAP: f64 = 1e-12;
/// Gaps up to this are closed (m).
const CLOSED: f64 = 1e-15;
/// Slips of contacts that jam may be faster than rest by this factor at most.
const JAMMED: f64 = 1e6;
/// A pair with more points than this at its flat ends is looked at without those that its load has needed before.
const MOST_POINTS: usize = 12;

/// The contacts of an event.
pub(crate) struct Contacts {
    pub(super) all: Vec<Contact>,
    /// Their numbers in the mode before, where they were closed.
    pub(super) known: Vec<Option<usize>>,
    /// Contacts on seams, which are not among all ([`crate::events::effects::seams`]).
    pub(super) seams: Vec<Contact>,
    /// Contacts that loops keep, which are not among all either ([`crate::instant::holding::kept_by_loops`]).
    pub(super) kept: Vec<Contact>,
    /// Contacts among all that did not press before the event, and do not by it ([`crate::events::effects::unpressed`]).
    pub(super) unpressed: Vec<Contact>,
    /// How many were there before points were added to flat ends.
    pub(super) gathered: usize,
    /// The numbers of those that slid there.
    slid: Vec<usize>,
    /// The contacts to be decided once impacts are over.
    pub candidates: Vec<Candidate>,
    /// Slower than this is rest [m/s].
    pub(super) rest: f64,
    /// The factor by which slips may be faster than rest and are still stopped; 1 unless contacts jam ([`Contacts::jams`]).
    jam: f64,
    /// Contacts that passed a border, and the speed that counts as rest for them ([`Contacts::goes_on`]).
    pub(super) gone_on: Vec<(Contact, f64)>,
    /// Slips whose stop was found may be faster than rest by this factor.
    stopped: f64,
}

impl Contacts {
    /// Those that touch in a state: the closed ones of the mode before, and of pairs in which something happens whatever touches.
    pub fn gather(scene: &Scene, before: &Mode, state: &State, found: &Found, fastest: f64) -> Self {
        let Scene { whole, touching, .. } = scene;
        let mut contacts = Contacts {
            all: Vec::new(),
            known: Vec::new(),
            seams: Vec::new(),
            kept: Vec::new(),
            unpressed: Vec::new(),
            gathered: 0,
            slid: Vec::new(),
            candidates: Vec::new(),
            rest: SLOWEST_SLIP,
            jam: 1.0,
            gone_on: Vec::new(),
            stopped: if found.brief { BRIEF_SLIP } else { STOPPED_SLIP },
        };
        let slid = before.contacts.iter().enumerate().filter(|(_, closed)| closed.slides.is_some());
        contacts.slid = slid.map(|(index, _)| index).collect();
        if touching.pairs.is_empty() {
            return contacts;
        }
        let bodies = body_states(whole, state);
        let speeds = bodies.iter().map(|body| body.velocity.norm());
        contacts.rest = SLOWEST_SLIP.max(slip_at_rest(speeds.fold(fastest, f64::max)));
        // Nothing happens in the others, which have no contacts.
        let mut asked: BTreeSet<usize> = before.contacts.iter().map(|closed| closed.contact.pair).collect();
        asked.extend(&before.idle);
        asked.extend(before.kept.iter().chain(&before.unpressed).chain(&before.seams).map(|contact| contact.pair));
        asked.extend(found.triggers.iter().filter_map(|trigger| match trigger {
            Watched::Approach(pair) => Some(*pair),
            _ => None,
        }));
        if found.anew {
            asked.extend(scene.near);
        }
        let within = |pair: usize| {
            let of = &touching.pairs[pair];
            if found.anew { of.closed_anew() } else { of.within(TOUCHED) }
        };
        let mut sought = Vec::new();
        for pair in asked {
            let of = &touching.pairs[pair];
            let closed = || before.contacts.iter().enumerate().filter(|(_, closed)| closed.contact.pair == pair);
            let happens = |trigger: &Watched| match *trigger {
                Watched::Approach(of) => of == pair,
                Watched::Feature(contact) => before.contacts[contact].contact.pair == pair,
                Watched::Returns(unpressed) => before.unpressed[unpressed].pair == pair,
                // A flat end is looked at without the points that its load has needed before.
                Watched::Margin => closed().any(|(_, closed)| closed.contact.flat_end().is_some()),
                _ => false,
            };
            // Each event may have added a point towards its centre of pressure.
            let many = closed().filter(|(_, closed)| closed.contact.flat_end().is_some()).count() > MOST_POINTS;
            if found.anew || many || before.is_idle(pair) || found.triggers.iter().any(happens) {
                let within = within(pair);
                // Other places of a pair that rebounds, which would close sooner than a step can be solved, meet with the first. Without restitution they
                // stay where the first has, in whichever order, and their gaps must not be closed by a motion.
                let meets = of.restitution > 0.0 && found.triggers.contains(&Watched::Approach(pair));
                let at_most = if meets { of.closed_anew() } else { within };
                let rate = |contact: &Contact| touch_motion(&contact.joint, &bodies).rate;
                let is_met = |(contact, gap): &(Contact, f64)| *gap <= within || *gap <= -rate(contact) * SHORTEST;
                let near = touching.near(pair, &bodies, at_most).into_iter().filter(is_met);
                let near = near.map(|(contact, _)| contact).collect();
                let mut near = touching.slowest(pair, &bodies, [within; 2], near, contacts.rest);
                if found.triggers.contains(&Watched::Approach(pair)) {
                    let pivots: Vec<&Contact> = closed().map(|(_, closed)| &closed.contact).collect();
                    land_opposite(touching, &pivots, &mut near, &bodies);
                }
                contacts.take_near(scene, before, pair, near, found.triggers, &bodies);
                sought.push(pair);
            } else {
                contacts.known.extend(closed().map(|(index, _)| Some(index)));
                contacts.all.extend(closed().map(|(_, closed)| closed.contact.clone()));
            }
        }
        contacts.take_flush(scene, before, sought, within, &bodies);
        contacts.take_unpressed(scene, before, found, &bodies);
        contacts.leave_out_seams(touching, &bodies, 0);
        contacts.gathered = contacts.all.len();
        contacts
    }

    /// Takes out those of these numbers, with the numbers that they had before; returns them.
    pub(super) fn take_out(&mut self, leaves: impl Fn(usize) -> bool) -> Vec<Contact> {
        let mut number = 0..self.known.len();
        self.known.retain(|_| number.next().is_some_and(|number| !leaves(number)));
        let all = std::mem::take(&mut self.all).into_iter().enumerate();
        let (out, stay): (Vec<_>, Vec<_>) = all.partition(|(number, _)| leaves(*number));
        self.all = stay.into_iter().map(|(_, contact)| contact).collect();
        out.into_iter().map(|(_, contact)| contact).collect()
    }

    /// Whether some are at the rim of an end that lies flat.
    pub fn has_flat_ends(&self) -> bool {
        self.all.iter().any(|contact| contact.flat_end().is_some())
    }

    /// Hands them over.
    pub fn take(self) -> Vec<Contact> {
        self.all
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// The pair of a block, where it is one of a contact.
    pub fn pair_of(&self, of: Of) -> Option<usize> {
        match of {
            Of::Contact(index) => Some(self.all[index].pair),
            Of::Joint(_) | Of::Moment { .. } => None,
        }
    }

    /// All of them as things that are met; without restitution in a crowd of impacts.
    pub fn meetings(&self, scene: &Scene, state: &State, crowded: bool) -> Vec<Meeting> {
        if self.all.is_empty() {
            return Vec::new();
        }
        let bodies = body_states(scene.whole, state);
        let meeting = |(index, contact): (usize, &Contact)| {
            let pair = &scene.touching.pairs[contact.pair];
            let restitution = if crowded { 0.0 } else { pair.restitution };
            Meeting { block: self.block(scene, &bodies, index), restitution, rest: self.rest_of(contact) }
        };
        self.all.iter().enumerate().map(meeting).collect()
    }

    /// Slower rates than this [m/s] count as rest, too, because impulses leave as much.
    pub fn rest_below(&mut self, rounding: f64) {
        self.rest = self.rest.max(rounding);
    }

    /// A contact as a block whose friction may hold it.
    pub(super) fn block(&self, scene: &Scene, bodies: &[BodyState], index: usize) -> Block {
        let contact = &self.all[index];
        let friction = scene.touching.pairs[contact.pair].friction;
        let rows = rows_of_contact(scene.whole, bodies, &contact.joint, friction > 0.0);
        let law = Law::of_contact(friction, None);
        Block { of: Of::Contact(index), law, rows }
    }

    /// Rims at rest that begin to tilt in a plane touch at one point ([`crate::events::effects::planar_rims`]).
    pub fn begin_to_tilt(&self, scene: &Scene, state: &State, decided: &Decided, closed: &mut [Closed]) {
        if !closed
            .iter()
            .any(|closed| matches!(closed.contact.joint.touch.features, [Feature::Plane, Feature::Rim { .. }]))
        {
            return;
        }
        let bodies = body_states(scene.whole, state);
        let accelerations = decided.of_bodies(scene.whole, state, &bodies);
        let largest =
            accelerations.iter().fold(scene.whole.gravity.norm(), |most, (linear, _)| most.max(linear.norm()));
        for Closed { contact, .. } in closed {
            if let Some(point) =
                point_that_begins(scene.touching, contact, &bodies, &accelerations, (self.rest, largest))
            {
                *contact = point;
            }
        }
    }

    /// Takes the contacts that do not part as candidates, and removes the remainders of ended rates from the velocities; returns the energy that this
    /// takes (J).
    pub fn come_to_rest(&mut self, scene: &mut Scene, state: &mut State, yielding: &Yielding) -> f64 {
        self.candidates.clear();
        if self.all.is_empty() {
            return 0.0;
        }
        let bodies = body_states(scene.whole, state);
        let still = joints_at_rest(scene.elements, state);
        // An impulse along a joint at a dead point moves it by roundings, and the rest of its loop by anything.
        let dead = at_dead_points(scene.whole, scene.response, state, &still);
        let fixed: Vec<usize> = still.iter().copied().filter(|freedom| !dead.contains(freedom)).collect();
        for contact in &mut self.all {
            if let Some(point) = touching_point(scene.touching, contact, &bodies, self.rest) {
                *contact = point;
            }
        }
        // The contacts of one pair stop together, up to the differences of forces that are not unique.
        let mut together: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
        for (contact, known) in self.all.iter().zip(&self.known) {
            let (slip, most) = together.entry(contact.pair).or_insert((0.0, SLIPS_TOGETHER));
            *slip = slip.max(touch_motion(&contact.joint, &bodies).slip.norm());
            let stops = known.is_some_and(|known| yielding.stops.contains(&known));
            if stops || yielding.stops_together.contains(&contact.pair) {
                *most = self.stopped;
            }
        }
        let (mut rows, mut candidates) = (Vec::new(), Vec::new());
        for (index, contact) in self.all.iter().enumerate() {
            let touch = touch_motion(&contact.joint, &bodies);
            let rubs = scene.touching.pairs[contact.pair].friction > 0.0;
            if touch.rate > self.rest_of(contact) {
                continue;
            }
            let is = |list: &[usize]| self.known[index].is_some_and(|known| list.contains(&known));
            let (slip, (largest, most)) = (touch.slip.norm(), together[&contact.pair]);
            let own = if is(&yielding.stops) { self.stopped.max(self.jam) } else { self.jam };
            let sticks = slip <= own * self.rest || largest <= most * self.rest;
            let slip = if sticks { Vector3::zeros() } else { touch.slip };
            let own = rows_of_contact(scene.whole, &bodies, &contact.joint, rubs && sticks);
            rows.extend(own);
            let slides = is(&yielding.slides) || is(&self.slid);
            let opens = is(&yielding.opens) || self.unpressed.contains(contact);
            let turning = self.turning_above_rest(scene, &bodies, index, &yielding.halts);
            rows.extend(self.rows_of_rest(scene, &bodies, index, &turning));
            let turns = [false, true].map(|spinning| self.is_among(index, spinning, &yielding.turns));
            candidates.push(Candidate { contact: contact.clone(), slip, slides, opens, turning, turns });
        }
        self.candidates = candidates;
        rows.extend(fixed.iter().map(|&freedom| row_of_freedom(state.velocity.len(), freedom, 1.0)));
        let mut lost = bring_rows_to_rest(scene, state, rows.clone());
        lost += self.close_gaps(scene, state, &bodies, &fixed);
        still.iter().for_each(|&freedom| state.velocity[freedom] = 0.0);
        // Tiny slips turn when others come to rest, and stop if these contacts hold their points.
        let bodies = body_states(scene.whole, state);
        let held = rows.len();
        for candidate in self.candidates.iter_mut().filter(|candidate| candidate.slip != Vector3::zeros()) {
            let slip = touch_motion(&candidate.contact.joint, &bodies).slip;
            if slip.norm() > self.rest {
                candidate.slip = slip;
            } else {
                candidate.slip = Vector3::zeros();
                let rubs = scene.touching.pairs[candidate.contact.pair].friction > 0.0;
                rows.extend(rows_of_contact(scene.whole, &bodies, &candidate.contact.joint, rubs));
            }
        }
        for candidate in self.candidates.iter_mut().filter(|candidate| candidate.turning != Turning::default()) {
            let joint = &candidate.contact.joint;
            let Turning { across, along } = Turning::of(joint, &bodies, &touch_motion(joint, &bodies).normal);
            let turning = &mut candidate.turning;
            turning.across = if turning.across == Vector3::zeros() { turning.across } else { across };
            turning.along = if turning.along == 0.0 { 0.0 } else { along };
        }
        if rows.len() > held {
            lost += bring_rows_to_rest(scene, state, rows);
            still.iter().for_each(|&freedom| state.velocity[freedom] = 0.0);
        }
        lost
    }

    /// Moves overlapping contacts apart, by the least motion in the metric of the mass matrix that keeps joints within limits; returns the energy that this
    /// takes (J). An event that was found late leaves such overlaps. The energy of the gained height is taken from the velocities. A joint on a bound is
    /// put back on it if roundings have moved it off, because one that is beside its bound would not meet it.
    pub fn move_apart(&self, scene: &mut Scene, state: &mut State) -> f64 {
        let bodies = body_states(scene.whole, state);
        let gap = |contact: &Contact| touch_motion(&contact.joint, &bodies).gap;
        let mut gaps: Vec<f64> = self.all.iter().map(gap).collect();
        let deep = |(gap, contact): (&f64, &Contact)| *gap < -scene.touching.pairs[contact.pair].within(OVERLAP);
        if !gaps.iter().zip(&self.all).any(deep) {
            return 0.0;
        }
        let normal = |contact: &Contact| rows_of_contact(scene.whole, &bodies, &contact.joint, false);
        let mut rows: Vec<Row> = self.all.iter().flat_map(normal).collect();
        let mut apart = vec![(0.0, f64::INFINITY); gaps.len()];
        let on = scene.elements.joints.iter().filter_map(|joint| Some((joint, joint.side(joint.position(state))?)));
        let on: Vec<(&ElementJoint, Side)> = on.collect();
        for (joint, side) in &on {
            rows.push(row_of_freedom(state.velocity.len(), joint.coordinate.freedom, inward(*side)));
            gaps.push(0.0);
            apart.push((if joint.is_locked() { f64::NEG_INFINITY } else { 0.0 }, f64::INFINITY));
        }
        let rows = Rows::new(scene.response, state, rows);
        let mut change = vec![0.0; state.velocity.len()];
        rows.add(&minimise(&rows.square, &gaps, &apart).efforts, &mut change);
        let before = energy(scene.whole, state).total();
        state.displace(scene.whole, &change);
        for (joint, side) in on {
            let gap = joint.gap(side, joint.position(state)).abs();
            if gap > joint.at_limit(side) && gap <= BEYOND_LIMIT {
                joint.put_on(side, state);
            }
        }
        keep_from_gaining(scene, state, before)
    }

    /// Moves the candidates onto each other to the last bit, because a remaining gap of 1e-12 m would be a velocity in a short step. The energy of
    /// the gained height is taken from the velocities, because it would feed small bounces. Returns the energy that this takes (J).
    fn close_gaps(&self, scene: &mut Scene, state: &mut State, bodies: &[BodyState], still: &[usize]) -> f64 {
        let gap = |candidate: &Candidate| touch_motion(&candidate.contact.joint, bodies).gap;
        let mut gaps: Vec<f64> = self.candidates.iter().map(gap).collect();
        if gaps.iter().all(|gap| gap.abs() <= CLOSED) {
            return 0.0;
        }
        let normal = |contact: &Contact| rows_of_contact(scene.whole, bodies, &contact.joint, false);
        let mut rows: Vec<Row> = self.candidates.iter().flat_map(|candidate| normal(&candidate.contact)).collect();
        rows.extend(still.iter().map(|&freedom| row_of_freedom(state.velocity.len(), freedom, 1.0)));
        let wide = |(gap, candidate): (&f64, &Candidate)| {
            gap.abs() > scene.touching.pairs[candidate.contact.pair].within(OVERLAP)
        };
        // Steps of first order leave gaps that are no roundings: what parts must not be pushed into its partner.
        let parting = if gaps.iter().zip(&self.candidates).any(wide) { self.parting() } else { Vec::new() };
        gaps.resize(rows.len(), 0.0);
        let mut bounds = vec![(f64::NEG_INFINITY, f64::INFINITY); gaps.len()];
        for contact in parting {
            rows.extend(normal(contact));
            gaps.push(touch_motion(&contact.joint, bodies).gap);
            bounds.push((0.0, f64::INFINITY));
        }
        let rows = Rows::new(scene.response, state, rows);
        let pushes = minimise(&rows.square, &gaps, &bounds).efforts;
        let mut change = vec![0.0; state.velocity.len()];
        rows.add(&pushes, &mut change);
        still.iter().for_each(|&freedom| change[freedom] = 0.0);
        let before = energy(scene.whole, state).total();
        state.displace(scene.whole, &change);
        keep_from_gaining(scene, state, before).max(0.0)
    }

    /// Those that part.
    fn parting(&self) -> Vec<&Contact> {
        let stays = |contact: &Contact| self.candidates.iter().any(|candidate| candidate.contact == *contact);
        self.all.iter().filter(|contact| !stays(contact)).collect()
    }

    /// Keeps all candidates closed, and sliding if they slip: the fallback if the law could not be solved.
    pub fn keep_closed(&self) -> Vec<Closed> {
        let closed = |candidate: &Candidate| Closed {
            contact: candidate.contact.clone(),
            slides: candidate.slip.try_normalize(0.0),
            on_cone: false,
            moments: Moments::default(),
        };
        self.candidates.iter().filter(|candidate| !candidate.opens).map(closed).collect()
    }

    /// Whether more tiny slips are stopped from now on, because contacts that slide have no consistent accelerations together: a slip that falls this
    /// fast stops within the next instant. The slowest are stopped first. False if every slip is too fast.
    pub fn jams(&mut self) -> bool {
        let slips = self.candidates.iter().map(|candidate| candidate.slip.norm());
        let slowest = slips.filter(|slip| *slip > 0.0).fold(f64::INFINITY, f64::min);
        while self.jam < JAMMED {
            self.jam = STOPPED_SLIP.max(10.0 * self.jam);
            if slowest <= self.jam * self.rest {
                return true;
            }
        }
        false
    }
}
