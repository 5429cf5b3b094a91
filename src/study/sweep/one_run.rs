//! One run of a sweep: the scene with the numbers of an index, its run, its row.
//!
//! This is the one place where a sweep makes a simulation: scene → model → start on loops and limits → simulation, as `catena simulate` does it.

use crate::instant::start::assembly::{AssemblyError, assemble_counted};
use crate::mechanism::motion::event::EventKind;
use crate::mechanism::motion::kinematics::body_states;
use crate::model::{Model, ModelError};
use crate::output::report::{AccuracyReport, EventReport};
use crate::scene::{Parameter, Scene, SceneError};
use crate::session::mechanism_from;
use crate::simulation::{RunError, Simulation, SimulationError, SimulationOptions};
use crate::sweep::definition::{Sweep, course};
use crate::sweep::error::SweepError;
use crate::sweep::quantities::Instant;
use crate::sweep::rows::{Cell, Heading, Kind, Row};
use crate::sweep::schema::EventsKey;
use crate::sweep::watch::Watch;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;

/// Columns before those that vary and after them.
const INDEX: &str = "index";
const FIGURES: [(&str, Kind); 9] = [
    ("status", Kind::Text),
    ("reason", Kind::Text),
    ("time", Kind::Number),
    ("steps", Kind::Count),
    ("iterations", Kind::Count),
    ("energy_error", Kind::Number),
    ("constraint_error", Kind::Number),
    ("estimated_error", Kind::Number),
    ("accurate_until", Kind::Number),
];

/// Makes runs, one after the other, on one thread.
pub(super) struct Runner<'s> {
    sweep: &'s Sweep,
    /// The scene of the run before: every run sets the same numbers anew.
    scene: Scene,
    /// The model, if it is the same for all runs: they differ in their starts alone.
    model: Option<Model>,
    /// The varied parameters, with the numbers of the run before.
    varied: Vec<(Parameter, f64)>,
    numbers: Vec<f64>,
    /// Columns of the table.
    columns: usize,
}

/// Why a run has no end.
#[derive(Debug, thiserror::Error)]
enum Failed {
    #[error(transparent)]
    Number(#[from] SceneError),
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    #[error(transparent)]
    Begin(#[from] SimulationError),
    #[error("{error}")]
    Run { error: RunError, time: f64 },
    #[error("the program failed: {0}")]
    Panic(String),
    #[error("interrupted")]
    Interrupted,
}

/// The columns of a sweep.
pub(super) fn headings(sweep: &Sweep) -> Vec<Heading> {
    let varied = sweep.variation.columns.iter().map(|column| Heading::new(column.parameter.key(), Kind::Number));
    let figures = FIGURES.iter().map(|&(name, kind)| Heading::new(name, kind));
    std::iter::once(Heading::new(INDEX, Kind::Count))
        .chain(varied)
        .chain(figures)
        .chain(sweep.kept.headings())
        .collect()
}

impl<'s> Runner<'s> {
    /// Makes a runner for a sweep.
    ///
    /// # Errors
    /// [`SweepError::Model`] of the scene with the numbers of its files.
    pub fn new(sweep: &'s Sweep) -> Result<Self, SweepError> {
        let mut scene = sweep.scene.clone();
        for robot in &mut scene.robots {
            // Runs of a sweep have no log: only viewers need these parts of the models.
            robot.robot.description.clear();
            robot.robot.source.clear();
            robot.robot.warnings.clear();
            robot.robot.links.iter_mut().for_each(|link| link.visuals.clear());
        }
        let varied: Vec<(Parameter, f64)> =
            sweep.variation.columns.iter().map(|column| (column.parameter.clone(), f64::NAN)).collect();
        // Some loops hold values that are taken from the start of the scene.
        let loops = scene.loops.len() + scene.robots.iter().map(|robot| robot.robot.loops.len()).sum::<usize>();
        let starts_alone = loops == 0 && varied.iter().all(|(parameter, _)| parameter.is_start());
        let model = if starts_alone { Some(Model::from_scene(&scene)?.0) } else { None };
        Ok(Runner { sweep, scene, model, varied, numbers: Vec::new(), columns: headings(sweep).len() })
    }

    /// The row of an index; `None` if the run was interrupted.
    pub fn row(&mut self, index: u64, interrupt: &AtomicBool) -> Option<Row> {
        self.sweep.variation.numbers(index, &mut self.numbers);
        let mut cells = Vec::with_capacity(self.columns);
        cells.push(Cell::Count(index));
        cells.extend(self.numbers.iter().map(|&number| Cell::Number(number)));
        let before = cells.len();
        // One run that finds a defect of the program does not end a million others.
        let made = catch_unwind(AssertUnwindSafe(|| self.run(interrupt, &mut cells)));
        let ended = made.unwrap_or_else(|panic| {
            let said = panic.downcast_ref::<String>().cloned();
            Err(Failed::Panic(
                said.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string)).unwrap_or_default(),
            ))
        });
        match ended {
            Ok(()) => Some(Row { index, failed: false, cells }),
            Err(Failed::Interrupted) => None,
            Err(failed) => {
                cells.truncate(before);
                let time = if let Failed::Run { time, .. } = failed { Cell::Number(time) } else { Cell::Nothing };
                // One line, whatever the names of a scene hold.
                let reason = failed.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
                cells.extend([Cell::Text("failed".to_string()), Cell::Text(reason), time]);
                cells.resize(self.columns, Cell::Nothing);
                Some(Row { index, failed: true, cells })
            }
        }
    }

