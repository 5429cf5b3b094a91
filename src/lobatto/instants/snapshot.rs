//! Poses of links and wrenches of joints at several instants of a motion at once: one instant in each lane.
//!
//! `tree` is the recursion over the bodies, `constants` and `joints` are its inputs, `quaternion` is its rotations.

use catena_mechanism::description::joint::Pose;
use catena_mechanism::description::mechanism::Mechanism;

/// Number of instants that are evaluated together.
pub const INSTANTS: usize = 8;

/// A number at each of the instants.
pub type Row = [f64; INSTANTS];

/// Poses of links and wrenches of joints at some instants.
#[derive(Clone, Debug, Default)]
pub struct Snapshots {
    /// For each link the position x, y, z (m) and the unit quaternion w, x, y, z with w ≥ 0, in the world.
    pub poses: Vec<[Row; 7]>,
    /// For each body's joint the force (N) and the torque [N m] of the parent on the child at the anchor, in the axes of the world.
    pub wrenches: Vec<[Row; 6]>,
    /// For each body's joint the effort along its axis: the force of a slide (N), else the torque [N m].
    pub efforts: Vec<Row>,
    /// For each loop joint the wrench of the first end on the second, at the point of the second.
    pub loops: Vec<[Row; 6]>,
}

impl Snapshots {
    /// Room for a mechanism and its links.
    pub fn new(mechanism: &Mechanism, links: usize) -> Self {
        let bodies = mechanism.bodies.len();
        Snapshots {
            poses: vec![[[0.0; INSTANTS]; 7]; links],
            wrenches: vec![[[0.0; INSTANTS]; 6]; bodies],
            efforts: vec![[0.0; INSTANTS]; bodies],
            loops: vec![[[0.0; INSTANTS]; 6]; mechanism.loops.len()],
        }
    }
}

/// Works out snapshots.
pub trait Instants: Send {
    /// The snapshots of `count` instants, at most [`INSTANTS`] and at least one, from their positions and velocities, one after the
    /// other. Does not allocate.
    fn look(&mut self, positions: &[f64], velocities: &[f64], count: usize, out: &mut Snapshots);
}

/// A link by the body that carries it (`None` is the world) and its frame there.
pub type LinkPlace = (Option<usize>, Pose);
