//! The workspaces of the modes that a run has met, and of steps over many impacts: they hold no truth, and can be made anew at any time.
//!
//! Invariants: `current` and `last` are numbers of `pieces` as soon as a mode was entered; `earlier` are the figures of pieces that were given up,
//! to which those that are kept add their own.

use crate::events::crowd::step::Crowd;
use crate::events::forces::holding::Rooms;
use crate::events::modes::piece::Piece;
use crate::instant::dynamics::response::Response;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::ground::shared::Shared;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::stepping::step_maker::StepFigures;

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
    /// Of the steps of modes that are not kept any more, and of steps of first order.
    pub earlier: StepFigures,
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
            earlier: StepFigures::NONE,
        }
    }

    /// Forgets all modes, for another mechanism.
    pub fn replace(&mut self, mechanism: &Mechanism) {
        self.response = Shared::new(Response::new(mechanism));
        self.rooms.clear();
        self.pieces.clear();
        let interrupt = self.crowd.as_ref().and_then(|crowd| crowd.interrupt());
        self.crowd = Crowd::new(mechanism).map(Shared::new);
        if let (Some(crowd), Some(interrupt)) = (&mut self.crowd, interrupt) {
            crowd.heed(interrupt);
        }
    }

    /// The piece in use.
    pub fn active(&self) -> &Piece {
        &self.pieces[self.current]
    }

    /// The piece in use, to be changed.
    pub fn active_mut(&mut self) -> &mut Piece {
        &mut self.pieces[self.current]
    }

    /// What all steps so far tell of their errors.
    pub fn figures(&self) -> StepFigures {
        let mut all = self.earlier;
        self.pieces.iter().filter_map(|piece| piece.steps.as_ref()).for_each(|steps| all.include(&steps.figures()));
        all
    }

    /// Lets the companion go.
    pub fn leave_companion(&mut self) {
        self.accompanied = false;
        self.pieces.iter_mut().filter_map(|piece| piece.steps.as_mut()).for_each(|steps| steps.leave_companion());
    }
}
