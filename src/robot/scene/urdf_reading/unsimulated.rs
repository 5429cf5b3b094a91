//! The parts of a URDF that are not simulated: one warning for each kind.

use crate::scene::robot::{Limit, UrdfJoint, UrdfJointKind};
use crate::scene::urdf_reading::clean::Ignored;
use crate::scene::warning::{Warning, WarningGroup};
use std::path::Path;

/// The warnings about a robot's joints, and about ignored elements.
pub(crate) fn unsimulated(file: &Path, joints: &[UrdfJoint], ignored: &[Ignored]) -> Vec<Warning> {
    let lines_where =
        |holds: &dyn Fn(&UrdfJoint) -> bool| joints.iter().filter(|j| holds(j)).map(|j| j.line).collect::<Vec<_>>();
    let endless = |joint: &UrdfJoint| joint.kind == UrdfJointKind::Continuous;
    let several = |joint: &UrdfJoint| {
        matches!(joint.kind, UrdfJointKind::Floating | UrdfJointKind::Planar | UrdfJointKind::Spherical)
    };
    let kinds = [
        (
            "lower and upper limits",
            "continuous joint",
            "are not read",
            lines_where(&|joint| endless(joint) && joint.limit.is_some_and(says_range)),
        ),
        (
            "limits",
            "floating, planar or spherical joint",
            "are not simulated",
            lines_where(&|joint| several(joint) && joint.limit.is_some_and(says_range)),
        ),
    ];
    let counted = kinds.into_iter().filter_map(|kind| warning(file, kind));
    let unread = ignored.iter().map(|ignored| {
        let times = if ignored.count == 1 { String::new() } else { format!(" ({} times)", ignored.count) };
        let message = format!("{}{times}", ignored.what);
        Warning::odd(file, Some(ignored.line), None, message).in_group(WarningGroup::Ignored)
    });
    counted.chain(unread).collect()
}

/// One warning for all lines on which there is something of a kind.
fn warning(file: &Path, (what, of, verdict, lines): (&str, &str, &str, Vec<usize>)) -> Option<Warning> {
    let first = *lines.first()?;
    let plural = if lines.len() == 1 { "" } else { "s" };
    let message = format!("{what} of {} {of}{plural} {verdict}", lines.len());
    Some(Warning::odd(file, Some(first), None, message).in_group(WarningGroup::NotSimulated))
}

/// Whether it names a position that is not zero, as some writers fill in where there is no limit.
fn says_range(limit: Limit) -> bool {
    let names = |bound: Option<f64>| bound.is_some_and(|bound| bound.is_finite() && bound != 0.0);
    names(limit.lower) || names(limit.upper)
}
