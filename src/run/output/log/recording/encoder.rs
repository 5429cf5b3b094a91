//! Makes messages of samples (the table of [`crate::output::log`]).
//!
//! Everything that does not change is prepared once: names, message layouts, buffers. Samples are looked at several at once
//! ([`crate::instant::exerting::snapshots`]). The content of a message does not depend on the samples that its own was looked at with.

use crate::instant::exerting::snapshots::View;
use crate::lobatto::instants::snapshot::{INSTANTS, Instants, LinkPlace, Snapshots};
use crate::model::Model;
use crate::output::log::encoding::definitions::{LOG, TRANSFORMS};
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::line;
use crate::output::log::encoding::time::nanoseconds;
use crate::output::log::messages::contact_forces::ContactForces;
use crate::output::log::messages::contacts::ContactMessages;
use crate::output::log::messages::events::EventMessages;
use crate::output::log::messages::figures::FigureMessages;
use crate::output::log::messages::joints::JointMessages;
use crate::output::log::messages::motors::MotorMessages;
use crate::output::log::messages::options::LogOptions;
use crate::output::log::messages::ropes::RopeMessages;
use crate::output::log::messages::sensitivities::SensitivityMessages;
use crate::output::log::messages::transforms::{TransformsEncoder, drawn_links, world_frame};
use crate::output::log::recording::queue::{Between, Piece};
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;

/// Makes messages of the samples of one run.
pub(crate) struct SampleEncoder {
    /// The time of the log at the start of the run, in nanoseconds.
    start: u64,
    lines: u16,
    /// Number of the links among the places that are looked at: the first.
    links: usize,
    /// `None` if it is not wanted.
    transforms: Option<(u16, TransformsEncoder)>,
    figures: FigureMessages,
    joints: JointMessages,
    motors: Option<MotorMessages>,
    events: Option<EventMessages>,
    contacts: Option<ContactMessages>,
    contact_forces: Option<ContactForces>,
    ropes: Option<RopeMessages>,
    sensitivities: Option<SensitivityMessages>,
    instants: View,
    snapshots: Snapshots,
    position_count: usize,
    velocity_count: usize,
}

impl SampleEncoder {
    /// Adds the channels of a run of this model.
    pub(crate) fn new(sink: &mut dyn MessageSink, model: &Model, options: &LogOptions) -> Result<Self, LogError> {
        let (mechanism, links) = (&model.mechanism, drawn_links(&model.links));
        let world = world_frame(&model.links);
        let mut places: Vec<LinkPlace> = links.iter().map(|link| (link.body, link.in_body)).collect();
        let wanted = &options.topics;
        let lines = sink.channel(line::TOPIC, &LOG, Durability::Volatile)?;
        let transforms = match wanted.has("/tf") {
            true => {
                let encoder = TransformsEncoder::new(world, links.iter().map(|link| link.name.as_str()));
                Some((sink.channel("/tf", &TRANSFORMS, Durability::Volatile)?, encoder))
            }
            false => None,
        };
        let ropes = RopeMessages::new(sink, model, world, wanted, &mut places)?;
        Ok(SampleEncoder {
            start: options.start,
            lines,
            links: links.len(),
            transforms,
            figures: FigureMessages::new(sink, wanted)?,
            joints: JointMessages::new(sink, model, world, wanted)?,
            motors: MotorMessages::new(sink, model, wanted)?,
            events: EventMessages::new(sink, model, wanted)?,
            contacts: ContactMessages::new(sink, model, world, wanted)?,
            contact_forces: ContactForces::new(sink, model, world, wanted)?,
            ropes,
            sensitivities: SensitivityMessages::new(sink, options.derivatives.as_ref(), wanted)?,
            instants: View::new(mechanism, &places),
            snapshots: Snapshots::new(mechanism, places.len()),
            position_count: mechanism.position_count,
            velocity_count: mechanism.velocity_count,
        })
    }

