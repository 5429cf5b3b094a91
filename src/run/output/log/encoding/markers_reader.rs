//! Reads the meshes of `/visual_markers` back ([`crate::output::log::encoding::markers`]).

use crate::output::log::encoding::cdr_reader::CdrReader;
use crate::output::log::encoding::markers::SHAPES;

/// The numbers of the kinds of markers that are meshes.
const MESH: u32 = 10;
const TRIANGLES: u32 = 11;

/// A marker of a mesh: triangles of one colour, or the address of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeshMarker {
    /// The link.
    pub link: String,
    /// Which of the visuals of the link it shows, from 0.
    pub visual: u32,
    /// Red, green, blue, opacity in 0..1.
    pub color: [f32; 4],
    /// Corners (m), three a triangle, with the scale of the URDF; empty for a file.
    pub corners: Vec<[f32; 3]>,
    /// The address of the file; empty for triangles.
    pub address: String,
}

/// The markers of a `visualization_msgs/msg/MarkerArray` that are meshes.
///
/// # Errors
/// The defect of the message.
pub(crate) fn mesh_markers(data: &[u8]) -> Result<Vec<MeshMarker>, String> {
    let markers = CdrReader::new(data)?.sequence(marker)?;
    Ok(markers.into_iter().flatten().collect())
}

fn marker(cdr: &mut CdrReader) -> Result<Option<MeshMarker>, String> {
    cdr.time()?;
    let link = cdr.string()?;
    cdr.string()?;
    let [number, kind, _action] = [cdr.unsigned()?, cdr.unsigned()?, cdr.unsigned()?];
    let _pose_and_scale = cdr.numbers::<10>()?;
    let color = cdr.singles()?;
    let _lifetime = [cdr.unsigned()?, cdr.unsigned()?];
    let _follows = cdr.aligned::<1>()?;
    let corners = cdr.sequence(|cdr| Ok(cdr.numbers()?.map(|coordinate: f64| coordinate as f32)))?;
    let _colors = cdr.sequence(CdrReader::singles::<4>)?;
    // The texture: address, header, format, bytes, coordinates.
    cdr.string()?;
    cdr.header()?;
    cdr.string()?;
    cdr.sequence(CdrReader::aligned::<1>)?;
    cdr.sequence(CdrReader::singles::<2>)?;
    let _text = cdr.string()?;
    let address = cdr.string()?;
    // The file: name, bytes.
    cdr.string()?;
    cdr.sequence(CdrReader::aligned::<1>)?;
    let _own_colors = cdr.aligned::<1>()?;
    let is_mesh = kind == MESH || kind == TRIANGLES;
    Ok(is_mesh.then_some(MeshMarker { link, visual: number / SHAPES, color, corners, address }))
}
