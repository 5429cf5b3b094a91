//! What a URDF says that is not simulated: one warning for each kind of thing, never silence.

use crate::scene::clean::Ignored;
use crate::scene::error::Warning;
use crate::scene::robot::{Link, UrdfJoint, UrdfJointKind};
use std::path::Path;

/// The warnings about a robot's joints, shapes, and elements nobody reads.
pub(crate) fn unsimulated(file: &Path, links: &[Link], joints: &[UrdfJoint], ignored: &[Ignored]) -> Vec<Warning> {
    let moving: Vec<&UrdfJoint> = joints.iter().filter(|joint| joint.kind != UrdfJointKind::Fixed).collect();
    let lines_where =
        |holds: &dyn Fn(&UrdfJoint) -> bool| moving.iter().filter(|j| holds(j)).map(|j| j.line).collect::<Vec<_>>();
    let touching: Vec<usize> = links.iter().filter(|link| !link.collisions.is_empty()).map(|link| link.line).collect();
    let endless = |joint: &UrdfJoint| joint.kind == UrdfJointKind::Continuous;
    let ranges = lines_where(&|joint| endless(joint) && joint.limit.is_some_and(|limit| limit.range().is_some()));
    let kinds = [
        ("joint limits", "joint", "are not simulated", lines_where(&|joint| joint.limit.is_some())),
        ("lower and upper limits", "continuous joint", "are not read", ranges),
        (
            "joint friction",
            "joint",
            "is not simulated",
            lines_where(&|joint| joint.dynamics.is_some_and(|d| d.friction != 0.0)),
        ),
        ("contacts (collision shapes)", "link", "are not simulated", touching),
    ];
    let counted = kinds.into_iter().filter_map(|(what, of, verdict, lines)| {
        let first = *lines.first()?;
        let plural = if lines.len() == 1 { "" } else { "s" };
        Some((first, format!("{what} of {} {of}{plural} {verdict}", lines.len())))
    });
    let unread = ignored.iter().map(|ignored| {
        let times = if ignored.count == 1 { String::new() } else { format!(" ({} times)", ignored.count) };
        (ignored.line, format!("{}{times} is not read", ignored.what))
    });
    counted
        .chain(unread)
        .map(|(line, message)| Warning { file: file.to_path_buf(), line: Some(line), element: None, message })
        .collect()
}
