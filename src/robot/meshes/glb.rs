//! Writes a surface as GLB: glTF 2.0 in one file, which viewers read without guessing.
//!
//! ```text
//!     "glTF"  2  length | length "JSON" description, padded with spaces | length "BIN\0" numbers, padded with zeros
//! ```
//!
//! All numbers are little endian, four bytes each. Each part is a primitive: a material with its colour, and positions and normals of its corners as
//! singles. Each pair is stored once, and a triangle is three of their numbers. glTF says that y points up. The corners stay in the axes of the mesh
//! file all the same, because a URDF places meshes in these axes. Colours of glTF are linear; mesh files and URDFs give them as screens show them
//! (sRGB). Source: Khronos, glTF 2.0 specification, sections 3.6, 3.7, 3.9 and 4.

use crate::meshes::surface::{Part, Surface};
use serde_json::{Value, json};
use std::collections::HashMap;

/// The kinds of things that a description numbers: singles, triangles, and bytes for corners.
const SINGLE: u32 = 5126;
const NUMBER: u32 = 5125;
const TRIANGLES: u32 = 4;
const CORNERS: u32 = 34962;
const INDICES: u32 = 34963;

/// The bytes of a GLB file of a surface; with `color` (red, green, blue, opacity) all of it has this colour.
pub fn glb(surface: &Surface, color: Option<[f32; 4]>) -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (mut primitives, mut materials) = (Vec::new(), Vec::new());
    for part in surface.parts.iter().filter(|part| !part.corners.is_empty()) {
        let shared = Shared::of(part);
        let position = buffer.add_triples(&shared.corners);
        let [low, high] = bounds(&shared.corners);
        (buffer.accessors[position]["min"], buffer.accessors[position]["max"]) = (json!(low), json!(high));
        let normal = buffer.add_triples(&shared.normals);
        let indices = buffer.add(&shared.indices, INDICES, (NUMBER, "SCALAR", shared.indices.len()));
        let attributes = json!({"POSITION": position, "NORMAL": normal});
        let material_number = materials.len();
        primitives.push(
            json!({"attributes": attributes, "indices": indices, "material": material_number, "mode": TRIANGLES}),
        );
        materials.push(material(color.unwrap_or_else(|| part.shown_color())));
    }
    let Buffer { numbers, views, accessors } = buffer;
    let description = json!({
        "asset": {"version": "2.0", "generator": "catena"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}],
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": numbers.len()}],
    });
    let mut text = description.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut file = b"glTF".to_vec();
    let length = 12 + 8 + text.len() + 8 + numbers.len();
    for number in [2, length as u32, text.len() as u32] {
        file.extend_from_slice(&number.to_le_bytes());
    }
    file.extend_from_slice(b"JSON");
    file.extend_from_slice(&text);
    file.extend_from_slice(&(numbers.len() as u32).to_le_bytes());
    file.extend_from_slice(b"BIN\0");
    file.extend_from_slice(&numbers);
    file
}

/// The numbers of a file, and how it describes them.
#[derive(Default)]
struct Buffer {
    numbers: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds numbers of four bytes for a purpose: `count` elements of a kind of number and a type. Returns the number of their accessor.
    fn add(&mut self, bits: &[u32], target: u32, (kind, element, count): (u32, &str, usize)) -> usize {
        let offset = self.numbers.len();
        self.numbers.extend(bits.iter().flat_map(|bits| bits.to_le_bytes()));
        let length = self.numbers.len() - offset;
        self.views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length, "target": target}));
        let view = self.views.len() - 1;
        self.accessors.push(json!({"bufferView": view, "componentType": kind, "count": count, "type": element}));
        self.accessors.len() - 1
    }

    fn add_triples(&mut self, triples: &[[f32; 3]]) -> usize {
        let bits: Vec<u32> = triples.iter().flatten().map(|number| number.to_bits()).collect();
        self.add(&bits, CORNERS, (SINGLE, "VEC3", triples.len()))
    }
}

/// The corners of a part, each position with its normal once.
#[derive(Default)]
struct Shared {
    corners: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Three a triangle.
    indices: Vec<u32>,
}

impl Shared {
    fn of(part: &Part) -> Self {
        let mut shared = Shared::default();
        let mut known: HashMap<[u32; 6], u32> = HashMap::new();
        for (corner, normal) in part.corners.iter().zip(&part.normals) {
            let corner = corner.map(|coordinate| coordinate as f32);
            let ([x, y, z], [u, v, w]) = (corner.map(f32::to_bits), normal.map(f32::to_bits));
            let index = *known.entry([x, y, z, u, v, w]).or_insert_with(|| {
                shared.corners.push(corner);
                shared.normals.push(*normal);
                shared.corners.len() as u32 - 1
            });
            shared.indices.push(index);
        }
        shared
    }
}