    /// Adds an encoded line of text, at this number of nanoseconds of the run.
    pub(crate) fn line(&self, sink: &mut dyn MessageSink, nanoseconds: u64, line: &[u8]) -> Result<(), LogError> {
        sink.message(self.lines, self.start + nanoseconds, line).map(drop)
    }

    /// Adds the messages of everything in a piece. Does not allocate.
    pub(crate) fn encode(&mut self, piece: &Piece, sink: &mut dyn MessageSink) -> Result<(), LogError> {
        let mut between = piece.between.iter().peekable();
        let mut contacts = piece.contacts().peekable();
        for (group, times) in piece.times.chunks(INSTANTS).enumerate() {
            let first = group * INSTANTS;
            let positions = &piece.positions[first * self.position_count..][..times.len() * self.position_count];
            let velocities = &piece.velocities[first * self.velocity_count..][..times.len() * self.velocity_count];
            if let Some(motors) = &mut self.motors {
                motors.work_out(times, positions, velocities, piece.held_at(first));
                self.instants.drive(motors.efforts());
            }
            self.instants.clock(times);
            self.instants.touch(
                (first..first + times.len())
                    .map(|sample| contacts.next_if(|(own, _)| *own == sample).map(|(_, points)| points)),
            );
            self.instants.look(positions, velocities, times.len(), &mut self.snapshots);
            for (instant, &time) in times.iter().enumerate() {
                while let Some((_, what)) = between.next_if(|(before, _)| *before <= first + instant) {
                    self.encode_between(what, sink)?;
                }
                let stamp = self.start + nanoseconds(time);
                if let Some((channel, encoder)) = &self.transforms {
                    let poses = self.snapshots.poses[..self.links].iter().map(|[x, y, z, qw, qx, qy, qz]| {
                        ([x[instant], y[instant], z[instant]], [qw[instant], qx[instant], qy[instant], qz[instant]])
                    });
                    encoder.fill(sink.message(*channel, stamp, encoder.encoded())?, stamp, poses);
                }
                let position = &positions[instant * self.position_count..][..self.position_count];
                let velocity = &velocities[instant * self.velocity_count..][..self.velocity_count];
                self.joints.write((position, velocity), (&self.snapshots, instant), stamp, sink)?;
                if let Some(motors) = &self.motors {
                    motors.write(instant, stamp, sink)?;
                }
                if let Some(ropes) = &mut self.ropes {
                    ropes.write((&self.snapshots, instant), stamp, sink)?;
                }
            }
        }
        between.try_for_each(|(_, what)| self.encode_between(what, sink))
    }

