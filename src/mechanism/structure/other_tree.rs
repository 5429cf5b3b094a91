//! The same mechanism on another spanning tree, and the correspondence of its coordinates on both.
//!
//! A joint that turns round in the tree keeps its coordinate: with both of its frames turned by half a turn about x,
//!
//! ```text
//!     A' = B X,   B' = A X,   X = diag(1, −1, −1):        Rj' = X Rjᵀ X = Rz(q),    t' = q z
//! ```
//!
//! for hinges and slides, so displacements, rates and efforts along them are unchanged. The coordinates of the other joints follow from the places of
//! the bodies ([`crate::motion::joint_coordinates`]).
//!
//! A loop joint holds for axes that point the same way or opposite ways; a joint of a tree has to know which. That is asked of a state.

use crate::description::body_state::{BodyState, WORLD};
use crate::description::joint::{Joint, JointKind, Pose};
use crate::description::mechanism::{Body, Mechanism, MechanismError};
use crate::motion::joint_coordinates::joint_coordinates;
use crate::motion::kinematics::{body_states, forward_kinematics, place_bodies};
use crate::motion::state::State;
use crate::structure::plane::Plane;
use crate::structure::renumbering::Renumbering;
use crate::structure::spanning_tree::{Edge, Hang, SpanningTree, as_closure, hanging};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::ops::Range;

/// A mechanism on another spanning tree than its file's.
#[derive(Clone, Debug)]
pub struct OtherTree {
    /// The mechanism on that tree. Limits, friction, motors and colliders are not in it.
    pub mechanism: Mechanism,
    /// Its bodies by their numbers in the file's tree.
    pub(super) of_file: Vec<usize>,
    /// The places of the joints of its bodies on this tree, and of its loop joints.
    joints: Vec<Found>,
    closing: Vec<Found>,
    /// Coordinates that both have: positions and velocities, here and in the file's tree.
    pub(super) same: Vec<[(Range<usize>, Range<usize>); 2]>,
    /// For every degree of freedom of the file's tree the one here.
    freedoms: Vec<Option<usize>>,
    /// The bodies here whose joints have other coordinates.
    fresh: Vec<usize>,
    /// The same of the file's tree.
    pub(super) computed: Vec<usize>,
    /// Which way the axes of the loop joints point on which bodies hang, body by body in the file's order: the diagonal of a half turn.
    ways: Vec<Vector3<f64>>,
    /// Room for the bodies of one tree, and of the other.
    pub(super) bodies: Vec<BodyState>,
    sorted: Vec<BodyState>,
}

/// The place of a joint of the file on the other tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// This body hangs on it; backwards if that is the body of its first end.
    Carries {
        /// The number of the body on the other tree.
        body: usize,
        /// Whether the joint turns round.
        backwards: bool,
    },
    /// It is this loop joint, with the same ends.
    Closes(usize),
}

/// Half a turn about x.
fn turned(pose: &Pose) -> Pose {
    let half = Rotation3::from_matrix_unchecked(Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)));
    Pose::from_parts(pose.translation, pose.rotation * half)
}

/// For every body whether its joint is a loop joint of the file whose axes point the same way in a state, or which half turn lies between them.
fn ways(mechanism: &Mechanism, tree: &SpanningTree, plane: Option<&Plane>, state: &State) -> Vec<Vector3<f64>> {
    let zero = body_states(mechanism, &State::zero(mechanism));
    let bodies = body_states(mechanism, state);
    let same = Vector3::repeat(1.0);
    let way = |hang: &Hang| {
        let Edge::Loop(index) = hang.by else { return same };
        let joint = &mechanism.loops[index];
        let Some((kind, [on_a, on_b])) = hanging(joint, plane, &zero) else { return same };
        let axes = |body: Option<usize>, frame: &Pose| {
            body.map_or(&WORLD, |body| &bodies[body]).rotation * frame.rotation.matrix()
        };
        let turn = axes(joint.a.body, &on_a).tr_mul(&axes(joint.b.body, &on_b));
        let [about_x, about_y, about_z] =
            [(1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)].map(|(x, y, z)| Vector3::new(x, y, z));
        match kind {
            JointKind::Revolute | JointKind::Planar if turn.m33 < 0.0 => about_x,
            JointKind::Prismatic => {
                let diagonal = turn.diagonal();
                let all = [same, about_x, about_y, about_z];
                // The first of the best ones.
                all.into_iter()
                    .reduce(|best, way| if way.dot(&diagonal) > best.dot(&diagonal) { way } else { best })
                    .unwrap_or(same)
            }
            _ => same,
        }
    };
    tree.hangs.iter().map(way).collect()
}

