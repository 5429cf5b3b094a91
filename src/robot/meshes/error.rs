//! Errors of mesh files; the caller adds the name of the file.

/// Why a mesh file gives no surface.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file could not be read.
    #[error("it cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// The ending does not belong to a format that is read.
    #[error("meshes are read from .stl, .obj and .dae files, not from {ending:?}; convert it to one of these")]
    UnknownKind {
        /// The ending, in small letters.
        ending: String,
    },
    /// It is not what its ending says.
    #[error("line {line}: {what}")]
    Line {
        /// Line of the file, from 1.
        line: usize,
        /// The defect.
        what: String,
    },
    /// It is not what its ending says.
    #[error("{0}")]
    Damaged(String),
    /// The pointer that Git LFS leaves in the place of a file that it has not fetched.
    #[error("it is a pointer of Git LFS, not a mesh; fetch the mesh with git lfs pull")]
    LfsPointer,
    /// No triangle in it has three different corners.
    #[error("there is no triangle in it")]
    Empty,
    /// All its triangles are lines.
    #[error("none of its triangles has an area")]
    NoArea,
    /// A coordinate that is infinite, no number, or too large for single precision.
    #[error("a corner of a triangle is not finite")]
    NotFinite,
    /// More triangles than any robot has.
    #[error("it has more than {most} triangles; simplify it")]
    TooLarge {
        /// The most that are read.
        most: usize,
    },
}
