//! Rotors of a URDF are read from transmissions and from `<dynamics armature>`; a message about one that is not read names the key for it.

use catena::model::{Model, ModelOptions};
use catena::scene::{PackagePath, Robot, WarningGroup, robot_from_text};
use std::path::Path;

fn read(more: &str, kind: &str, dynamics: &str) -> Robot {
    let text = format!(
        "<robot name='r'><link name='base'/><link name='arm'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' \
         ixz='0' iyz='0'/></inertial></link><joint name='hip' type='{kind}'><parent link='base'/><child link='arm'/>{dynamics}\
         </joint>{more}</robot>"
    );
    robot_from_text(&text, Path::new("r.urdf"), &PackagePath::default()).expect("a robot")
}

fn transmission(inside: &str) -> String {
    format!("<transmission name='t'><type>transmission_interface/SimpleTransmission</type>{inside}</transmission>")
}

fn lines(robot: &Robot, group: WarningGroup) -> Vec<String> {
    robot.warnings.iter().filter(|warning| warning.group == group).map(ToString::to_string).collect()
}

/// The armature of the only joint of the mechanism.
fn simulated(robot: Robot) -> f64 {
    let model = Model::new(robot, &ModelOptions::default()).expect("a model");
    model.mechanism.bodies[0].joint.armature
}

#[test]
fn the_armature_of_a_joint_is_the_inertia_of_its_rotor_times_the_square_of_the_reduction() {
    for (inside, armature) in [
        (
            "<joint name='hip'/><actuator name='m'><mechanicalReduction>-50</mechanicalReduction><rotorInertia>2e-4</rotorInertia></actuator>",
            0.5,
        ),
        ("<joint name='hip'/><actuator name='m'><gear_ratio value='50'/><rotor_inertia value='2e-4'/></actuator>", 0.5),
        (
            "<joint name='hip'><mechanicalReduction>3</mechanicalReduction></joint><actuator name='m'><motorInertia>2</motorInertia></actuator>",
            18.0,
        ),
        ("<joint name='hip'/><actuator name='m'><rotorInertia>0.25</rotorInertia></actuator>", 0.25),
    ] {
        let robot = read(&transmission(inside), "continuous", "");
        let said = robot.joints[0].armature.expect("a rotor");
        assert!((said - armature).abs() < 1e-15 * armature, "{inside}: {said}");
        assert_eq!(lines(&robot, WarningGroup::Taken).len(), 1, "{inside}");
        assert_eq!(
            (lines(&robot, WarningGroup::Odd), lines(&robot, WarningGroup::Ignored)),
            (vec![], vec![]),
            "{inside}"
        );
        assert_eq!(simulated(robot), said);
    }
    let robot = read("", "continuous", "<dynamics armature='0.3'/>");
    assert_eq!(simulated(robot), 0.3);
}

#[test]
fn rotors_that_cannot_be_read_or_simulated_are_told_in_one_line() {
    for (inside, reason) in [
        (
            "<joint name='hip'/><joint name='knee'/><actuator name='m'><rotorInertia>1</rotorInertia></actuator>",
            "it drives 2 joints",
        ),
        (
            "<joint name='knee'/><actuator name='m'><rotorInertia>1</rotorInertia></actuator>",
            "there is no joint \"knee\"",
        ),
        ("<joint name='hip'/><actuator name='m'><rotorInertia>-1</rotorInertia></actuator>", "an inertia of -1 kg m²"),
        (
            "<joint name='hip'/><actuator name='m'><rotorInertia>1</rotorInertia></actuator><actuator name='n'><rotorInertia>2</rotorInertia></actuator>",
            "it has more than one <rotorInertia>",
        ),
    ] {
        let robot = read(&transmission(inside), "continuous", "");
        let told = lines(&robot, WarningGroup::Odd);
        assert!(told.len() == 1 && told[0].contains(reason) && told[0].contains("armature"), "{inside}: {told:?}");
        assert_eq!(robot.joints[0].armature, None);
    }
    // A transmission without a rotor says nothing about the motion.
    let without =
        transmission("<joint name='hip'/><actuator name='m'><mechanicalReduction>50</mechanicalReduction></actuator>");
    let robot = read(&without, "continuous", "");
    assert_eq!((lines(&robot, WarningGroup::Ignored).len(), robot.joints[0].armature), (1, None));
    let model =
        Model::new(read("", "spherical", "<dynamics armature='0.3'/>"), &ModelOptions::default()).expect("a model");
    assert!(model.warning_lines().any(|line| line.contains("its armature is not simulated")));
}
