//! The links of a URDF must form one tree; this finds its root or says why they form no tree.
//!
//! A world that only joints mention (`<parent link="world"/>` without `<link name="world">`, as Drake and
//! RigidBodyDynamics.jl write it) is a root too.

use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::robot::{Link, UrdfJoint};
use crate::scene::urdf_reading::clean::error_at;
use crate::scene::world::WORLD_LINK;
use std::collections::HashMap;
use std::path::Path;

/// The root link; `None` is an undeclared world.
pub(crate) fn find_root(
    file: &Path,
    links: &[Link],
    joints: &[UrdfJoint],
    robot_line: usize,
) -> Result<Option<usize>, SceneError> {
    if links.is_empty() {
        return Err(error_at(file, robot_line, None, Problem::NoLinks));
    }
    let by_name = unique_links(file, links)?;
    unique_joints(file, joints)?;
    let tree = parents(file, links, joints, &by_name)?;
    refuse_cycles(file, links, &tree)?;
    one_root(file, links, &tree, robot_line)
}

/// The parent of a link.
#[derive(Clone, Copy, PartialEq)]
enum Above {
    /// No parent: it is a root.
    Nothing,
    /// The undeclared world.
    World,
    /// A link, by index.
    Link(usize),
}

fn unique_links<'l>(file: &Path, links: &'l [Link]) -> Result<HashMap<&'l str, usize>, SceneError> {
    let mut by_name = HashMap::new();
    for (index, link) in links.iter().enumerate() {
        if let Some(first) = by_name.insert(link.name.as_str(), index) {
            let problem = Problem::DuplicateName { first_line: links[first].line };
            return Err(error_at(file, link.line, Some(Element::Link(link.name.clone())), problem));
        }
    }
    Ok(by_name)
}

fn unique_joints(file: &Path, joints: &[UrdfJoint]) -> Result<(), SceneError> {
    let mut lines = HashMap::new();
    for joint in joints {
        if let Some(first_line) = lines.insert(joint.name.as_str(), joint.line) {
            let element = Some(Element::Joint(joint.name.clone()));
            return Err(error_at(file, joint.line, element, Problem::DuplicateName { first_line }));
        }
    }
    Ok(())
}

/// The parent of each link, from the joints.
fn parents(
    file: &Path,
    links: &[Link],
    joints: &[UrdfJoint],
    by_name: &HashMap<&str, usize>,
) -> Result<Vec<Above>, SceneError> {
    let mut above = vec![Above::Nothing; links.len()];
    let mut joint_above: Vec<Option<&str>> = vec![None; links.len()];
    for joint in joints {
        let refuse = |role, name: &str| {
            let problem = Problem::UnknownLink { role, name: name.to_string() };
            error_at(file, joint.line, Some(Element::Joint(joint.name.clone())), problem)
        };
        let parent = match by_name.get(joint.parent.as_str()) {
            Some(&parent) => Above::Link(parent),
            None if joint.parent == WORLD_LINK => Above::World,
            None => return Err(refuse("parent", &joint.parent)),
        };
        let Some(&child) = by_name.get(joint.child.as_str()) else { return Err(refuse("child", &joint.child)) };
        if let Some(first) = joint_above[child] {
            let problem = Problem::TwoParents { first: first.to_string(), second: joint.name.clone() };
            return Err(error_at(file, joint.line, Some(Element::Link(joint.child.clone())), problem));
        }
        joint_above[child] = Some(&joint.name);
        above[child] = parent;
    }
    Ok(above)
}

/// Walks up from every link; a walk that meets itself is a cycle.
fn refuse_cycles(file: &Path, links: &[Link], above: &[Above]) -> Result<(), SceneError> {
    // Number of the walk that first visited each link; 0 before the first visit.
    let mut visited = vec![0; links.len()];
    for start in 0..links.len() {
        let walk = start + 1;
        let mut link = start;
        while visited[link] == 0 {
            visited[link] = walk;
            match above[link] {
                Above::Link(parent) => link = parent,
                Above::Nothing | Above::World => break,
            }
        }
        if visited[link] == walk && above[link] != Above::Nothing && above[link] != Above::World {
            let mut path = vec![links[link].name.clone()];
            let mut next = link;
            while let Above::Link(parent) = above[next] {
                path.push(links[parent].name.clone());
                next = parent;
                if next == link {
                    break;
                }
            }
            path.reverse();
            let element = Some(Element::Link(links[link].name.clone()));
            return Err(error_at(file, links[link].line, element, Problem::Cycle { path }));
        }
    }
    Ok(())
}

fn one_root(file: &Path, links: &[Link], above: &[Above], robot_line: usize) -> Result<Option<usize>, SceneError> {
    let roots: Vec<usize> = (0..links.len()).filter(|&link| above[link] == Above::Nothing).collect();
    let implicit_world = above.contains(&Above::World);
    match (roots.as_slice(), implicit_world) {
        ([], _) => Ok(None),
        (&[root], false) => Ok(Some(root)),
        _ => {
            let world = implicit_world.then(|| WORLD_LINK.to_string());
            let names: Vec<String> =
                world.into_iter().chain(roots.iter().map(|&root| links[root].name.clone())).collect();
            // The second root is the one that should not be there.
            let extra = if implicit_world { roots.first() } else { roots.get(1) };
            let (line, element) = match extra {
                Some(&extra) => (links[extra].line, Some(Element::Link(links[extra].name.clone()))),
                None => (robot_line, None),
            };
            Err(error_at(file, line, element, Problem::SeveralRoots(names)))
        }
    }
}
