//! A start outside limits is moved in by the least motion in the metric of the mass matrix; what cannot be is named.

use catena::instant::start::assembly::{AssemblyError, assemble};
use catena::mechanism::motion::state::State;
use catena::model::{Left, Model, ModelOptions};
use catena::scene::{PackagePath, robot_from_text};
use std::path::Path;

/// Two rods of 1 m and 1 kg with centres in their middles and moments of 0.1 kg m² about them, on hinges about y.
fn arm(shoulder: &str, elbow: &str) -> Model {
    let inertial = "<inertial><origin xyz='0 0 -0.5'/><mass value='1'/>\
         <inertia ixx='0.1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'/></inertial>";
    let text = format!(
        "<robot name='arm'><link name='base'/><link name='upper'>{inertial}</link><link name='lower'>{inertial}</link>\
         <joint name='shoulder' type='revolute'><parent link='base'/><child link='upper'/><axis xyz='0 1 0'/>{shoulder}</joint>\
         <joint name='elbow' type='revolute'><parent link='upper'/><child link='lower'/><origin xyz='0 0 -1'/>\
         <axis xyz='0 1 0'/>{elbow}</joint></robot>"
    );
    let robot = robot_from_text(&text, Path::new("arm.urdf"), &PackagePath::default()).expect("a robot");
    Model::new(robot, &ModelOptions::default()).expect("a model")
}

fn limit(lower: f64, upper: f64) -> String {
    format!("<limit lower='{lower}' upper='{upper}' effort='0' velocity='0'/>")
}

fn at(model: &Model, position: [f64; 2]) -> State {
    let mut state = State::zero(&model.mechanism);
    state.position.copy_from_slice(&position);
    state
}

#[test]
fn an_arm_is_moved_in_by_the_least_motion_in_the_metric_of_its_mass_matrix() {
    // H₁₁ = 2 (0.1 + 0.25) + 1 + cos q₂, H₁₂ = 0.1 + 0.25 + ½ cos q₂, H₂₂ = 0.1 + 0.25.
    let mass = |elbow: f64| (1.7 + elbow.cos(), 0.35 + 0.5 * elbow.cos(), 0.35);
    // The shoulder is 0.3 too far, and the elbow turns back while it is brought in: d₂ = −d₁ H₁₂/H₂₂.
    let model = arm(&limit(-1.0, 1.0), &limit(-3.0, 3.0));
    let mut state = at(&model, [1.3, 0.4]);
    let correction = assemble(&model.mechanism, &mut state).expect("moved in");
    let (_, coupling, own) = mass(0.4);
    assert_eq!(state.position[0], 1.0);
    assert!((state.position[1] - (0.4 + 0.3 * coupling / own)).abs() < 1e-15, "{:?}", state.position);
    assert!((correction.position - 0.3 * coupling / own).abs() < 1e-15, "{correction:?}");
    // The elbow is 2.5 rad too far, further than one round of closing loops goes: d₁ = −d₂ H₁₂/H₁₁.
    let mut state = at(&model, [0.5, -5.5]);
    assemble(&model.mechanism, &mut state).expect("moved in");
    let (whole, coupling, _) = mass(-5.5);
    assert_eq!(state.position[1], -3.0);
    assert!((state.position[0] - (0.5 - 2.5 * coupling / whole)).abs() < 1e-15, "{:?}", state.position);
    // Where the other joint would leave its own limits it stops there.
    let model = arm(&limit(-1.0, 1.0), &limit(-0.1, 0.41));
    let mut state = at(&model, [1.3, 0.4]);
    assemble(&model.mechanism, &mut state).expect("moved in");
    assert_eq!(state.position, [1.0, 0.41]);
    // Locked joints are put where they are locked, at rest, as fixed joints are: the others stay.
    let model = arm(&limit(0.25, 0.25), "");
    let mut state = at(&model, [0.0, 0.3]);
    state.velocity.copy_from_slice(&[2.0, 1.0]);
    assemble(&model.mechanism, &mut state).expect("moved in");
    assert_eq!((state.position.as_slice(), state.velocity.as_slice()), (&[0.25, 0.3][..], &[0.0, 1.0][..]));
}