    fn encode_between(&mut self, what: &Between, sink: &mut dyn MessageSink) -> Result<(), LogError> {
        match what {
            Between::Line(time, line) => self.line(sink, *time, line),
            Between::Event(time, event) => match &mut self.events {
                Some(events) => events.write(self.start + time, event, sink),
                None => Ok(()),
            },
            Between::Contacts(time, points) => {
                let stamp = self.start + time;
                if let Some(contacts) = &mut self.contacts {
                    contacts.write(stamp, points, sink)?;
                }
                self.contact_forces.as_mut().map_or(Ok(()), |forces| forces.write(stamp, points, sink))
            }
            Between::Derivatives(time, row) => match &self.sensitivities {
                Some(sensitivities) => sensitivities.write(*row, self.start + time, sink),
                None => Ok(()),
            },
            Between::Figures(time, figures) => self.figures.write(figures, self.start + time, sink),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::closure::Coordinate;
    use crate::mechanism::description::nonsmooth::{Motor, MotorLaw};
    use crate::mechanism::description::target::Target;
    use crate::mechanism::motion::event::{Event, EventKind};
    use crate::mechanism::motion::state::State;
    use crate::model::{Base, ModelOptions};
    use crate::output::log::encoding::definitions::Definition;
    use crate::output::log::messages::figures::Figures;
    use crate::output::log::storage::batch::Batch;
    use crate::scene::{PackagePath, read_scene, read_urdf};
    use allocation_counter::measure;
    use std::path::{Path, PathBuf};

    /// Messages in memory.
    #[derive(Default)]
    struct Memory {
        channels: u16,
        messages: Batch,
    }

    impl MessageSink for Memory {
        fn channel(&mut self, _: &str, _: &Definition, _: Durability) -> Result<u16, LogError> {
            self.channels += 1;
            Ok(self.channels)
        }

        fn message(&mut self, channel: u16, nanoseconds: u64, template: &[u8]) -> Result<&mut [u8], LogError> {
            Ok(self.messages.push(channel, nanoseconds, template))
        }
    }

    /// Samples of every joint moving at a pace of its own, loops torn, with the figures of a step and a line before each. They are made without a
    /// simulation, so that the unit tests are built without the kernels of all vectors.
    fn samples(model: &Model, mut state: State) -> Piece {
        const INTERVAL: f64 = 0.01;
        let mechanism = &model.mechanism;
        let pace = |freedom: usize| 0.3 + 0.1 * freedom as f64;
        let displacement: Vec<f64> = (0..mechanism.velocity_count).map(|freedom| INTERVAL * pace(freedom)).collect();
        state.velocity = (0..mechanism.velocity_count).map(pace).collect();
        let mut piece = Piece::default();
        // More than a second, since stamps are longer from then on.
        for sample in 0..=110 {
            let time = INTERVAL * f64::from(sample);
            let stamp = nanoseconds(time);
            let figures = Figures { energies: [1.0; 7], violation: [2.0; 2], work: [3.0; 5] };
            piece.push_between(Between::Figures(stamp, figures));
            piece.push_between(Between::Line(stamp, vec![1, 2, 3]));
            piece.push_event(
                stamp,
                Event { time, kind: EventKind::LimitImpact, body: 0, pair: None, impulse: Some(1.0) },
            );
            piece.push(time, &state.position, &state.velocity);
            state.displace(mechanism, &displacement);
        }
        piece
    }

    fn robots(file: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(file)
    }

    fn urdf(file: &str, base: Base) -> (Model, State) {
        let robot = read_urdf(&robots(file), &PackagePath::default()).expect("a robot");
        let model = Model::new(robot, &ModelOptions { base, ..ModelOptions::default() }).expect("a model");
        let state = model.zero_state();
        (model, state)
    }

    #[test]
    fn encoding_samples_allocates_nothing_whatever_the_joints_and_loops() {
        let scene = read_scene(&robots("slider_crank.toml"), &PackagePath::default()).expect("a scene");
        let (closed, start) = Model::from_scene(&scene).expect("a model");
        let at_start = closed.initial_state(&start.positions, &start.velocities, None).expect("a state");
        let mut driven = urdf("arm7.urdf", Base::Fixed);
        driven.0.mechanism.nonsmooth.motors = vec![Motor {
            coordinate: Coordinate { body: 0, position: 0, freedom: 0 },
            law: MotorLaw::Velocity { kd: 1.0 },
            target: Target::constant(1.0),
            max_effort: 1.0,
            period: 0.015,
            held: None,
        }];
        let all = [
            driven,
            urdf("arm7.urdf", Base::Fixed),
            urdf("humanoid.urdf", Base::Floating),
            urdf("planar_slider.urdf", Base::Fixed),
            (closed, at_start),
        ];
        for (model, state) in all {
            let mechanism = &model.mechanism;
            let mut sink = Memory::default();
            let mut encoder = SampleEncoder::new(&mut sink, &model, &LogOptions::default()).expect("memory");
            let samples = samples(&model, state);
            let mut encode = || {
                sink.messages.clear();
                encoder.encode(&samples, &mut sink).expect("memory");
                sink.messages.count()
            };
            // The first time lets the buffers grow to their size.
            let count = encode();
            assert!(count >= 111 * 6, "{}: {count} messages", mechanism.name);
            // Counts on this thread alone.
            let allocations = measure(|| assert_eq!(encode(), count));
            assert_eq!(allocations.count_total, 0, "{}: {allocations:?}", mechanism.name);
        }
    }
}
