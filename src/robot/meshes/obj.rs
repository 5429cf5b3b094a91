//! Wavefront OBJ files, with the colours of the materials in the files they name.
//!
//! ```text
//!     v x y z            a corner               f a b c …    a polygon of corners; each is v, v/t, v//n or v/t/n, numbered from 1,
//!     vn x y z           a normal                            or from −1 backwards
//!     usemtl name        the material from here on           mtllib file    where materials are
//!     newmtl name        in that file: a material, with Kd r g b (diffuse colour) and d a (opacity) or Tr 1 − a
//!     \                  at the end of a line: it goes on in the next
//! ```
//!
//! Source: Wavefront, Advanced Visualizer Manual, appendix B1.

use crate::meshes::error::MeshError;
use crate::meshes::surface::{Corner, Surface};
use nalgebra::{Point3, Vector3};
use std::borrow::Cow;
use std::collections::HashMap;

/// Reads an OBJ file; materials that cannot be read leave their parts without colour.
pub(super) fn read(data: &[u8], neighbour: &dyn Fn(&str) -> Option<Vec<u8>>) -> Result<Surface, MeshError> {
    let text = String::from_utf8_lossy(data);
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let (mut materials, mut color) = (HashMap::new(), None);
    let mut surface = Surface::default();
    for (number, line) in joined_lines(&text) {
        let wrong = |what: &str| MeshError::Line { line: number, what: what.to_string() };
        let line = line.split('#').next().unwrap_or_default().trim();
        let (kind, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match kind {
            "v" => positions.push(Point3::from(triple(rest).ok_or_else(|| wrong("a vertex has three numbers"))?)),
            "vn" => normals.push(Vector3::from(triple(rest).ok_or_else(|| wrong("a normal has three numbers"))?)),
            "f" => {
                let corner = |word: &str| {
                    let mut numbers = word.split('/');
                    let position = *numbered(&positions, numbers.next()?)?;
                    let normal = numbers.nth(1).filter(|word| !word.is_empty()).map(|word| numbered(&normals, word));
                    Some(Corner { position, normal: normal.flatten().copied() })
                };
                let corners: Option<Vec<Corner>> = rest.split_whitespace().map(corner).collect();
                let corners = corners.ok_or_else(|| wrong("a polygon has a corner that does not exist"))?;
                if corners.len() < 3 {
                    return Err(wrong("a polygon has three corners or more"));
                }
                surface.part(color).add_polygon(&corners);
            }
            "mtllib" => {
                let library = neighbour(rest.trim()).unwrap_or_default();
                surface.has_images |= read_materials(&String::from_utf8_lossy(&library), &mut materials);
            }
            "usemtl" => color = materials.get(rest.trim()).copied(),
            _ => {}
        }
    }
    Ok(surface)
}

/// The lines with their numbers, from 1 on; one that ends with `\` goes on in the next.
fn joined_lines(text: &str) -> Vec<(usize, Cow<'_, str>)> {
    let mut lines: Vec<(usize, Cow<str>)> = Vec::new();
    let mut goes_on = false;
    for (index, line) in text.lines().enumerate() {
        // Comments end with their lines.
        let cut = line.trim_end().strip_suffix('\\').filter(|cut| !cut.contains('#'));
        match lines.last_mut().filter(|_| goes_on) {
            Some((_, first)) => {
                let first = first.to_mut();
                first.push(' ');
                first.push_str(cut.unwrap_or(line));
            }
            None => lines.push((index + 1, Cow::Borrowed(cut.unwrap_or(line)))),
        }
        goes_on = cut.is_some();
    }
    lines
}

fn triple(text: &str) -> Option<[f64; 3]> {
    let mut words = text.split_whitespace().map(|word| word.parse().ok());
    Some([words.next()??, words.next()??, words.next()??])
}

/// The element with this number, from 1 on, or from −1 backwards.
fn numbered<'a, T>(all: &'a [T], word: &str) -> Option<&'a T> {
    let number: i64 = word.parse().ok()?;
    let place = if number < 0 { number + all.len() as i64 } else { number - 1 };
    all.get(usize::try_from(place).ok()?)
}

/// Adds the colours of the materials; returns whether any of them has an image.
fn read_materials(text: &str, materials: &mut HashMap<String, [f32; 4]>) -> bool {
    let (mut name, mut has_images) = (String::new(), false);
    for line in text.lines() {
        let (kind, rest) = line.trim().split_once(char::is_whitespace).unwrap_or((line, ""));
        let opacity = || rest.trim().parse::<f32>().ok();
        match kind {
            "newmtl" => name = rest.trim().to_string(),
            "Kd" => {
                if let Some([r, g, b]) = triple(rest).map(|color| color.map(|part| part as f32)) {
                    let alpha = materials.get(&name).map_or(1.0, |known| known[3]);
                    materials.insert(name.clone(), [r, g, b, alpha]);
                }
            }
            "d" | "Tr" => {
                if let Some(value) = opacity() {
                    let known = materials.entry(name.clone()).or_insert([1.0; 4]);
                    known[3] = if kind == "d" { value } else { 1.0 - value };
                }
            }
            "map_Kd" => has_images = true,
            _ => {}
        }
    }
    has_images
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_are_cut_into_triangles_and_numbered_from_either_end() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 2\nf 1//1 2//1 3//1 4//1\nf -4 -3 -2\n";
        let surface = read(text.as_bytes(), &|_| None).expect("a surface");
        let corners = &surface.parts[0].corners;
        assert_eq!(corners[..3], corners[6..]);
        assert_eq!(corners[3..6], [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        assert!(surface.parts[0].normals.iter().all(|normal| *normal == [0.0, 0.0, 1.0]));
        let error = read(b"v 0 0 0\nf 1 2 3\n", &|_| None).expect_err("no corner 2").to_string();
        assert_eq!(error, "line 2: a polygon has a corner that does not exist");
    }

    #[test]
    fn a_line_that_ends_with_a_backslash_goes_on_in_the_next() {
        let plain = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", &|_| None).expect("a surface");
        let joined =
            read(b"# C:\\\nv 0 0 \\\n0\nv 1\\ \r\n0\\\n0\nv 1 1 0\nf 1 \\\n 2 \\\n3\n", &|_| None).expect("a surface");
        assert_eq!(plain.parts, joined.parts);
        let error = read(b"v 0 \\\n0 0\nf 1 \\\n2 3\n", &|_| None).expect_err("no corner 2").to_string();
        assert_eq!(error, "line 3: a polygon has a corner that does not exist");
    }

    #[test]
    fn materials_give_colours_and_opacity() {
        let mut materials = HashMap::new();
        read_materials("newmtl a\nd 0.5\nKd 1 0 0.25\nnewmtl b\nKd 0 1 0\nTr 0.25\n", &mut materials);
        assert_eq!(materials["a"], [1.0, 0.0, 0.25, 0.5]);
        assert_eq!(materials["b"], [0.0, 1.0, 0.0, 0.75]);
    }
}
