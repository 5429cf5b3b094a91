//! Why a loop, spring, load or mimic relation cannot be part of the mechanism.

use crate::geometry::GeometryError;
use crate::scene::Element;
use std::path::PathBuf;

/// The defect of a coupling, and its place in the file.
#[derive(Debug, PartialEq, thiserror::Error)]
#[error("{}:{line}: {element}: {problem}", file.display())]
pub struct CouplingError {
    /// The file.
    pub file: PathBuf,
    /// The line, counted from 1.
    pub line: usize,
    /// The loop, spring, load or joint.
    pub element: Element,
    /// The defect.
    pub problem: CouplingProblem,
}

/// A defect of a part that couples or pushes bodies.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum CouplingProblem {
    /// A collision mesh that is there and cannot be used, with its link and the place of the shape among the shapes of the link.
    #[error(
        "its collision mesh {mesh:?} cannot be used: {problem}. Mend the file, or leave this shape out in the scene file: [[link]] with name = {:?}, shape = {}, collision = \"none\"",
        shape_of.0, shape_of.1
    )]
    Mesh { mesh: Box<str>, problem: Box<str>, shape_of: Box<(String, usize)> },
    /// Convex pieces were asked for, and the mesh has no inside.
    #[error("its collision mesh {mesh:?} cannot be cut into convex pieces: {problem}")]
    Pieces { mesh: String, problem: Box<GeometryError> },
    /// The link was left out of the mechanism.
    #[error(
        "link {0:?} is not simulated, because neither it nor anything beyond it has mass; give it a mass and an inertia"
    )]
    DroppedLink(String),
    /// A point at a distance whose square is infinite.
    #[error("the point on link {0:?} is so far away that distances to it are infinite")]
    TooFar(String),
    /// A loop between two frames that cannot move against each other, and lie as it wants them.
    #[error("links {a:?} and {b:?} are fixed to each other, so the loop says nothing new; leave it out")]
    ImpliedByBody { a: String, b: String },
    /// A loop between two frames that cannot move against each other, and lie otherwise.
    #[error("links {a:?} and {b:?} are fixed to each other and {gap:.2e} m or rad away from where the loop wants them")]
    Contradictory { a: String, b: String, gap: f64 },
    /// A loop that the joints of the tree keep closed whatever they do.
    #[error("the joints between links {a:?} and {b:?} keep it closed whatever they do; leave the loop out")]
    ImpliedByTree { a: String, b: String },
    /// A loop with the name of a joint or of another loop.
    #[error(
        "there is a joint or another loop of this name; give it another, because logs and reports tell them apart by it"
    )]
    NameTaken,
    /// A distance of zero.
    #[error("the two points coincide, so there is no distance to keep; give a length, or the type \"spherical\"")]
    ZeroDistance,
    /// A spring between two points of one body.
    #[error("links {a:?} and {b:?} are fixed to each other, so the spring does nothing; leave it out")]
    IdleSpring { a: String, b: String },
    /// A rope between two points of one body.
    #[error("its points are on {a:?} and {b:?}, which do not move against each other; leave it out")]
    IdleRope { a: String, b: String },
    /// A load on a fixed link.
    #[error("link {0:?} is fixed in the world, so the load does nothing; leave it out")]
    IdleLoad(String),
    /// A joint that has no displacement of one number.
    #[error("joint {joint:?} {reason}; one that turns about or slides along its axis is needed")]
    NotScalar { joint: String, reason: &'static str },
    /// A loop that leads around a joint whose weight is to be held.
    #[error(
        "loop {closing:?} leads around joint {joint:?}, so that the joint has no weight of its own; leave out gravity_compensation here"
    )]
    WeightInLoop { joint: String, closing: String },
    /// A collision shape without size.
    #[error("the {what} is {size} m; it must be greater than zero")]
    ShapeSize { what: &'static str, size: f64 },
    /// A collision shape that cannot be.
    #[error("its collision shape cannot be used: {0}")]
    Shape(GeometryError),
    /// A name of a pair that no shape has.
    #[error("{pattern:?} names no link with a collision shape and no obstacle; there are {known}")]
    NoShape { pattern: String, known: String },
    /// A joint follows one that does not exist.
    #[error("it mimics joint {0:?}, which does not exist")]
    UnknownLeader(String),
    /// Joints that follow each other in a circle.
    #[error("it mimics itself (through {0:?})")]
    MimicCircle(String),
}
