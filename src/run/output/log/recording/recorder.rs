//! The observer that passes samples and events to the log (the table of [`crate::output::log`]).

use crate::lobatto::instants::snapshot::INSTANTS;
use crate::mechanism::motion::contact_point::ContactPoint;
use crate::mechanism::motion::event::Event;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::model::Model;
use crate::output::log::encoding::ending::Ending;
use crate::output::log::encoding::line::encode_line;
use crate::output::log::encoding::names::{SIMULATION, START};
use crate::output::log::encoding::severity::Severity;
use crate::output::log::encoding::time::{nanoseconds, seconds};
use crate::output::log::messages::description::describe;
use crate::output::log::messages::options::{LogOptions, Meshes};
use crate::output::log::messages::sensitivities::Derivatives;
use crate::output::log::recording::accuracy_lines::AccuracyLines;
use crate::output::log::recording::background::BackgroundFile;
use crate::output::log::recording::comparison::{Compared, Comparison, Difference};
use crate::output::log::recording::encoder::SampleEncoder;
use crate::output::log::recording::order::Order;
use crate::output::log::recording::queue::{Between, Piece};
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::{LogFile, MessageSink};
use crate::output::log::storage::inputs::{attach_inputs, inputs};
use crate::simulation::{AccuracySoFar, Observer, ObserverError, Sample, StepEnd};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Writes a run to an MCAP file, or holds it against one.
pub struct Recorder {
    sink: Sink,
    order: Order,
    /// The time of the log at the start of the run, in nanoseconds.
    start: u64,
    /// The lines before the first sample, which come again with it.
    before: Vec<(Severity, String)>,
    begun: bool,
    /// The lines about the accuracy.
    accuracy: AccuracyLines,
    /// The contacts of the next sample, where shapes may touch.
    contacts: Option<Vec<ContactPoint>>,
    /// The efforts that sampled motors hold at the next sample, where they are known.
    held: Vec<Option<f64>>,
    derivatives: Option<Arc<Derivatives>>,
}

/// The destination of samples.
enum Sink {
    File(BackgroundFile),
    Comparison(Box<Compare>),
}

/// A comparison, and what makes the messages for it.
struct Compare {
    log: PathBuf,
    comparison: Comparison,
    encoder: SampleEncoder,
    piece: Piece,
    /// Whether differences count at the end alone, because the run may restart.
    waits: bool,
}

impl Compare {
    fn settle(&mut self) -> Result<(), ObserverError> {
        let encoded = self.encoder.encode(&self.piece, &mut self.comparison);
        self.piece.clear();
        encoded?;
        match self.comparison.settle() {
            Err(Difference::Message { .. } | Difference::Kind { .. }) if self.waits => Ok(()),
            settled => Ok(settled?),
        }
    }
}

impl Recorder {
    /// Creates the log of a run whose output is `path`, and writes everything known before the first sample. `simulation` says how the run is made;
    /// the hash of the main input and the start of the log are added to it. A pipe or device gets samples as they come, for good.
    ///
    /// # Errors
    /// [`LogError`] when the file cannot be created or written.
    pub fn create(
        path: &Path,
        model: &Model,
        simulation: BTreeMap<String, String>,
        options: &LogOptions,
    ) -> Result<Self, LogError> {
        Self::open(path, model, simulation, options, false)
    }

    /// The same for a run that may begin again ([`Observer::begin_again`]). A pipe or device gets its samples when it has ended.
    ///
    /// # Errors
    /// [`LogError`] when the file cannot be created or written.
    pub fn create_for_restarts(
        path: &Path,
        model: &Model,
        simulation: BTreeMap<String, String>,
        options: &LogOptions,
    ) -> Result<Self, LogError> {
        Self::open(path, model, simulation, options, true)
    }

