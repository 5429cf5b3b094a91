//! The derivatives of the figures of a mechanism by one parameter: of inertial numbers, of the frames of joints, and of laws.
//!
//! ```text
//!     frame: axes E, origin o        motion: turn ½ Σ_c e_c × δe_c  (rad per unit),  shift δo  (m per unit)
//! ```

use crate::derivatives::equations::figures::{BodyFigures, Figures, Frame};
use crate::derivatives::equations::laws::Laws;
use crate::derivatives::forward::spatial::Twist;
use crate::derivatives::numbers::vector::Vector;

/// The derivatives of all figures by a parameter, in their places.
pub(in crate::derivatives) struct FigureSlopes {
    pub plain: Figures<f64>,
    pub laws: Laws<f64>,
    /// The derivatives of inertial numbers, and the motions of the frames of joints on the parent and on the child, if they are not zero.
    bodies: Vec<Option<BodyFigures<f64>>>,
    frames: Option<Vec<[Twist; 2]>>,
    changes_laws: bool,
}

impl FigureSlopes {
    /// The derivatives of figures, from all figures and their changes.
    pub fn new(of: &Figures<f64>, plain: Figures<f64>, laws: Laws<f64>) -> Self {
        let is_zero = |vector: &Vector<f64>| vector.0.iter().all(|entry| *entry == 0.0);
        let bodies = plain.bodies.iter().map(|body| {
            let rests = body.mass == 0.0 && is_zero(&body.moment) && body.second_moments.0.iter().all(is_zero);
            (!rests).then(|| body.clone())
        });
        let frames: Vec<[Twist; 2]> = of
            .bodies
            .iter()
            .zip(&plain.bodies)
            .map(|(body, slope)| {
                [frame_motion(&body.on_parent, &slope.on_parent), frame_motion(&body.on_child, &slope.on_child)]
            })
            .collect();
        let rest = |twist: &Twist| is_zero(&twist.turn) && is_zero(&twist.shift);
        let bodies = bodies.collect();
        let frames = (!frames.iter().flatten().all(rest)).then_some(frames);
        let springs = plain.springs.iter().flat_map(|spring| [spring.stiffness, spring.rest]);
        let joints = plain.dampers.iter().chain(&plain.loads).chain(&plain.rotors).map(|(_, slope)| *slope);
        let motors = laws.motors.iter().flat_map(|motor| [motor.kp, motor.kd]);
        let changes_laws = springs.chain(joints).chain(motors).any(|slope| slope != 0.0);
        FigureSlopes { plain, laws, bodies, frames, changes_laws }
    }

    /// The derivatives of inertial numbers, for each body that has any.
    pub(super) fn inertial(&self) -> &[Option<BodyFigures<f64>>] {
        &self.bodies
    }

    /// The motions of the frames of all joints, if any move.
    pub(super) fn frames(&self) -> Option<&[[Twist; 2]]> {
        self.frames.as_deref()
    }

    /// Whether springs, dampers, motors, loads or rotors change.
    pub fn changes_laws(&self) -> bool {
        self.changes_laws
    }
}

/// The motion of a frame in the frame that it is fixed in, about its own origin.
fn frame_motion(frame: &Frame<f64>, slope: &Frame<f64>) -> Twist {
    let axes = frame.axes.0.iter().zip(&slope.axes.0);
    let turn = axes.fold(Vector([0.0; 3]), |sum, (axis, change)| sum + axis.cross(*change).scaled(0.5));
    Twist { turn, shift: slope.origin }
}