impl OtherTree {
    /// A mechanism, which moves in this plane or in space, on another spanning tree; the axes of loop joints point as they do in `state`.
    ///
    /// # Errors
    /// [`MechanismError`] if the order of the tree is not depth first.
    pub fn new(
        file: &Mechanism,
        tree: &SpanningTree,
        plane: Option<&Plane>,
        state: &State,
    ) -> Result<Self, MechanismError> {
        let zero = body_states(file, &State::zero(file));
        let ways = ways(file, tree, plane, state);
        let mut of_file = vec![0; file.bodies.len()];
        tree.order.iter().enumerate().for_each(|(own, &body)| of_file[body] = own);
        let joint = |body: usize| {
            let hang = &tree.hangs[body];
            let (name, kind, mut frames, armature) = match hang.by {
                Edge::Tree(of) => {
                    let joint = &file.bodies[of].joint;
                    (&joint.name, joint.kind, [joint.on_parent, joint.on_child], joint.armature)
                }
                Edge::Loop(index) => {
                    let joint = &file.loops[index];
                    let (kind, [on_a, mut on_b]) =
                        hanging(joint, plane, &zero).unwrap_or((JointKind::Floating, [joint.a.frame, joint.b.frame]));
                    let half = Rotation3::from_matrix_unchecked(Matrix3::from_diagonal(&ways[body]));
                    on_b.rotation *= half;
                    (&joint.name, kind, [on_a, on_b], 0.0)
                }
            };
            if hang.backwards {
                frames.reverse();
                frames = frames.map(|frame| turned(&frame));
            }
            Joint { armature, ..Joint::new(name, kind, frames[0], frames[1]) }
        };
        let bodies = tree.order.iter().map(|&body| Body {
            parent: tree.hangs[body].parent.map(|parent| of_file[parent]),
            joint: joint(body),
            ..file.bodies[body].clone()
        });
        let mut mechanism = Mechanism::new(&file.name, file.gravity, bodies.collect())?;
        let hung: Vec<usize> = tree.hung_loops().collect();
        let loops = file.loops.iter().enumerate().filter(|(index, _)| !hung.contains(index));
        mechanism.loops = loops.map(|(_, joint)| joint.clone()).collect();
        let cut: Vec<usize> = tree.cut_joints().collect();
        mechanism.loops.extend(cut.iter().filter_map(|&body| as_closure(&file.bodies[body], body)));
        mechanism.touches.clone_from(&file.touches);
        mechanism.mimics.clone_from(&file.mimics);
        mechanism.forces = file.forces.clone();

        let mut joints = vec![Found::Closes(0); file.bodies.len()];
        let mut closing = vec![Found::Closes(0); file.loops.len()];
        for (body, &Hang { by, backwards, .. }) in tree.hangs.iter().enumerate() {
            let carries = Found::Carries { body: of_file[body], backwards };
            match by {
                Edge::Tree(of) => joints[of] = carries,
                Edge::Loop(index) => closing[index] = carries,
            }
        }
        let kept = (0..file.loops.len()).filter(|index| !hung.contains(index));
        kept.enumerate().for_each(|(number, index)| closing[index] = Found::Closes(number));
        let first = file.loops.len() - hung.len();
        cut.iter().enumerate().for_each(|(number, &body)| joints[body] = Found::Closes(first + number));

        // The joints that both have, whose coordinates are the same.
        let mut place = vec![None; file.bodies.len()];
        let mut fresh = Vec::new();
        for (own, &body) in tree.order.iter().enumerate() {
            let Hang { by, backwards, .. } = tree.hangs[body];
            let scalar = |of: usize| file.bodies[of].joint.kind.position_count() == 1;
            match by {
                Edge::Tree(of) if !backwards || scalar(of) => place[of] = Some(own),
                _ => fresh.push(own),
            }
        }
        let joint_here = |of: usize| place[of].map(|own| &mechanism.bodies[own].joint);
        let same = (0..file.bodies.len()).filter_map(|of| {
            let (here, there) = (joint_here(of)?, &file.bodies[of].joint);
            let positions = (here.position_range(), there.position_range());
            Some([positions, (here.velocity_range(), there.velocity_range())])
        });
        let same: Vec<_> = same.collect();
        let mut freedoms = vec![None; file.velocity_count];
        for [_, (here, there)] in &same {
            there.clone().zip(here.clone()).for_each(|(there, here)| freedoms[there] = Some(here));
        }
        let moved = |of: usize, entry: usize, range: fn(&Joint) -> Range<usize>| {
            joint_here(of).map_or(entry, |here| range(here).start + entry - range(&file.bodies[of].joint).start)
        };
        let body_of_position = |position: usize| {
            file.bodies.partition_point(|body| body.joint.position_index <= position).saturating_sub(1)
        };
        let position = |entry: usize| moved(body_of_position(entry), entry, Joint::position_range);
        let freedom =
            |entry: usize| moved(file.body_of_freedom(entry).unwrap_or_default(), entry, Joint::velocity_range);
        let body = |body: usize| of_file[body];
        let mut renumbered = mechanism.clone();
        Renumbering { body: &body, position: &position, freedom: &freedom }.apply(&mut renumbered);
        let computed = (0..file.bodies.len()).filter(|&of| place[of].is_none()).collect();
        let room = vec![WORLD; file.bodies.len()];
        Ok(OtherTree {
            mechanism: renumbered,
            of_file,
            joints,
            closing,
            same,
            freedoms,
            fresh,
            computed,
            ways,
            bodies: room.clone(),
            sorted: room,
        })
    }

