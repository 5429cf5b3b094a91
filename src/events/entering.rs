//! A mode is entered: its reduced mechanism, the pace at which steps go on, and the watched functions.
//!
//! ```text
//!     mode, state ─▶ what is held, closures ─▶ key ─▶ piece: known, or made in the place of the one that has not been used for longest
//!                                                  ─▶ holding, watched
//! ```

use crate::events::crowding::STEP;
use crate::events::effects::immobile::held_bodies;
use crate::events::finding::watched::Watched;
use crate::events::forces::holding::Holding;
use crate::events::integrator::{Eventful, larger};
use crate::events::modes::drives::Drives;
use crate::events::modes::instants::Instants;
use crate::events::modes::mode::MotorMode;
use crate::events::modes::piece::{Key, Piece};
use crate::events::modes::present::Present;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::held::Closures;
use crate::instant::holding::held::Held;
use crate::mechanism::ground::shared::Shared;
use crate::mechanism::motion::kinematics::place_bodies;
use crate::mechanism::motion::state::State;
use crate::stepping::integrator::StepPace;
use std::sync::Arc;

/// Modes whose workspaces are kept.
const KEPT_MODES: usize = 12;
/// The first step after an event is asked to be at least this long (s).
const RENEWED: f64 = 1e-6;

impl Eventful {
    /// Finds or makes the reduced mechanism of the mode, and its watched functions.
    pub(super) fn enter(&mut self, state: &mut State) {
        let Eventful { whole, elements, touching, mode, response, bodies, .. } = self;
        let held = if self.asleep {
            vec![true; whole.bodies.len()]
        } else {
            held_bodies(whole, elements, mode, response, state)
        };
        let closures = if mode.contacts.is_empty() {
            Closures::default()
        } else {
            place_bodies(whole, state, bodies);
            mode.closures(touching, bodies)
        };
        for (body, _) in whole.bodies.iter().zip(&held).filter(|(_, held)| **held) {
            state.velocity[body.joint.velocity_range()].fill(0.0);
        }
        response.close_velocities(state);
        for (body, _) in whole.bodies.iter().zip(&held).filter(|(_, held)| **held) {
            state.velocity[body.joint.velocity_range()].fill(0.0);
        }
        let places = whole.bodies.iter().zip(&held).filter(|(_, held)| **held);
        let places = places.map(|(body, _)| state.position[body.joint.position_index]).collect();
        let motors = mode.motors.iter().map(|motor| *motor == MotorMode::Unbounded).collect();
        let key = Key { held, places, motors, closures };
        let pace = self.pieces.get(self.current).and_then(|piece| piece.steps.as_ref());
        let pace = pace.map_or(StepPace::Grid { origin: self.began }, |steps| steps.pace(self.began));
        // The causes of short steps before do not apply to this mode. A failed step has become as short as steps can be; the next step is at least as
        // long as the step of first order that replaces it.
        let least = if self.stepped_over.is_some() { STEP } else { RENEWED };
        let pace = match pace {
            StepPace::Step { length, kinetic } if length > 0.0 => StepPace::Step { length: length.max(least), kinetic },
            pace => pace,
        };
        self.current = self.piece(key, state);
        let piece = &mut self.pieces[self.current];
        piece.used = self.steps;
        piece.small = piece.moving.gather(&self.whole, state);
        if let Some(steps) = &mut piece.steps {
            steps.go_on_at(pace, state.time);
        }
        self.holding = {
            let Eventful { whole, elements, touching, mode, pieces, current, response, .. } = self;
            let present = Present { whole, elements, touching, mode, moving: &pieces[*current].moving };
            Holding::new(&present, response, state)
        };
        let moving = &self.pieces[self.current].moving;
        let apart = |pair: usize| {
            let [a, b] = self.touching.pairs[pair].bodies.map(|body| body.and_then(|body| moving.group(body)));
            a != b
        };
        let unique = self.holding.is_unique();
        self.watched = if self.asleep {
            Vec::new()
        } else {
            Watched::of(&self.elements, &self.touching, &self.mode, unique, apart)
        };
    }

    /// The number of the piece with this key.
    fn piece(&mut self, key: Key, state: &State) -> usize {
        if let Some(known) = self.pieces.iter().position(|piece| piece.key == key) {
            return known;
        }
        let mut moving = Held::new(&self.whole, state, key.held.clone(), &key.closures);
        let drives = Drives::add(&self.elements, &self.mode, &self.whole, &mut moving);
        let Elements { joints, motors, .. } = &self.elements;
        let rubbing = joints.iter().filter(|joint| joint.friction > 0.0).map(|joint| joint.coordinate);
        let acting = rubbing.chain(motors.iter().map(|motor| motor.coordinate));
        let acting = acting.filter_map(|coordinate| moving.coordinate(&self.whole, coordinate));
        let driven: Vec<usize> = acting.map(|coordinate| coordinate.body).collect();
        // Stages and steps were accepted for the whole.
        let mut steps = if moving.is_empty() { None } else { self.recipe.make(&moving.mechanism, &driven).ok() };
        if let Some(steps) = steps.as_mut().filter(|_| self.accompanied) {
            steps.accompany(&moving.mechanism);
        }
        let (positions, freedoms) = (moving.mechanism.position_count, moving.mechanism.velocity_count);
        let small = State::zero(&moving.mechanism);
        let piece = Shared::new(Piece {
            key,
            drives,
            steps,
            law: None,
            small_start: small.clone(),
            small,
            small_efforts: vec![0.0; freedoms],
            small_position: vec![0.0; positions],
            small_velocity: vec![0.0; freedoms],
            instants: Instants::default(),
            used: self.steps,
            moving: Arc::new(moving),
        });
        let oldest =
            (0..self.pieces.len()).filter(|&index| index != self.last).min_by_key(|&index| self.pieces[index].used);
        match oldest {
            Some(oldest) if self.pieces.len() >= KEPT_MODES => {
                if let Some(steps) = &self.pieces[oldest].steps {
                    let of_piece = steps.description();
                    self.idle.include_stability(&of_piece);
                    self.idle.few_stage_steps += of_piece.few_stage_steps;
                    self.between = larger(self.between, steps.between());
                    self.ringing = self.ringing.max(steps.ringing_inside());
                }
                self.pieces[oldest] = piece;
                oldest
            }
            _ => {
                self.pieces.push(piece);
                self.pieces.len() - 1
            }
        }
    }
}