/// The smallest and largest coordinates of corners.
fn bounds(corners: &[[f32; 3]]) -> [[f32; 3]; 2] {
    let start = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    corners.iter().fold(start, |[low, high], corner| {
        [[0, 1, 2].map(|axis| low[axis].min(corner[axis])), [0, 1, 2].map(|axis| high[axis].max(corner[axis]))]
    })
}

fn material([r, g, b, a]: [f32; 4]) -> Value {
    let [r, g, b] = [r, g, b].map(linear);
    let mode = if a < 1.0 { "BLEND" } else { "OPAQUE" };
    json!({
        "pbrMetallicRoughness": {"baseColorFactor": [r, g, b, a], "metallicFactor": 0.0, "roughnessFactor": 0.8},
        "alphaMode": mode,
        "doubleSided": true,
    })
}

/// The linear light of a part of an sRGB colour (IEC 61966-2-1).
fn linear(value: f32) -> f32 {
    let value = value.clamp(0.0, 1.0);
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangles of the first part, read as the specification describes it.
    fn read(file: &[u8]) -> (Value, Vec<[f32; 3]>) {
        let number = |at: usize| u32::from_le_bytes([file[at], file[at + 1], file[at + 2], file[at + 3]]) as usize;
        assert_eq!((&file[..4], number(4), number(8)), (&b"glTF"[..], 2, file.len()));
        let text = number(12);
        assert_eq!((&file[16..20], text % 4), (&b"JSON"[..], 0));
        let description: Value = serde_json::from_slice(&file[20..20 + text]).expect("JSON");
        let start = 20 + text + 8;
        assert_eq!((number(start - 8), &file[start - 4..start]), (file.len() - start, &b"BIN\0"[..]));
        let place = |accessor: &Value| {
            let view = &description["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
            start + view["byteOffset"].as_u64().expect("an offset") as usize
        };
        let primitive = &description["meshes"][0]["primitives"][0];
        let accessor = |what: &Value| &description["accessors"][what.as_u64().expect("a number") as usize];
        let (position, indices) = (accessor(&primitive["attributes"]["POSITION"]), accessor(&primitive["indices"]));
        let single = |place: usize| f32::from_bits(number(place) as u32);
        let count = indices["count"].as_u64().expect("a count") as usize;
        let corner = |index: usize| [0, 1, 2].map(|axis| single(place(position) + 12 * index + 4 * axis));
        let corners = (0..count).map(|index| corner(number(place(indices) + 4 * index))).collect();
        (description, corners)
    }

    #[test]
    fn a_reader_finds_the_corners_their_bounds_and_the_colour() {
        let [a, b, c, d] = [[0.0, 0.5, -1.0], [1.0, 2.0, 3.0], [4.0, -5.0, 6.0], [1.0, 1.0, 1.0]];
        let corners = vec![a, b, c, c, b, d];
        let part = Part {
            corners: corners.iter().map(|corner| corner.map(f64::from)).collect(),
            normals: vec![[0.0, 0.0, 1.0]; 6],
            color: Some([1.0, 0.5, 0.0, 0.25]),
        };
        let surface = Surface { parts: vec![part, Part::default()], has_images: false };
        let (description, found) = read(&glb(&surface, None));
        assert_eq!(found, corners);
        assert_eq!(description["accessors"][0]["count"], 4, "shared corners are there once");
        assert_eq!(description["accessors"][0]["min"], json!([0.0, -5.0, -1.0]));
        assert_eq!(description["accessors"][0]["max"], json!([4.0, 2.0, 6.0]));
        assert_eq!(description["meshes"][0]["primitives"].as_array().map(Vec::len), Some(1), "no part without corners");
        let color = &description["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"];
        // 0.5 of sRGB is 0.2140 of the light (IEC 61966-2-1).
        assert!((color[1].as_f64().expect("green") - 0.2140).abs() < 1e-4, "{color}");
        assert_eq!((&color[0], &color[3]), (&json!(1.0), &json!(0.25)));
        let (white, _) = read(&glb(&surface, Some([1.0; 4])));
        assert_eq!(white["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"], json!([1.0, 1.0, 1.0, 1.0]));
    }
}