    /// Whether the axes of loop joints point in a state as they did in the one it was made for.
    pub fn fits(&self, file: &Mechanism, tree: &SpanningTree, plane: Option<&Plane>, state: &State) -> bool {
        ways(file, tree, plane, state) == self.ways
    }

    /// The number here of a body of the file's tree.
    pub fn number(&self, body: usize) -> usize {
        self.of_file[body]
    }

    /// The place of the joint of a body of the file's tree.
    pub fn joint(&self, body: usize) -> Found {
        self.joints[body]
    }

    /// The place of a loop joint of the file.
    pub fn closing(&self, index: usize) -> Found {
        self.closing[index]
    }

    /// The bodies of the file's tree whose joints have no coordinates here, or others.
    pub fn computed(&self) -> &[usize] {
        &self.computed
    }

    /// The degree of freedom here that is one of the file's, if its joint has the same coordinates on both trees.
    pub fn freedom(&self, of: usize) -> Option<usize> {
        self.freedoms[of]
    }

    /// Takes a state of the file's tree. Does not allocate.
    pub fn take(&mut self, file: &Mechanism, state: &State, own: &mut State) {
        own.time = state.time;
        for [(here, there), (rates_here, rates_there)] in &self.same {
            own.position[here.clone()].copy_from_slice(&state.position[there.clone()]);
            own.compensation[here.clone()].copy_from_slice(&state.compensation[there.clone()]);
            own.velocity[rates_here.clone()].copy_from_slice(&state.velocity[rates_there.clone()]);
        }
        if self.fresh.is_empty() {
            return;
        }
        place_bodies(file, state, &mut self.bodies);
        for (body, &own) in self.of_file.iter().enumerate() {
            self.sorted[own] = self.bodies[body];
        }
        for &body in &self.fresh {
            let Body { parent, joint, .. } = &self.mechanism.bodies[body];
            let parent = parent.map_or(&WORLD, |parent| &self.sorted[parent]);
            let (positions, velocities) = (joint.position_range(), joint.velocity_range());
            own.compensation[positions.clone()].fill(0.0);
            let (position, velocity) = (&mut own.position[positions], &mut own.velocity[velocities]);
            joint_coordinates(joint, parent, &self.sorted[body], position, velocity);
        }
    }

    /// Writes a state of this tree as one of the file's; angles of joints that are cut are between −π and π. Does not allocate.
    pub fn give(&mut self, file: &Mechanism, own: &State, state: &mut State) {
        state.time = own.time;
        for [(here, there), _] in &self.same {
            state.compensation[there.clone()].copy_from_slice(&own.compensation[here.clone()]);
        }
        for &body in &self.computed {
            state.compensation[file.bodies[body].joint.position_range()].fill(0.0);
        }
        place_bodies(&self.mechanism, own, &mut self.bodies);
        self.write(file, &own.position, &own.velocity, &mut state.position, &mut state.velocity);
    }

    /// The same of positions and velocities alone.
    pub fn give_coordinates(
        &mut self,
        file: &Mechanism,
        own: (&[f64], &[f64]),
        position: &mut [f64],
        velocity: &mut [f64],
    ) {
        forward_kinematics(&self.mechanism, own.0, own.1, &mut self.bodies);
        self.write(file, own.0, own.1, position, velocity);
    }

    /// Writes the coordinates of the file's tree for bodies that are placed.
    fn write(
        &self,
        file: &Mechanism,
        own_position: &[f64],
        own_velocity: &[f64],
        position: &mut [f64],
        velocity: &mut [f64],
    ) {
        for [(here, there), (rates_here, rates_there)] in &self.same {
            position[there.clone()].copy_from_slice(&own_position[here.clone()]);
            velocity[rates_there.clone()].copy_from_slice(&own_velocity[rates_here.clone()]);
        }
        for &body in &self.computed {
            let Body { parent, joint, .. } = &file.bodies[body];
            let parent = parent.map_or(&WORLD, |parent| &self.bodies[self.of_file[parent]]);
            let child = &self.bodies[self.of_file[body]];
            let (positions, velocities) = (joint.position_range(), joint.velocity_range());
            joint_coordinates(joint, parent, child, &mut position[positions], &mut velocity[velocities]);
        }
    }
}