    fn open(
        path: &Path,
        model: &Model,
        mut simulation: BTreeMap<String, String>,
        options: &LogOptions,
        may_begin_again: bool,
    ) -> Result<Self, LogError> {
        let mut file = LogFile::create(path, options.compress)?;
        let inputs = inputs(model);
        simulation.extend(inputs.first().map(|main| ("input_sha256".to_string(), main.hash.clone())));
        let stages = simulation.get("stages").and_then(|stages| stages.parse().ok()).unwrap_or(f64::NAN);
        simulation.insert(START.to_string(), options.start.to_string());
        file.metadata(SIMULATION, simulation)?;
        attach_inputs(&mut file, &inputs)?;
        let beside = file.is_regular().then_some(path);
        let encoder = prepare(&mut file, model, options, beside)?;
        // The constant part is safe in the file before the run begins.
        file.begin(may_begin_again)?;
        let file = BackgroundFile::new(path, file, encoder)?;
        let (sink, order) = (Sink::File(file), Order::new(stages, options.derivatives.clone()));
        Ok(Recorder::new(sink, order, model, options))
    }

    fn new(sink: Sink, order: Order, model: &Model, options: &LogOptions) -> Self {
        let (before, accuracy) = (Vec::new(), AccuracyLines::default());
        let (start, derivatives) = (options.start, options.derivatives.clone());
        Recorder {
            sink,
            order,
            start,
            before,
            begun: false,
            accuracy,
            contacts: may_touch(model),
            held: Vec::new(),
            derivatives,
        }
    }

    /// Once `interrupted` says that the run is interrupted, it waits no longer for an output that is no file and is not read.
    pub fn heed(&mut self, interrupted: &Arc<AtomicBool>) {
        if let Sink::File(file) = &mut self.sink {
            file.heed(interrupted.clone());
        }
    }

    /// Holds a run against the log at `path`, which a run of the same model made in the same way has written: the first
    /// message that differs is the error of [`Observer::sample`], a [`Difference`], a few samples later.
    ///
    /// # Errors
    /// [`LogError::Write`] if there can be no thread that reads the log.
    pub fn compare(path: &Path, model: &Model, stages: f64, options: &LogOptions) -> Result<Self, LogError> {
        let mut comparison = Comparison::new(path, options.start)?;
        // Geometry is not compared.
        let options = LogOptions { meshes: Meshes::None, ..options.clone() };
        let encoder = prepare(&mut comparison, model, &options, None)?;
        let compare = Compare { log: path.to_path_buf(), comparison, encoder, piece: Piece::default(), waits: false };
        let (sink, order) = (Sink::Comparison(Box::new(compare)), Order::new(stages, None));
        Ok(Recorder::new(sink, order, model, &options))
    }

    /// The run that is compared may restart: where it differs counts at its end alone, but that the log has ended.
    pub fn wait_for_the_end(&mut self) {
        if let Sink::Comparison(compare) = &mut self.sink {
            compare.waits = true;
        }
    }

    /// Lets `add` add items to the log; returns whether the sink has a message.
    fn add(sink: &mut Sink, add: impl FnOnce(&mut Piece)) -> bool {
        match sink {
            Sink::File(file) => file.add(add),
            Sink::Comparison(compare) => {
                add(&mut compare.piece);
                compare.piece.times.len() >= INSTANTS
            }
        }
    }

    /// Adds a line of text at the time of the last message.
    pub fn say(&mut self, severity: Severity, text: &str) {
        if !self.begun {
            self.before.push((severity, text.to_string()));
        }
        self.write(severity, text);
    }

    fn write(&mut self, severity: Severity, text: &str) {
        let time = self.order.last_time();
        let line = encode_line(self.start + time, severity, text);
        Self::add(&mut self.sink, |piece| piece.push_between(Between::Line(time, line)));
    }

    /// The place of the log while it is written, if it is beside its output, which must stay until the run has finished.
    pub fn beside(&self) -> Option<&Path> {
        match &self.sink {
            Sink::File(file) => file.is_beside().then(|| file.current()),
            Sink::Comparison(_) => None,
        }
    }