#[test]
fn what_is_inside_or_on_a_limit_is_left_alone_with_its_velocity_and_so_is_all_without_limits() {
    let mut model = arm(&limit(-1.0, 1.0), &limit(-3.0, 3.0));
    for position in [[1.0, 0.3], [-1.0, 3.0], [0.2, 0.1]] {
        let mut state = at(&model, position);
        state.velocity.copy_from_slice(&[5.0, 7.0]);
        let correction = assemble(&model.mechanism, &mut state).expect("inside");
        assert_eq!((correction.position, correction.velocity), (0.0, 0.0));
        assert_eq!((state.position.as_slice(), state.velocity.as_slice()), (&position[..], &[5.0, 7.0][..]));
    }
    model.without(&[Left::Limits]);
    let mut state = at(&model, [9.0, -9.0]);
    assemble(&model.mechanism, &mut state).expect("anywhere");
    assert_eq!(state.position, [9.0, -9.0]);
}

#[test]
fn followers_and_leaders_of_mimic_relations_are_moved_in_together() {
    let mimic = |range: String| format!("{range}<mimic joint='shoulder' multiplier='-2' offset='0.1'/>");
    // The follower is at −1.9 and may not go below −0.9: the leader comes along to 0.5.
    let model = arm(&limit(-1.0, 1.0), &mimic(limit(-0.9, 3.0)));
    for position in [[1.0, -1.9], [2.7, 0.0], [0.8, -1.2]] {
        let mut state = at(&model, position);
        assemble(&model.mechanism, &mut state).expect("moved in");
        let [leader, follower] = state.position[..] else { panic!("two joints") };
        assert!((leader - 0.5).abs() < 1e-9 && (follower + 0.9).abs() < 1e-9, "{position:?}: {leader} {follower}");
        assert!((follower + 2.0 * leader - 0.1).abs() < 1e-15, "{position:?}: {leader} {follower}");
    }
    // Between 0.4 and 1 the leader puts the follower between −1.9 and −0.7.
    let model = arm(&limit(0.4, 1.0), &mimic(limit(-0.5, 3.0)));
    let error = assemble(&model.mechanism, &mut at(&model, [0.5, -0.9])).expect_err("no place");
    assert!(matches!(&error, AssemblyError::Limited { joint, .. } if joint == "elbow"), "{error}");
    let text = error.to_string();
    assert!(text.contains("joint \"elbow\" is 4.000e-1 rad outside its limits"), "{text}");
}

#[test]
fn what_is_left_out_is_cleared_and_the_rest_stays() {
    let more = "<dynamics damping='0.3' friction='0.2'/>";
    let model = arm(&format!("{}{more}", limit(-1.0, 1.0)), more);
    let left = |what: &[Left]| {
        let mut model = model.clone();
        model.without(what);
        let nonsmooth = &model.mechanism.nonsmooth;
        (nonsmooth.limits.len(), nonsmooth.friction.len(), model.mechanism.forces.joint_dampers.len())
    };
    assert_eq!(left(&[]), (1, 2, 2));
    assert_eq!(left(&[Left::Limits]), (0, 2, 2));
    assert_eq!(left(&[Left::Friction, Left::Motors]), (1, 0, 2));
    assert_eq!(left(&[Left::Damping, Left::Damping, Left::Contact]), (1, 2, 0));
    for left in Left::ALL {
        assert_eq!(left.name().parse(), Ok(left));
    }
    let unknown = "gravity".parse::<Left>().unwrap_err().to_string();
    assert!(
        unknown.contains("\"gravity\"") && unknown.contains("limits, friction, damping, motors, contact"),
        "{unknown}"
    );
}
