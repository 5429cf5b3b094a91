//! The readers of meshes: the same tetrahedron in every format, and files that lie.

use catena::meshes::{MeshError, Surface, read_surface};

const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn read(ending: &str, text: &str) -> Result<Surface, MeshError> {
    read_surface(ending, text.as_bytes(), &|_| None)
}

/// The corners of all triangles, one after the other.
fn corners(surface: &Surface) -> Vec<[f64; 3]> {
    surface.parts.iter().flat_map(|part| part.corners.clone()).collect()
}

fn expected() -> Vec<[f64; 3]> {
    FACES.iter().flatten().map(|&k| CORNERS[k]).collect()
}

fn binary_stl(header: &[u8]) -> Vec<u8> {
    let mut data = header.to_vec();
    data.resize(80, 0);
    data.extend(4u32.to_le_bytes());
    for face in FACES {
        data.extend([0; 12]);
        data.extend(face.iter().flat_map(|&k| CORNERS[k]).flat_map(|x| (x as f32).to_le_bytes()));
        data.extend([0; 2]);
    }
    data
}

fn collada(unit: &str, node: &str) -> String {
    let positions: Vec<String> = CORNERS.iter().flatten().map(f64::to_string).collect();
    let indices: Vec<String> = FACES.iter().flatten().flat_map(|k| [k.to_string(), "0".to_string()]).collect();
    format!(
        r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"><asset>{unit}<up_axis>Y_UP</up_axis></asset>
        <library_effects><effect id="paint"><profile_COMMON><technique><phong>
          <emission><color>1 1 1 1</color></emission><diffuse><color>0.8 0.4 0.2 1</color></diffuse>
        </phong></technique></profile_COMMON></effect></library_effects>
        <library_materials><material id="red"><instance_effect url="#paint"/></material></library_materials>
        <library_geometries><geometry id="g"><mesh>
          <source id="p"><float_array count="12">{}</float_array></source>
          <source id="n"><float_array count="3">0 0 1</float_array></source>
          <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
          <polylist material="symbol" count="4"><input semantic="VERTEX" source="#v" offset="0"/>
            <input semantic="NORMAL" source="#n" offset="1"/><vcount>3 3 3 3</vcount><p>{}</p></polylist>
        </mesh></geometry></library_geometries>
        <library_visual_scenes><visual_scene id="s">{node}</visual_scene></library_visual_scenes>
        <scene><instance_visual_scene url="#s"/></scene></COLLADA>"##,
        positions.join(" "),
        indices.join(" ")
    )
}

const INSTANCE: &str = r##"<instance_geometry url="#g"><bind_material><technique_common>
    <instance_material symbol="symbol" target="#red"/></technique_common></bind_material></instance_geometry>"##;

#[test]
fn stl_is_read_as_text_and_as_bytes_also_where_these_begin_like_text() {
    let vertex = |corner: [f64; 3]| format!("vertex {} {} {}\n", corner[0], corner[1], corner[2]);
    let facet = |face: [usize; 3]| {
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", face.map(|k| vertex(CORNERS[k])).concat())
    };
    let text = format!("solid a\n{}endsolid a\n", FACES.map(facet).concat());
    assert_eq!(corners(&read("STL", &text).expect("text")), expected());
    for header in [&b"made by a test"[..], b"solid that is none"] {
        let surface = read_surface("stl", &binary_stl(header), &|_| None).expect("bytes");
        assert_eq!(corners(&surface), expected());
        assert_eq!(surface.parts[0].color, None);
    }
}

#[test]
fn obj_has_polygons_relative_corners_and_the_colours_of_its_materials() {
    let text = "mtllib paint.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1/1/1 2/2/2 3/3/3 4//4\nusemtl glass\nf -4 -3 -2\n";
    let paint = b"newmtl red\nKd 0.8 0.1 0.1\nnewmtl glass\nd 0.5\nKd 0 0 1\nd 0.25\n";
    let neighbour = |name: &str| (name == "paint.mtl").then(|| paint.to_vec());
    let surface = read_surface("obj", text.as_bytes(), &neighbour).expect("a mesh");
    let (square, triangle) = (&surface.parts[0], &surface.parts[1]);
    assert_eq!((square.corners.len(), square.color), (6, Some([0.8, 0.1, 0.1, 1.0])));
    assert_eq!((triangle.corners.len(), triangle.color), (3, Some([0.0, 0.0, 1.0, 0.25])));
    assert_eq!(triangle.corners, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    // Without the file of materials the shape is the same and the colour is not known.
    let plain = read("obj", text).expect("a mesh");
    assert_eq!((corners(&plain), plain.parts[0].color), (corners(&surface), None));
}

#[test]
fn collada_has_its_nodes_its_unit_and_its_colours_and_no_up_axis() {
    let plain = read("dae", &collada("", &format!("<node>{INSTANCE}</node>"))).expect("a mesh");
    assert_eq!(corners(&plain), expected(), "Y_UP turns nothing, as in ROS");
    assert_eq!(plain.parts[0].color, Some([0.8, 0.4, 0.2, 1.0]), "the diffuse colour, not the emission");
    // Turned about z by 90 degrees after a shift along x, in millimetres: p = 0.001 · R (v + x).
    let node = format!(
        "<node><rotate>0 0 1 90</rotate><node><matrix>1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1</matrix>{INSTANCE}</node></node>"
    );
    let moved = read("dae", &collada(r#"<unit name="millimeter" meter="0.001"/>"#, &node)).expect("a mesh");
    for (found, corner) in corners(&moved).iter().zip(expected()) {
        let [x, y, z] = corner;
        for (found, wanted) in found.iter().zip([-0.001 * y, 0.001 * (x + 1.0), 0.001 * z]) {
            // Some roundings of numbers of the size of millimetres.
            assert!((found - wanted).abs() < 1e-17, "{found} {wanted}");
        }
    }
}

#[test]
fn what_is_no_mesh_is_an_error_that_says_why_and_never_a_panic() {
    let cases = [
        ("step", "anything", "\"step\""),
        ("stl", "neither", "neither a binary"),
        ("stl", "solid\nvertex 1 2\n", "line 2"),
        ("stl", "solid\nendsolid\n", "no triangle"),
        ("obj", "v 1 2\n", "line 1"),
        ("obj", "v 0 0 0\nf 1 2 3\n", "line 2"),
        ("obj", "v 0 0 nan\nv 0 0 0\nv 1 0 0\nf 1 2 3\n", "not finite"),
        ("dae", "<COLLADA>", "never closed"),
        ("dae", &collada("", "<node><matrix>1 2 3</matrix></node>"), "<matrix>: it has 3 numbers"),
        ("dae", &collada("", r##"<node id="n"><instance_node url="#n"/></node>"##), "no triangle"),
    ];
    for (ending, text, said) in cases {
        let error = read(ending, text).expect_err(said).to_string();
        assert!(error.contains(said), "{error:?} should have {said:?}");
    }
    let whole = binary_stl(b"");
    let dae = collada("", &format!("<node>{INSTANCE}</node>"));
    for part in 0..50 {
        // Whatever comes of a part, it is an answer.
        let _ = read_surface("stl", &whole[..whole.len() * part / 50], &|_| None);
        let _ = read("dae", &dae[..dae.len() * part / 50]);
    }
}
