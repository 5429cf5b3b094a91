//! Errors of a shape, in words without a file: the caller adds the file, the link and the line.

/// A shape, or a pair of shapes, whose contact cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A size that is zero, negative or not finite.
    #[error("the {what} of the {shape} is {} m: give a positive length below 1e150 m", shown(*.value))]
    Size {
        /// Kind of the shape.
        shape: &'static str,
        /// Which size.
        what: &'static str,
        /// m.
        value: f64,
    },
    /// A coordinate is infinite or not a number.
    #[error("coordinate {axis} of vertex {vertex} is {value}: give a finite number")]
    Coordinate {
        /// Number of the vertex.
        vertex: usize,
        /// x, y or z.
        axis: char,
        /// m.
        value: f64,
    },
    /// The pose of a shape in its body is not finite.
    #[error("the pose of the {shape} is not finite: give finite positions and angles")]
    Pose {
        /// Kind of the shape.
        shape: &'static str,
    },
    /// Not enough points for a hull.
    #[error("a convex hull of {count} points has no area: give at least 3 points that do not lie on one line")]
    FewPoints {
        /// How many there are.
        count: usize,
    },
    /// All points nearly in one plane, on a line or at one place.
    #[error(
        "all points lie within {thickness:.1e} m of one plane or on a line: give the hull a thickness, or make it flat"
    )]
    Flat {
        /// Distance of the farthest point from the plane (m).
        thickness: f64,
    },
    /// The hull was not found.
    #[error("no convex hull was found ({reason}): remove points that nearly coincide")]
    Hull {
        /// The message of the algorithm.
        reason: String,
    },
    /// A mesh without triangles that have an area.
    #[error("the mesh has no triangle with an area: export it again with its faces")]
    EmptyMesh,
    /// A flat surface is to be cut into pieces.
    #[error("the mesh is flat and has no volume: give it a thickness, or use its convex hull")]
    EnclosesNothing,
    /// A surface with a border is to be cut into pieces.
    #[error(
        "the mesh is not closed ({edges} edges have a triangle on one side only): close it, or use its convex hull"
    )]
    Open {
        /// How many edges are on a border.
        edges: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but there are {count} vertices: export the mesh again")]
    Index {
        /// Number of the triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// More than can be handled in a reasonable time.
    #[error("{count} {what} are more than {limit}: simplify the shape or use its convex hull")]
    TooMany {
        /// Triangles or points.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many are possible.
        limit: usize,
    },
    /// Coordinates that are rounded to more than contacts are exact to.
    #[error(
        "the {shape} reaches {} m from its origin, farther than {limit:e} m: give lengths in metres (a mesh takes a scale), or a half space as ground",
        shown(*.reach)
    )]
    TooFar {
        /// Kind of the shape.
        shape: &'static str,
        /// m.
        reach: f64,
        /// m.
        limit: f64,
    },
    /// An ellipsoid and a shape that is no half space.
    #[error(
        "contact of an ellipsoid with a {other} is not simulated, only with half spaces: leave the pair out with ignore = true"
    )]
    Ellipsoid {
        /// The kind of the other shape.
        other: &'static str,
    },
    /// Two shapes of which neither is convex and bounded.
    #[error("contact of a {a} with a {b} is not possible: one of two shapes must be convex and bounded")]
    Obstacles {
        /// One shape.
        a: &'static str,
        /// The other.
        b: &'static str,
    },
}

/// A number in few digits: with a power of ten where it is huge or tiny.
fn shown(value: f64) -> String {
    let plain = value == 0.0 || !value.is_finite() || (1e-6..1e9).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}
