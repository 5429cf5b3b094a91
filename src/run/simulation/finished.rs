//! The results of a run: its state, its figures so far, the accuracy to expect, and the data at its end.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::{Event, JointStatus};
use crate::mechanism::motion::integrator::{Integrator, MethodDescription};
use crate::mechanism::motion::state::State;
use crate::simulation::integrators::Integrators;
use crate::simulation::method::step_choice::StepChoice;
use crate::simulation::parallel::islands::IslandFigures;
use crate::simulation::run::{Progress, Simulation};
use crate::simulation::steps::course::Course;
use crate::simulation::steps::summary::Summary;
use crate::simulation::tolerance::accuracy::{Accuracy, UnknownAccuracy};

/// The results of a finished run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The state at its end; if it ended early, the last state that all islands have reached.
    pub state: State,
    /// Its figures up to there.
    pub summary: Summary,
    /// How steps were made.
    pub method: MethodDescription,
    /// The figures of each island, or of several that were run together; empty for a single island.
    pub islands: Vec<IslandFigures>,
    /// The first thousand events, in order of time.
    pub events: Vec<Event>,
    /// The state of the joint of each body at the end.
    pub joints: Vec<JointStatus>,
    /// The closed contacts at the end, in the order of their pairs.
    pub contacts: Vec<ContactPoint>,
    /// [`Simulation::held_efforts`] at the end.
    pub held: Vec<Option<f64>>,
    /// [`Simulation::accuracies`] at the end.
    pub accuracy: Vec<Result<Accuracy, UnknownAccuracy>>,
    /// [`Simulation::end`].
    pub end: f64,
    /// [`Simulation::parts`].
    pub parts: (usize, usize),
}

impl Simulation<'_> {
    /// The simulated mechanism.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// The state of the run.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// When it ends (s).
    pub fn end(&self) -> f64 {
        self.end
    }

    /// How steps are chosen.
    pub fn choice(&self) -> StepChoice {
        self.choice
    }

    /// How steps are made, and how they have gone so far.
    pub fn description(&self) -> MethodDescription {
        self.integrators.description()
    }

    /// Number of unconnected parts, and how many of them start at rest in equilibrium and are not simulated.
    pub fn parts(&self) -> (usize, usize) {
        self.parts
    }

    /// Whether the run itself tells its accuracy, and may restart.
    pub fn tells_at_once(&self) -> bool {
        self.start.is_some()
    }

    /// The accuracy up to the present time, for the whole or for each island that moves, or the reason why it is unknown.
    pub fn accuracies(&mut self) -> Vec<Result<Accuracy, UnknownAccuracy>> {
        let told = self.integrators.told(&self.mechanism, &self.state);
        if told.is_empty() { self.unknown.clone() } else { told }
    }

    /// The figures so far.
    pub fn summary(&self) -> Summary {
        let mut summary = match &self.progress {
            None => Course::new(&self.mechanism, &self.state, 0.0, None).summary(),
            Some(Progress::Whole(course)) => course.summary(),
            Some(Progress::Islands(whole)) => whole.summary,
        };
        summary.solve_cpu_seconds += self.spent;
        summary
    }

    /// The state of the joint of each body: on its limit, held by friction, driven by an effort.
    pub fn joint_statuses(&self) -> Vec<JointStatus> {
        match &self.integrators {
            Integrators::Whole(integrator) => (0..self.mechanism.bodies.len())
                .map(|body| integrator.joint_status(&self.mechanism, &self.state, body))
                .collect(),
            Integrators::Islands { islands, .. } => islands.joint_statuses(self.mechanism.bodies.len()),
        }
    }

    /// The closed contacts, in the order of their pairs.
    pub fn contacts(&self) -> Vec<ContactPoint> {
        let mut points = Vec::new();
        match &self.integrators {
            Integrators::Whole(integrator) => integrator.contacts(&self.mechanism, &self.state, &mut points),
            Integrators::Islands { islands, .. } => islands.contacts(&mut points),
        }
        points
    }

    /// The efforts that sampled motors hold from the present state on [N m or N]: an entry a motor, `None` for continuous ones, and before the
    /// first step where they are still to be worked out.
    pub fn held_efforts(&self) -> Vec<Option<f64>> {
        let motors = &self.mechanism.nonsmooth.motors;
        let mut held = Vec::with_capacity(motors.len());
        match &self.integrators {
            Integrators::Whole(integrator) => {
                integrator.held_efforts(false, &mut held);
                held.resize(motors.len(), None);
            }
            Integrators::Islands { islands, .. } => {
                held.resize(motors.len(), None);
                islands.held_efforts(motors, &mut held);
            }
        }
        held.iter().zip(motors).map(|(held, motor)| held.or_else(|| motor.held_at(self.state.time))).collect()
    }

    /// Ends the run and returns its results. Observers are free again.
    pub fn finish(mut self) -> Finished {
        let accuracy = self.accuracies();
        let (summary, method) = (self.summary(), self.description());
        let islands = match &self.integrators {
            Integrators::Whole(_) => Vec::new(),
            Integrators::Islands { islands, .. } => islands.figures().collect(),
        };
        let islands = if islands.len() > 1 { islands } else { Vec::new() };
        let (joints, contacts, held) = (self.joint_statuses(), self.contacts(), self.held_efforts());
        let events = match self.progress {
            None => Vec::new(),
            Some(Progress::Whole(course)) => course.events().to_vec(),
            Some(Progress::Islands(whole)) => whole.events,
        };
        let (end, parts) = (self.end, self.parts);
        Finished { state: self.state, summary, method, islands, events, joints, contacts, held, accuracy, end, parts }
    }
}
