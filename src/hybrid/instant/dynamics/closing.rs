//! The closures of a mechanism at one instant after another: where they are, and the accelerations that fit them.
//!
//! ```text
//!     H a = τ − c + Jᵀ μ,    J a + J̇ v = 0
//! ```
//!
//! Which equations of the closures are independent is decided once, in the first state ([`known`]).

use crate::lobatto::coupled::counted::Counted;
use crate::lobatto::coupled::deciding::known;
use crate::lobatto::coupled::projection::Projection;
use crate::lobatto::stages::start::Start;
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::gaps::gap_accelerations;
use crate::mechanism::motion::kinematics::{BodyAcceleration, body_accelerations};
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;
use std::sync::Arc;

/// The workspace of one mechanism.
#[derive(Clone)]
pub(crate) struct Closing {
    projection: Projection,
    start: Start,
    /// μ of the accelerations that were asked for last.
    multipliers: Vec<f64>,
    decided: bool,
    /// Whether velocities were projected in the state that was taken last.
    projected: bool,
    /// The count of the closures in the first state.
    counted: Option<Arc<Counted>>,
    /// The time of the state that was taken last (s).
    time: f64,
}

impl Closing {
    /// The workspace for a mechanism; `None` if it has no closures.
    pub fn new(mechanism: &Mechanism) -> Option<Self> {
        mechanism.has_closures().then(|| {
            let projection = Projection::new(mechanism);
            let multipliers = vec![0.0; projection.row_count()];
            Closing {
                projection,
                start: Start::new(mechanism),
                multipliers,
                decided: false,
                projected: false,
                counted: None,
                time: 0.0,
            }
        })
    }

    /// Takes the count of the closures in the first state that will be asked for.
    pub fn expect_at(&mut self, counted: Option<Arc<Counted>>) {
        self.counted = counted;
    }

    /// Takes a state.
    pub fn place(&mut self, mechanism: &Mechanism, state: &State) {
        self.start.set(mechanism, state);
        self.time = state.time;
        self.projected = false;
        if !std::mem::replace(&mut self.decided, true) {
            let counted = self.counted.take().filter(|counted| counted.is_at(state));
            let counted = counted.unwrap_or_else(|| Arc::new(Counted::at(mechanism, state)));
            self.projection.heed(known(&counted, mechanism));
        }
    }

    /// Makes joint accelerations of the tree fit the closures, in the state that was taken last, which places the bodies; `room` has one entry a
    /// body.
    pub fn accelerations(
        &mut self,
        mechanism: &Mechanism,
        velocity: &[f64],
        bodies: &[BodyState],
        accelerations: &mut [f64],
        room: &mut [BodyAcceleration],
    ) {
        let Closing { projection, start, multipliers, projected, time, .. } = self;
        *projected = false;
        projection.accelerations(start, accelerations, multipliers, |joints, gaps| {
            body_accelerations(mechanism, bodies, velocity, joints, room);
            gap_accelerations(mechanism, *time, bodies, joints, room, gaps);
        });
    }

    /// Makes changes of velocities fit the closures in the state that was taken last, with the least change in the metric of H. Later ones in the
    /// same state use the factors of the first.
    pub fn changes(&mut self, mechanism: &Mechanism, velocity: &mut [f64]) {
        self.projection.take_motions(false);
        self.project(mechanism, velocity);
    }

    /// The same of velocities: joints that are moved in time have their rates.
    pub fn velocities(&mut self, mechanism: &Mechanism, velocity: &mut [f64]) {
        self.projection.take_motions(true);
        self.project(mechanism, velocity);
    }

    fn project(&mut self, mechanism: &Mechanism, velocity: &mut [f64]) {
        if std::mem::replace(&mut self.projected, true) {
            self.projection.velocities_again(mechanism, &self.start, velocity);
        } else {
            self.projection.velocities(mechanism, &self.start, velocity);
        }
    }

    /// The load of a loop joint at the accelerations that were asked for last: force (N), and torque about the point of its second end [N m].
    pub fn loop_wrench(&self, index: usize) -> (Vector3<f64>, Vector3<f64>) {
        self.projection.loop_wrench(index, &self.multipliers)
    }
}
