//! STL files, binary and text.
//!
//! ```text
//!     binary   80 bytes, number of triangles (4 bytes), and for each of them 50 bytes:
//!              normal and three corners (12 singles, little endian), 2 bytes that mean nothing
//!     text     solid …, then for each triangle: facet normal x y z, outer loop, vertex x y z (three times), endloop, endfacet; in letters of either case
//! ```
//!
//! Binary files may begin with `solid`, too; what tells them apart is their length. Normals are worked out from the corners, because many
//! files have zeros for them. Source: 3D Systems, StereoLithography Interface Specification, 1989.

use crate::meshes::error::MeshError;
use crate::meshes::surface::{Corner, Part, Surface};
use nalgebra::Point3;

/// Bytes before the triangles, and of a triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

/// Reads an STL file.
pub(super) fn read(data: &[u8]) -> Result<Surface, MeshError> {
    let count = data.get(80..HEAD).map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize);
    let needed = count.and_then(|count| count.checked_mul(TRIANGLE)?.checked_add(HEAD));
    let begins_as_text = data.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let part = match needed {
        // Some writers add something behind the last triangle.
        Some(needed) if data.len() == needed || (!begins_as_text && data.len() > needed) => binary(&data[HEAD..needed]),
        _ if begins_as_text => text(data)?,
        Some(needed) => {
            let given = data.len();
            return Err(MeshError::Damaged(format!(
                "it is cut off: it has {given} bytes, and says that it has {needed}"
            )));
        }
        None => return Err(MeshError::Damaged("it is neither a binary STL file nor one of text".to_string())),
    };
    Ok(Surface { parts: vec![part], has_images: false })
}

fn binary(triangles: &[u8]) -> Part {
    let mut part = Part::with_room(triangles.len() / TRIANGLE);
    for triangle in triangles.chunks_exact(TRIANGLE) {
        let number = |place: usize| {
            let bytes = [0, 1, 2, 3].map(|byte| triangle[4 * place + byte]);
            f64::from(f32::from_le_bytes(bytes))
        };
        let corner = |first: usize| corner([number(first), number(first + 1), number(first + 2)]);
        part.add_triangle([&corner(3), &corner(6), &corner(9)]);
    }
    part
}

fn text(data: &[u8]) -> Result<Part, MeshError> {
    let text = String::from_utf8_lossy(data);
    let (mut part, mut corners) = (Part::default(), Vec::with_capacity(3));
    for (index, line) in text.lines().enumerate() {
        let wrong = |what: &str| MeshError::Line { line: index + 1, what: what.to_string() };
        let mut words = line.split_whitespace();
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("vertex") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let [x, y, z] = numbers[..] else { return Err(wrong("a vertex has three numbers")) };
                corners.push(corner([x, y, z]));
            }
            Some("endloop") => match &corners[..] {
                [a, b, c] => {
                    part.add_triangle([a, b, c]);
                    corners.clear();
                }
                _ => return Err(wrong("the loop before has not three vertices")),
            },
            _ => {}
        }
    }
    if corners.is_empty() { Ok(part) } else { Err(MeshError::Damaged("it is cut off within a facet".to_string())) }
}

fn corner([x, y, z]: [f64; 3]) -> Corner {
    Corner { position: Point3::new(x, y, z), normal: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid s\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2e0 0\nendloop\nendfacet\nendsolid s\n";

    fn encoded(name: &[u8], corners: [[f32; 3]; 3]) -> Vec<u8> {
        let mut data = name.to_vec();
        data.resize(80, 0);
        data.extend_from_slice(&1_u32.to_le_bytes());
        let numbers =
            [[0.0; 3]].iter().chain(&corners).flatten().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>();
        data.extend(numbers);
        data.extend_from_slice(&[0; 2]);
        data
    }

    #[test]
    fn text_and_binary_files_give_the_same_triangles_whatever_the_binary_begins_with() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let expected = Part {
            corners: corners.map(|corner| corner.map(f64::from)).to_vec(),
            normals: vec![[0.0, 0.0, 1.0]; 3],
            color: None,
        };
        let shouted = TEXT.to_uppercase().into_bytes();
        for data in [TEXT.as_bytes().to_vec(), shouted, encoded(b"solid", corners), encoded(b"CAD", corners)] {
            assert_eq!(read(&data).expect("a surface").parts, std::slice::from_ref(&expected));
        }
    }

    #[test]
    fn what_is_cut_off_or_no_number_is_an_error() {
        let binary = encoded(b"CAD", [[0.0; 3]; 3]);
        let refused = |data: &[u8]| read(data).expect_err("no STL file").to_string();
        assert!(refused(&binary[..binary.len() - 1]).contains("133 bytes, and says that it has 134"));
        assert!(refused(b"PNG").contains("neither") && refused(&[]).contains("neither"));
        assert!(refused(TEXT.split("endloop").next().unwrap_or_default().as_bytes()).contains("cut off"));
        assert!(refused(TEXT.replace("vertex 0 0 0\n", "").as_bytes()).starts_with("line 6: "));
        let error = read(TEXT.replace("2e0", "two").as_bytes()).expect_err("no number").to_string();
        assert_eq!(error, "line 6: a vertex has three numbers");
    }
}
