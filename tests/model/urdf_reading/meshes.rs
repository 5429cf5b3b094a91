//! Meshes are found where packages are documented to be, and one that is missing is a warning.

use super::{FILE, GOOD_INERTIAL, link, read, robot};
use crate::common::scratch;
use catena::scene::{Geometry, PackagePath, robot_from_text, robot_without_meshes};

#[test]
fn packages_are_looked_for_in_the_documented_order() {
    let root = scratch("packages");
    let urdf_folder = root.join("ws/bot_description/urdf");
    let places = [
        ("--package", root.join("given")),
        ("ROS_PACKAGE_PATH", root.join("ros/bot_description")),
        ("AMENT_PREFIX_PATH", root.join("ament/bot_description")),
        ("AMENT_PREFIX_PATH share", root.join("ament/share/bot_description")),
        ("above the URDF", root.join("ws/bot_description")),
    ];
    for folder in places.iter().map(|(_, folder)| folder).chain([&urdf_folder]) {
        std::fs::create_dir_all(folder.join("meshes")).unwrap();
    }
    let packages = PackagePath {
        packages: vec![("bot_description".to_string(), root.join("given"))],
        ros_package_path: vec![root.join("nowhere"), root.join("ros")],
        ament_prefix_path: vec![root.join("ament")],
        ..PackagePath::default()
    };
    let visual = r#"<visual><geometry><mesh filename="package://bot_description/meshes/a.stl" scale="1 2 3"/></geometry></visual>"#;
    let text = robot(visual, "", "");
    let path = urdf_folder.join("bot.urdf");

    let missing = robot_from_text(&text, &path, &packages).unwrap();
    let warning = missing.warnings.iter().find(|warning| warning.message.contains("not found")).unwrap();
    assert_eq!((warning.line, &warning.element), (Some(3), &link("arm")));
    // From the last place to the first, each found file takes precedence over those after it.
    for (what, folder) in places.iter().rev() {
        let mesh = folder.join("meshes/a.stl");
        assert!(warning.message.contains(&mesh.display().to_string()), "{what} is listed in {warning}");
        std::fs::write(&mesh, "solid").unwrap();
        let robot = robot_from_text(&text, &path, &packages).unwrap();
        let Geometry::Mesh(found) = &robot.links[1].visuals[0].geometry else { panic!("a mesh") };
        assert_eq!(found.resolved.as_ref(), Some(&mesh), "{what}");
        assert_eq!(found.scale.as_slice(), [1.0, 2.0, 3.0]);
        assert!(robot.description.contains(&format!("file://{}", mesh.display())), "{}", robot.description);
        assert!(robot.warnings.is_empty());
    }
}

#[test]
fn no_mesh_is_looked_for_where_nobody_needs_it() {
    let folder = scratch("without_meshes");
    std::fs::write(folder.join("a.stl"), "solid").unwrap();
    let visual = |mesh: &str| format!("<visual><geometry><mesh filename=\"{mesh}\"/></geometry></visual>");
    let text = robot(&format!("{GOOD_INERTIAL}{}{}", visual("a.stl"), visual("missing.stl")), "", "");
    let robot = robot_without_meshes(&text, &folder.join(FILE)).unwrap();
    let resolved = robot.links[1].visuals.iter().map(|visual| match &visual.geometry {
        Geometry::Mesh(mesh) => mesh.resolved.clone(),
        other => panic!("{other:?} is no mesh"),
    });
    assert_eq!(resolved.collect::<Vec<_>>(), [None, None]);
    assert!(robot.warnings.is_empty(), "{:?}", robot.warnings);
}

#[test]
fn missing_meshes_are_reported_once_for_each_package() {
    let visual = |name: &str| format!("<visual><geometry><mesh filename=\"{name}\"/></geometry></visual>");
    let visuals: String = ["package://p/a", "package://p/b", "c.stl", "http://x/y.stl", "c.stl"].map(visual).concat();
    let robot = read(&robot(&visuals, "", "")).unwrap();
    let messages: Vec<&str> = robot.warnings.iter().map(|warning| warning.message.as_str()).collect();
    assert_eq!(messages.len(), 3, "{messages:#?}");
    assert!(messages[0].starts_with("the mesh \"package://p/a\" was not found; tried "), "{}", messages[0]);
    assert!(
        messages[0].ends_with("; the same for 1 more of package://p; --package NAME=DIR says where a package is"),
        "{}",
        messages[0]
    );
    assert_eq!(messages[1], "the mesh \"c.stl\" was not found; tried c.stl");
    assert_eq!(messages[2], "the mesh \"http://x/y.stl\" is not a local file (http://)");
}