    /// Writes everything that is still in memory and how the run ended, and completes the file.
    ///
    /// # Errors
    /// [`LogError::Write`], also for what earlier messages could not be written for.
    pub fn finish(mut self, ending: Ending) -> Result<(), LogError> {
        Self::add(&mut self.sink, |piece| self.order.add_until(f64::INFINITY, piece));
        match self.sink {
            Sink::File(file) => file.finish(ending).map(drop),
            Sink::Comparison(_) => Ok(()),
        }
    }

    /// Ends a comparison: how much was compared, and the first difference, if any.
    pub fn compared(mut self) -> (Compared, Result<(), Difference>) {
        Self::add(&mut self.sink, |piece| self.order.add_until(f64::INFINITY, piece));
        match self.sink {
            Sink::File(_) => (Compared::default(), Ok(())),
            Sink::Comparison(mut compare) => {
                // Differences are reported at the end.
                let _ = compare.settle();
                compare.comparison.finish()
            }
        }
    }
}

impl Observer for Recorder {
    fn begin_again(&mut self, method: &MethodDescription) -> Result<(), ObserverError> {
        let after = seconds(self.order.last_time());
        (self.order, self.accuracy) =
            (Order::new(method.stages as f64, self.derivatives.clone()), AccuracyLines::default());
        self.contacts.iter_mut().for_each(Vec::clear);
        match &mut self.sink {
            Sink::File(file) => file.begin_again(),
            Sink::Comparison(compare) => {
                compare.piece.clear();
                compare.comparison.begin_again(&compare.log)?;
            }
        }
        let before = std::mem::take(&mut self.before);
        before.iter().for_each(|(severity, text)| self.write(*severity, text));
        self.before = before;
        self.write(
            Severity::Info,
            &format!("restarted after t = {after} s with finer steps: errors grew more than expected"),
        );
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.begun = true;
        let contacts = self.contacts.as_mut().map(std::mem::take);
        let add = |piece: &mut Piece| {
            self.order.add(sample, piece);
            piece.held.append(&mut self.held);
            if let Some(contacts) = contacts {
                piece.push_between(Between::Contacts(nanoseconds(sample.time), contacts));
            }
        };
        if Self::add(&mut self.sink, add) {
            match &mut self.sink {
                Sink::File(file) => file.settle()?,
                Sink::Comparison(compare) => compare.settle()?,
            }
        }
        Ok(())
    }

    fn step(&mut self, end: &StepEnd) {
        self.order.step(end);
    }

    fn event(&mut self, event: &Event) {
        self.order.event(event);
    }

    fn accuracy(&mut self, so_far: &AccuracySoFar) {
        if let Some(line) = self.accuracy.line(so_far) {
            self.write(Severity::Info, &line);
        }
    }

    fn contacts(&mut self, points: &[ContactPoint]) {
        self.contacts = self.contacts.take().map(|_| points.to_vec());
    }

    fn held_efforts(&mut self, efforts: &[Option<f64>]) {
        self.held.clear();
        self.held.extend_from_slice(efforts);
    }
}

/// Room for the contacts of samples, if shapes may touch.
fn may_touch(model: &Model) -> Option<Vec<ContactPoint>> {
    (!model.mechanism.nonsmooth.pairs.is_empty()).then(Vec::new)
}

/// Adds all channels, and the messages that are known before the first sample; files go beside the log, if it is one.
fn prepare(
    sink: &mut dyn MessageSink,
    model: &Model,
    options: &LogOptions,
    beside: Option<&Path>,
) -> Result<SampleEncoder, LogError> {
    let left_out = describe(sink, model, options, beside)?;
    let encoder = SampleEncoder::new(sink, model, options)?;
    for warning in model.warning_lines().chain(left_out) {
        encoder.line(sink, 0, &encode_line(options.start, Severity::Warning, &warning))?;
    }
    Ok(encoder)
}
