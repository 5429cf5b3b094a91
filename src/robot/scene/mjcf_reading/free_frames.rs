//! Frames of free bodies whose motion a keyframe gives.
//!
//! MuJoCo moves the frame of a free body without children to its inertial frame A, where `align` of its `<freejoint>` or `alignfree` of `<compiler>` says
//! so. Its `qpos` is then the pose P of that frame, its `qvel` the velocity v of the centre of mass in the world and the spin in the axes of A:
//!
//! ```text
//!     B = P A⁻¹,   ω = R_P ω_A,   v_B = v + ω × (b − p)
//! ```
//!
//! with the pose B of the body as it is described, at b, and its centre of mass p (m, m/s, rad/s). An algorithm of MuJoCo
//! chooses the axes of inertias that are not diagonal or are composed of geoms: a keyframe of such a body is a warning.
//!
//! Source: MuJoCo documentation, XML reference, `body/freejoint/align`, and what MuJoCo 4.0 computes.

use crate::scene::mjcf_reading::bodies::is_free;
use crate::scene::mjcf_reading::mass::MassOf;
use crate::scene::mjcf_reading::parts::FreeFrame;
use crate::scene::mjcf_reading::reader::Reader;
use crate::scene::mjcf_reading::tree::Element;
use nalgebra::Matrix3;

impl Reader<'_> {
    /// The frame of a body with a free joint; `mass` is the mass of a body without children, `is_one` says that no parts compose it.
    pub fn free_frame(&self, body: &Element, mass: Option<&MassOf>, is_one: bool) -> FreeFrame {
        let own = body.all("freejoint").next().and_then(|free| free.flag("align"));
        let aligns = body.children.iter().any(is_free) && own.unwrap_or(self.compiler.aligns_free);
        let Some(of) = mass.filter(|_| aligns) else { return FreeFrame::Body };
        let is_full = body.all("inertial").any(|inertial| inertial.text("fullinertia").is_some());
        match is_one && !is_full && of.inertia == Matrix3::from_diagonal(&of.inertia.diagonal()) {
            true => FreeFrame::Inertial(of.frame),
            false => FreeFrame::Unread,
        }
    }
}