    /// Makes the run of the numbers at hand, and adds the cells of its results.
    fn run(&mut self, interrupt: &AtomicBool, cells: &mut Vec<Cell>) -> Result<(), Failed> {
        for ((_, varied), number) in self.varied.iter_mut().zip(&self.numbers) {
            *varied = *number;
        }
        self.scene.robots.iter_mut().for_each(|robot| robot.robot.warnings.clear());
        self.scene.set(&self.varied)?;
        let fresh;
        let (model, start) = match &self.model {
            Some(model) => (model, model.start(&self.scene)?),
            None => {
                let (model, start) = Model::from_scene(&self.scene)?;
                fresh = model;
                (&fresh, start)
            }
        };
        let mut state = model.initial_state(&start.positions, &start.velocities, None)?;
        model.check_representable(&state)?;
        let (_, counted) = assemble_counted(&model.mechanism, &mut state)?;
        model.check_springs(&state)?;

        let (duration, steps) = course(&self.scene.simulation);
        let interrupt = Some(interrupt);
        let options =
            SimulationOptions { interrupt, counted: counted.as_ref(), ..SimulationOptions::new(duration, steps) };
        let mut watch = Watch::new(model, &self.sweep.kept);
        let mechanism = mechanism_from(model, &state);
        let mut simulation = Simulation::new(&mechanism, state, options)?;
        if let Some(rate) = self.sweep.kept.rate() {
            simulation.sample_at(rate);
            simulation.observe(&mut watch);
        }
        match simulation.run() {
            Err(RunError::Interrupted { .. }) => return Err(Failed::Interrupted),
            Err(error) => return Err(Failed::Run { error, time: simulation.state().time }),
            Ok(()) => {}
        }
        let finished = simulation.finish();
        let accuracy = AccuracyReport::of(steps, &finished).ok();
        let (state, summary) = (&finished.state, &finished.summary);
        let known = |number: Option<f64>| number.map_or(Cell::Nothing, Cell::Number);
        cells.extend([
            Cell::Text("done".to_string()),
            Cell::Nothing,
            Cell::Number(state.time),
            Cell::Count(summary.steps as u64),
            Cell::Count(summary.cost.iterations as u64),
            Cell::Number(summary.max_relative_energy_error),
            Cell::Number(summary.max_violation.position),
            known(accuracy.as_ref().map(|accuracy| accuracy.estimated)),
            known(accuracy.as_ref().map(|accuracy| accuracy.holds_until)),
        ]);
        let kept = &self.sweep.kept;
        let bodies = body_states(&model.mechanism, state);
        let instant = Instant { model, position: &state.position, velocity: &state.velocity, bodies: &bodies };
        cells.extend(kept.end.iter().map(|quantity| known(instant.value(quantity))));
        watch.extremes(cells);
        if kept.events != EventsKey::None {
            cells.extend(EventKind::ALL.iter().map(|&kind| Cell::Count(summary.events.of(kind) as u64)));
        }
        if kept.events == EventsKey::List {
            let list = EventReport::new(model, &finished).list;
            cells.push(Cell::Numbers(list.iter().map(|event| event.time).collect()));
            cells.push(Cell::Texts(list.iter().map(|event| event.kind.clone()).collect()));
            cells.push(Cell::Texts(list.iter().map(|event| event.what.clone()).collect()));
            cells.push(Cell::Numbers(list.iter().map(|event| event.impulse.unwrap_or(f64::NAN)).collect()));
        }
        watch.curves(cells);
        Ok(())
    }
}
