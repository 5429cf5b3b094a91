//! Friction of links is read where a file says it for a link, and a message about friction that is not read names the option for it.

use catena::scene::{PackagePath, Robot, Scene, WarningGroup, robot_from_text};
use std::path::Path;

fn read(links: &str) -> Robot {
    let text = format!("<robot name='r'>{links}</robot>");
    robot_from_text(&text, Path::new("r.urdf"), &PackagePath::default()).expect("a robot")
}

const LINK: &str = "<link name='foot'>\n<collision><geometry><sphere radius='1'/></geometry></collision></link>\n";

fn lines(robot: &Robot, group: WarningGroup) -> Vec<String> {
    robot.warnings.iter().filter(|warning| warning.group == group).map(ToString::to_string).collect()
}

#[test]
fn friction_is_taken_from_gazebo_contact_coefficients_and_bullet_and_said_in_one_line() {
    for (say, line) in [
        (format!("{LINK}<gazebo reference='foot'><mu1>0.7</mu1><mu2>0.7</mu2></gazebo>"), 3),
        (format!("{LINK}<gazebo reference='foot'><mu1 value='0.7'/></gazebo>"), 3),
        (
            format!(
                "{LINK}<gazebo reference='foot'><collision><surface><friction><ode><mu>0.7</mu></ode></friction></surface></collision></gazebo>"
            ),
            3,
        ),
        (LINK.replace("</collision>", "<contact_coefficients mu='0.7' kp='1' kd='2'/></collision>"), 2),
        (LINK.replace("</link>", "<contact><lateral_friction value='0.7'/></contact></link>"), 2),
    ] {
        let robot = read(&say);
        assert_eq!(robot.links[0].surface.friction, Some(0.7), "{say}");
        let taken = lines(&robot, WarningGroup::Taken);
        assert_eq!(taken, [format!("r.urdf:{line}: friction of 1 link is taken from the file: 0.7 for \"foot\"")]);
        assert_eq!(lines(&robot, WarningGroup::Odd), [""; 0]);
    }
    let robot = read(LINK);
    assert_eq!((robot.links[0].surface.friction, robot.warnings.len()), (None, 0));
}

#[test]
fn two_directions_have_the_smaller_friction_and_what_is_no_number_names_what_sets_it() {
    let robot = read(&format!("{LINK}<gazebo reference='foot'><mu1>0.9</mu1><mu2>0.4</mu2><kp>1e6</kp></gazebo>"));
    assert_eq!(robot.links[0].surface.friction, Some(0.4));
    let odd = lines(&robot, WarningGroup::Odd);
    assert!(odd.len() == 1 && odd[0].contains("differs by direction"), "{odd:?}");
    assert_eq!(lines(&robot, WarningGroup::Ignored), ["r.urdf:3: ignored: <kp> of <gazebo>"]);
    // A link that says one coefficient itself, and has another by reference.
    let own = LINK.replace("</collision>", "<contact_coefficients mu='1'/></collision>");
    let robot = read(&format!("{own}<gazebo reference='foot'><mu1>0.8</mu1></gazebo>"));
    assert_eq!(robot.links[0].surface.friction, Some(0.8));
    assert_eq!(
        lines(&robot, WarningGroup::Taken),
        ["r.urdf:2: friction of 1 link is taken from the file: 0.8 for \"foot\""]
    );
    for wrong in ["-1", "slippery", "1e9", ""] {
        let robot = read(&format!("{LINK}<gazebo reference='foot'><mu1>{wrong}</mu1></gazebo>"));
        assert_eq!(robot.links[0].surface.friction, None);
        let odd = lines(&robot, WarningGroup::Odd);
        assert!(
            odd.len() == 1 && odd[0].contains("is not read") && odd[0].contains("--set link.NAME.friction"),
            "{odd:?}"
        );
    }
}

#[test]
fn what_is_taken_is_not_ignored_and_a_reference_to_no_link_is_told() {
    let bullet = LINK.replace(
        "</link>",
        "<contact><lateral_friction value='0.2'/><rolling_friction value='0.01'/></contact></link>",
    );
    let own = LINK.replace("</link>", "<contact_coefficients mu='0.2' kp='1'/></link>");
    let surface = "<collision><surface><friction><ode><mu>0.2</mu></ode></friction></surface></collision>";
    let gazebo = format!("{LINK}<gazebo reference='foot'>{surface}<material>Red</material></gazebo>");
    for (say, ignored) in [
        (bullet, "<rolling_friction> of <contact>"),
        (own, "kp=\"...\" of <contact_coefficients>"),
        (gazebo, "<material> of <gazebo>"),
    ] {
        let robot = read(&say);
        assert_eq!(robot.links[0].surface.friction, Some(0.2), "{say}");
        let told = lines(&robot, WarningGroup::Ignored);
        assert!(told.len() == 1 && told[0].ends_with(&format!("ignored: {ignored}")), "{told:?}");
    }
    let robot = read(&format!("{LINK}<gazebo reference='fot'><mu1>0.2</mu1></gazebo>"));
    let said = "r.urdf:3: friction of <gazebo reference=\"fot\"> has no effect: there is no link of this name";
    assert_eq!(lines(&robot, WarningGroup::Odd), [said]);
    // One without a coefficient says no friction.
    let robot = read(&LINK.replace("</link>", "<contact_coefficients kp='1'/></link>"));
    assert!(lines(&robot, WarningGroup::Ignored)[0].ends_with("ignored: <contact_coefficients> of <link>"));
}

#[test]
fn a_number_that_another_one_replaces_is_not_said_to_be_taken() {
    let mass = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";
    let link = |name: &str| LINK.replace("foot", name).replace("\n<collision>", &format!("{mass}<collision>"));
    let rotor = "<actuator name='m'><rotorInertia>0.001</rotorInertia></actuator>";
    let text = format!(
        "{}{}<joint name='j' type='continuous'><parent link='foot'/><child link='toe'/></joint>
         <gazebo reference='foot'><mu1>0.7</mu1></gazebo><gazebo reference='toe'><mu1>0.6</mu1></gazebo>
         <transmission name='t'><joint name='j'/>{rotor}</transmission>",
        link("foot"),
        link("toe")
    );
    let mut scene = Scene::of_robot(read(&text));
    let taken = |scene: &Scene| lines(&scene.robots[0].robot, WarningGroup::Taken);
    assert_eq!(taken(&scene).len(), 2, "{:?}", taken(&scene));
    let set = |scene: &mut Scene, key: &str, number: f64| {
        let parameter = scene.parameter(key).expect("a key");
        scene.set(&[(parameter, number)]).expect("a number");
    };
    set(&mut scene, "link.foot.friction", 0.3);
    let told = taken(&scene);
    assert!(
        told.len() == 2 && told[0].ends_with("friction of 1 link is taken from the file: 0.6 for \"toe\""),
        "{told:?}"
    );
    set(&mut scene, "joint.j.armature", 0.0);
    assert_eq!(taken(&scene).len(), 1);
    set(&mut scene, "link.toe.friction", 0.3);
    assert_eq!(taken(&scene), [""; 0]);
}
