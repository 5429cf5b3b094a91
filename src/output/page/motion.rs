//! The motion of a log as columns of numbers: times, poses of bodies, curves, contacts, events.
//!
//! Figures of steps have times of their own (`step_figures.rs`).
//!
//! The poses of bodies follow from the poses of links, `T_body = T_link L⁻¹` with the link frame L in its body. If a log has more than
//! [`MOST_SAMPLES`] samples, every second, third, … one is taken, and the last.

use crate::mechanism::description::joint::{Pose, rotation_from_wxyz};
use crate::model::Model;
use crate::output::inspection::joint_values::{JointKinds, JointValue, Quantity, joint_kinds, joint_values};
use crate::output::log::reading::decode::{LinkPose, LoggedEvent};
use crate::output::log::reading::frames::{Figures, Frame, Slopes, Visitor};
use crate::output::page::contacts::Contacts;
use crate::output::page::curve_name::CurveName;
use crate::output::page::spreads::Spreads;
use crate::output::page::step_figures::StepFigures;
use crate::output::page::tree::pose_numbers;
use crate::output::report::EventEntry;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::collections::HashMap;
use std::ops::ControlFlow;

/// The most samples in a page: two minutes at the usual rate.
pub(super) const MOST_SAMPLES: u64 = 7200;

/// The most events in a page.
const MOST_EVENTS: usize = 20_000;

/// Collects the motion of a log.
pub(in crate::output) struct Motion<'m> {
    kinds: JointKinds,
    /// Every so-manieth sample is taken.
    stride: u64,
    seen: u64,
    /// The last sample, if it was not taken.
    last: Option<Frame>,
    /// For each body a link in it: its name and the inverse of its frame in the body.
    carriers: Vec<(&'m str, Pose)>,
    /// Times (s).
    pub times: Vec<f64>,
    /// Poses of the bodies at all times: x, y, z, w, x, y, z of each.
    pub poses: Vec<Vec<[f32; 7]>>,
    /// The names of the curves, and their values at all times.
    pub(super) curves: Vec<CurveName>,
    pub values: Vec<Vec<f32>>,
    /// Standard deviations of positions.
    spreads: Spreads,
    /// The figures of steps.
    pub(super) steps: StepFigures,
    /// The closed contacts at all times.
    pub(super) contacts: Contacts,
    /// Events, the first [`MOST_EVENTS`].
    pub events: Vec<EventEntry>,
    /// The sample that is not of this model, or not of the same joints as those before it (s).
    pub misfit: Option<f64>,
    /// Whether that sample has neither links nor joints, or not both: their topics were not asked for.
    pub is_bare: bool,
}

impl<'m> Motion<'m> {
    /// An empty motion for a log of this model with this number of samples.
    pub(super) fn new(model: &'m Model, samples: u64) -> Self {
        let bodies = 0..model.mechanism.bodies.len();
        let carrier = |body| {
            let link = model.links.iter().find(|link| link.body == Some(body));
            link.map_or(("", Pose::identity()), |link| (link.name.as_str(), link.in_body.inverse()))
        };
        Motion {
            kinds: joint_kinds(model),
            stride: samples.div_ceil(MOST_SAMPLES).max(1),
            seen: 0,
            last: None,
            carriers: bodies.clone().map(carrier).collect(),
            times: Vec::new(),
            poses: bodies.map(|_| Vec::new()).collect(),
            curves: Vec::new(),
            values: Vec::new(),
            spreads: Spreads::default(),
            steps: StepFigures::default(),
            contacts: Contacts::default(),
            events: Vec::new(),
            misfit: None,
            is_bare: false,
        }
    }

    /// Every so-manieth sample of the log is in the motion.
    pub(super) fn stride(&self) -> u64 {
        self.stride
    }

    /// Takes the last sample, if it was passed over, and leaves out figures of steps that are too many.
    pub(super) fn finish(&mut self) {
        if let Some(frame) = self.last.take() {
            self.take(&frame);
        }
        self.steps.thin();
        for curve in &mut self.curves {
            if let Some(column) = self.spreads.at(&curve.name, &self.times) {
                curve.spread = Some(self.values.len());
                self.values.push(column);
            }
        }
    }

    fn take(&mut self, frame: &Frame) {
        if self.try_take(frame).is_none() {
            self.misfit = Some(frame.time());
            self.is_bare = frame.links.is_empty() || !frame.has_joints();
        }
    }

    /// `None` if the sample does not fit to the model or to those before it.
    fn try_take(&mut self, frame: &Frame) -> Option<()> {
        let links: HashMap<&str, &LinkPose> = frame.links.iter().map(|link| (link.link.as_str(), link)).collect();
        let place = |&(name, inverse): &(&str, Pose)| Some(single(&pose_numbers(&(pose(links.get(name)?) * inverse))));
        let poses: Vec<[f32; 7]> = self.carriers.iter().map(place).collect::<Option<_>>()?;
        let values = joint_values(frame, &self.kinds);
        if self.times.is_empty() {
            self.curves = values.iter().map(of_joint).collect();
            self.values = vec![Vec::new(); self.curves.len()];
        }
        let is_same = values.len() == self.curves.len()
            && values.iter().zip(&self.curves).all(|(value, curve)| value.name == curve.name);
        if !is_same {
            return None;
        }
        self.times.push(frame.time());
        self.contacts.take(&frame.contacts);
        for (poses, pose) in self.poses.iter_mut().zip(poses) {
            // The same turn has two quaternions. The one near the quaternion before it is taken, so that interpolation between them stays near, too.
            let flips =
                poses.last().is_some_and(|last: &[f32; 7]| (3..7).map(|k| last[k] * pose[k]).sum::<f32>() < 0.0);
            poses.push(if flips {
                [0, 1, 2, 3, 4, 5, 6].map(|k| if k < 3 { pose[k] } else { -pose[k] })
            } else {
                pose
            });
        }
        for (values, value) in self.values.iter_mut().zip(&values) {
            values.push(value.value as f32);
        }
        Some(())
    }
}

impl Visitor for Motion<'_> {
    fn frame(&mut self, frame: &Frame) -> ControlFlow<()> {
        if self.seen.is_multiple_of(self.stride) {
            self.take(frame);
            self.last = None;
        } else {
            self.last = Some(frame.clone());
        }
        self.seen += 1;
        if self.misfit.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn figures(&mut self, figures: &Figures) {
        self.steps.take(figures);
    }

    fn slopes(&mut self, slopes: &Slopes) {
        self.spreads.take(slopes);
    }

    fn event(&mut self, event: LoggedEvent) {
        let LoggedEvent { time, kind, what, impulse } = event;
        if self.events.len() < MOST_EVENTS {
            self.events.push(EventEntry { time, kind, what, impulse });
        }
    }
}

fn of_joint(value: &JointValue) -> CurveName {
    let quantity = value.quantity;
    // The effort along the axis is a part of the reaction, and not of its components in the world.
    let group = if value.name.ends_with(".effort") { Quantity::Effort.title() } else { quantity.title() };
    let (name, unit, logarithmic) = (value.name.clone(), quantity.unit(), quantity.is_logarithmic());
    CurveName { name, group, unit, logarithmic, spread: None }
}

fn pose(link: &LinkPose) -> Pose {
    let rotation = Rotation3::from_matrix_unchecked(rotation_from_wxyz(&link.orientation));
    Pose::from_parts(Translation3::from(Vector3::from(link.position)), rotation)
}

fn single(pose: &[f64; 7]) -> [f32; 7] {
    pose.map(|number| number as f32)
}
