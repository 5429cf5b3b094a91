//! The workspaces of the modes that a run has met, and of steps over many impacts: they hold no truth, and can be made anew at any time.
//!
//! Invariants: `current` and `last` are numbers of `pieces` as soon as a mode was entered; `between` and `ringing` are figures of pieces that were
//! given up, to which those that are kept add their own.

use crate::events::crowd::step::Crowd;
use crate::events::forces::holding::Rooms;
use crate::events::modes::piece::Piece;
use crate::instant::dynamics::response::Response;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::shared::Shared;
use crate::mechanism::motion::integrator::MethodDescription;

/// The larger of two errors, if both are known.
pub(crate) fn larger(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    Some(one?.max(other?))
}

/// The workspaces of a run.
#[derive(Clone)]
pub(crate) struct Workspaces {
    /// One for each mode that is kept: the reduced mechanism, and its steps.
    pub pieces: Vec<Shared<Piece>>,
    /// What works out the forces that hold joints in these modes, while they are not in use.
    pub rooms: Rooms,
    /// The piece in use, and the piece of the last step.
    pub current: usize,
    pub last: usize,
    /// Accelerations and velocities under efforts and impulses.
    pub response: Shared<Response>,
    /// Steps over many impacts, for mechanisms that can make them.
    pub crowd: Option<Shared<Crowd>>,
    /// Method description used while every joint is held.
    pub idle: MethodDescription,
    /// Whether a companion goes along until the first event.
    pub accompanied: bool,
    /// The error of samples inside the steps of modes that are not kept any more, and in steps of first order (m).
    pub between: Option<f64>,
    /// The part of it in steps that were too long for a damper (m).
    pub ringing: f64,
}

impl Workspaces {
    pub fn new(mechanism: &Mechanism, idle: MethodDescription) -> Self {
        Workspaces {
            pieces: Vec::new(),
            rooms: Rooms::default(),
            current: 0,
            last: 0,
            response: Shared::new(Response::new(mechanism)),
            crowd: Crowd::new(mechanism).map(Shared::new),
            idle,
            accompanied: false,
            between: Some(0.0),
            ringing: 0.0,
        }
    }

    /// Forgets all modes, for another mechanism.
    pub fn replace(&mut self, mechanism: &Mechanism) {
        self.response = Shared::new(Response::new(mechanism));
        self.rooms.clear();
        self.pieces.clear();
        self.crowd = Crowd::new(mechanism).map(Shared::new);
    }

    /// The piece in use.
    pub fn active(&self) -> &Piece {
        &self.pieces[self.current]
    }

    /// The piece in use, to be changed.
    pub fn active_mut(&mut self) -> &mut Piece {
        &mut self.pieces[self.current]
    }

    /// Whether stability, and not accuracy, has limited a step.
    pub fn was_held_by_stability(&self) -> bool {
        self.pieces.iter().filter_map(|piece| piece.steps.as_ref()).any(|steps| steps.was_held_by_stability())
    }

    /// The error of samples inside the steps so far, beside the error of their ends (m); `None` if it is not known.
    pub fn between(&self) -> Option<f64> {
        let pieces = self.pieces.iter().filter_map(|piece| piece.steps.as_ref());
        pieces.map(|steps| steps.between()).fold(self.between, larger)
    }

    /// The largest error of samples inside steps that were too long for a damper, so far (m).
    pub fn ringing_inside(&self) -> f64 {
        let pieces = self.pieces.iter().filter_map(|piece| piece.steps.as_ref());
        pieces.map(|steps| steps.ringing_inside()).fold(self.ringing, f64::max)
    }

    /// Lets the companion go.
    pub fn leave_companion(&mut self) {
        self.accompanied = false;
        self.pieces.iter_mut().filter_map(|piece| piece.steps.as_mut()).for_each(|steps| steps.leave_companion());
    }
}
