//! A mode is entered: its reduced mechanism, the pace at which steps go on, and the watched functions.
//!
//! ```text
//!     mode, state ─▶ what is held, closures ─▶ key ─▶ piece: known, or made in the place of the one that has not been used for longest
//!                                                  ─▶ holding, watched
//! ```

use crate::events::crowded::LENGTHS;
use crate::events::effects::immobile::held_bodies;
use crate::events::finding::watched::Watched;
use crate::events::forces::holding::Holding;
use crate::events::integrator::Eventful;
use crate::events::modes::drives::Drives;
use crate::events::modes::instants::Instants;
use crate::events::modes::mode::MotorMode;
use crate::events::modes::piece::{Key, Piece};
use crate::events::modes::present::Present;
use crate::events::modes::tolerances::slip_at_rest;
use crate::events::parts::model::HybridModel;
use crate::events::parts::trial::StepTrial;
use crate::events::parts::workspaces::Workspaces;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::held::Closures;
use crate::instant::holding::held::Held;
use crate::mechanism::ground::shared::Shared;
use crate::mechanism::motion::kinematics::place_bodies;
use crate::mechanism::motion::state::State;
use crate::stepping::step_maker::StepPace;
use std::sync::Arc;

/// Modes whose workspaces are kept.
const KEPT_MODES: usize = 12;
/// The first step after an event is asked to be at least this long (s).
const RENEWED: f64 = 1e-6;

impl Eventful {
    /// Finds or makes the reduced mechanism of the mode, and its watched functions.
    pub(super) fn enter(&mut self, state: &mut State) {
        self.look_around(state);
        self.progress.entered = state.time;
        let Eventful {
            model: HybridModel { whole, elements, touching, .. },
            workspaces: Workspaces { response, .. },
            trial: StepTrial { bodies, loose, reserves, .. },
            mode,
            ..
        } = self;
        let held = if self.progress.asleep {
            vec![true; whole.bodies.len()]
        } else {
            held_bodies(whole, elements, touching, mode, response, state)
        };
        let closures = if mode.contacts.is_empty() {
            Closures::default()
        } else {
            place_bodies(whole, state, bodies);
            mode.closures(touching, bodies)
        };
        loose.take(&closures);
        // Bodies that others do not touch are as far apart as they were.
        reserves.forget(|pair| loose.still_fly(touching.pairs[pair].all_bodies()));
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
        let pace = self.workspaces.pieces.get(self.workspaces.current).and_then(|piece| piece.steps.as_ref());
        let pace =
            pace.map_or(StepPace::Grid { origin: self.progress.began }, |steps| steps.step_pace(self.progress.began));
        // The causes of short steps before do not apply to this mode. A failed step has become as short as steps can be; the next step is at least as
        // long as the step of first order that replaces it.
        let least = if self.progress.stepped_over.is_some() { LENGTHS[0] } else { RENEWED };
        let pace = match pace {
            StepPace::Step { length, kinetic } if length > 0.0 => StepPace::Step { length: length.max(least), kinetic },
            pace => pace,
        };
        let Workspaces { pieces, current, rooms, .. } = &mut self.workspaces;
        if let Some(piece) = pieces.get(*current) {
            self.trial.holding.give_back(&piece.moving, rooms);
        }
        self.workspaces.current = self.piece(key, state);
        let Workspaces { pieces, current, rooms, .. } = &mut self.workspaces;
        let room = rooms.take(&pieces[*current].moving);
        let piece = self.workspaces.active_mut();
        piece.used = self.tally.steps;
        piece.small = piece.moving.gather(&self.model.whole, state);
        if let Some(steps) = &mut piece.steps {
            steps.keep_pace(pace, state.time);
        }
        self.trial.holding = {
            let Eventful {
                model: HybridModel { whole, elements, touching, .. },
                workspaces: Workspaces { pieces, current, response, .. },
                mode,
                memory,
                ..
            } = self;
            let (moving, rest) = (&pieces[*current].moving, slip_at_rest(memory.fastest));
            let present = Present { whole, elements, touching, mode, moving, rest };
            Holding::new(&present, response, state, room)
        };
        let unique = self.trial.holding.is_unique();
        self.trial.watched = if self.progress.asleep {
            Vec::new()
        } else {
            let HybridModel { elements, touching, .. } = &self.model;
            Watched::of(elements, touching, &self.mode, self.trial.near.pairs(), unique, |pair| self.moves_apart(pair))
        };
    }

    /// The number of the piece with this key.
    fn piece(&mut self, key: Key, state: &State) -> usize {
        if let Some(known) = self.workspaces.pieces.iter().position(|piece| piece.key == key) {
            return known;
        }
        let mut moving = Held::new(&self.model.whole, state, key.held.clone(), &key.closures);
        let drives = Drives::add(&self.model.elements, &self.mode, &self.model.whole, &mut moving);
        let Elements { joints, motors, .. } = &self.model.elements;
        let rubbing = joints.iter().filter(|joint| joint.friction > 0.0).map(|joint| joint.coordinate);
        let acting = rubbing.chain(motors.iter().map(|motor| motor.coordinate));
        let acting = acting.filter_map(|coordinate| moving.coordinate(&self.model.whole, coordinate));
        let driven: Vec<usize> = acting.map(|coordinate| coordinate.body).collect();
        // Stages and steps were accepted for the whole.
        let mut steps = if moving.is_empty() { None } else { self.model.recipe.make(&moving.mechanism, &driven).ok() };
        if let Some(steps) = steps.as_mut().filter(|_| self.workspaces.accompanied) {
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
            used: self.tally.steps,
            moving: Arc::new(moving),
        });
        let oldest = (0..self.workspaces.pieces.len())
            .filter(|&index| index != self.workspaces.last)
            .min_by_key(|&index| self.workspaces.pieces[index].used);
        match oldest {
            Some(oldest) if self.workspaces.pieces.len() >= KEPT_MODES => {
                if let Some(steps) = &self.workspaces.pieces[oldest].steps {
                    let of_piece = steps.description();
                    self.workspaces.idle.include_stability(&of_piece);
                    self.workspaces.idle.few_stage_steps += of_piece.few_stage_steps;
                    self.workspaces.earlier.include(&steps.figures());
                }
                self.workspaces.pieces[oldest] = piece;
                oldest
            }
            _ => {
                self.workspaces.pieces.push(piece);
                self.workspaces.pieces.len() - 1
            }
        }
    }
}
