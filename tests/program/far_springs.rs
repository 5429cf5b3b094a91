//! Springs with an end far outside its body: the motion of a spring nearby with no rest length, in as few steps, and warnings of what rounding hides.
//!
//! A spring along the axis of a pin, with a far end that turns with the pin, acts across the axis as one of no rest length between the feet of
//! its ends: `T u = k (1 − ℓ₀/ℓ) d`, with an `ℓ₀/ℓ` next to nothing.

use crate::common::command::{run, text};
use crate::common::scratch;
use serde_json::Value;
use std::path::Path;

/// The flyball governor, with one spring that reaches `distance` along the axes of the pins, from the slider or to it.
fn governor(distance: &str, rest_and_damping: [&str; 2], to_slider: bool) -> String {
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/parts/flyball_governor.urdf");
    let slider = format!("{{ link = \"slider\", position = [-0.05, {distance}, 0] }}");
    let arm = String::from("{ link = \"left_arm\", position = [0, 0, 0.5] }");
    let [a, b] = if to_slider { [arm, slider] } else { [slider, arm] };
    let [rest, damping] = rest_and_damping;
    format!(
        "[scene]
name = \"governor\"

[[robot]]
name = \"governor\"
urdf = {urdf:?}
positions = {{ slide = 0.5, right_pin = 2.0943951023931953, left_pin = 2.0943951023931953 }}
velocities = {{ turn = 6.283185307179586 }}

[[spring]]
name = \"right\"
a = {{ link = \"slider\", position = [0.05, 0, 0] }}
b = {{ link = \"right_arm\", position = [0, 0, 0.5] }}
stiffness = 8e5
damping = 4e4
rest_length = 0.5

[[spring]]
name = \"left\"
a = {a}
b = {b}
stiffness = 8e5
damping = {damping}
rest_length = {rest}
"
    )
}

/// An arm that slides on a hub about a vertical axis, in a plane, and a spring across the slide that reaches `distance`.
fn hub(distance: &str, rest: &str) -> String {
    format!(
        "[scene]
name = \"hub\"

[[robot]]
name = \"hub\"
urdf = \"hub.urdf\"
velocities = {{ turn = 3.0 }}

[[spring]]
name = \"far\"
a = {{ link = \"hub\", position = [0.1, {distance}, 0] }}
b = {{ link = \"arm\", position = [0, 0.5, 0] }}
stiffness = 800.0
rest_length = {rest}
"
    )
}

const HUB: &str = r#"<robot name="hub">
  <link name="base"/>
  <link name="hub"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="hub"/><axis xyz="0 0 1"/></joint>
  <link name="arm"><inertial><origin xyz="0 0.25 0"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="slide" type="prismatic"><origin xyz="0.3 0 0"/><parent link="hub"/><child link="arm"/><axis xyz="1 0 0"/>
    <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
</robot>"#;

fn report(folder: &Path, scene: &str, arguments: &[&str]) -> Value {
    std::fs::write(folder.join("scene.toml"), scene).expect("the scene is written");
    let all = [&["simulate", "scene.toml", "--no-log", "--json", "--duration", "0.05"], arguments].concat();
    let output = run(folder, &all);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("a report")
}

/// The largest difference of joint positions (m, rad).
fn apart(a: &Value, b: &Value) -> f64 {
    let positions = |report: &Value| -> Vec<f64> {
        let joints = report["joints"].as_object().expect("joints");
        joints.values().map(|joint| joint["position"].as_f64().expect("a number")).collect()
    };
    positions(a).iter().zip(positions(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn warns(report: &Value, of: &str) -> bool {
    report["warnings"].as_array().expect("warnings").iter().any(|warning| warning.as_str().unwrap().contains(of))
}

#[test]
fn a_far_end_takes_no_more_steps_and_moves_as_a_spring_nearby_of_no_rest_length() {
    let folder = scratch("far_spring");
    std::fs::write(folder.join("hub.urdf"), HUB).expect("the robot is written");
    let tolerance = ["--tolerance", "1e-4"];
    let near = [report(&folder, &governor("0", ["0", "0"], false), &[]), report(&folder, &hub("0.5", "0"), &[])];
    // Before, steps fell with the square of the distance: 4936 at 1e6 m.
    for distance in ["1e6", "1e7", "1e8", "1e9", "1e10"] {
        let meters: f64 = distance.parse().unwrap();
        let far = [
            report(&folder, &governor(distance, ["0.5", "4e4"], false), &tolerance),
            report(&folder, &governor(distance, ["0.5", "4e4"], true), &tolerance),
            report(&folder, &hub(distance, "0.5"), &tolerance),
        ];
        for (which, far) in far.iter().enumerate() {
            let (error, steps) = (apart(far, &near[which / 2]), far["steps"].as_u64().unwrap());
            println!("{distance} m, {which}: {error:.1e}, {steps} steps");
            // A tenth of the tolerance, what is left of the rest length, and some hundred roundings of places.
            assert!(error < 1e-5 + 1.0 / meters + 100.0 * f64::EPSILON * meters, "{distance} m, {which}: {error:.1e}");
            assert!(steps < 100, "{distance} m, {which}: {steps} steps");
            // Within a rounding of the stored energy nothing is said of long steps.
            assert!(!warns(far, "steps are too long"), "{}", far["warnings"]);
        }
    }
}

#[test]
fn an_accuracy_below_the_rounding_of_far_ends_is_not_said_to_be_reached() {
    let folder = scratch("far_rounding");
    std::fs::write(folder.join("hub.urdf"), HUB).expect("the robot is written");
    let near = report(&folder, &hub("0.5", "0"), &[]);
    let far = report(&folder, &hub("1e10", "0.5"), &["--tolerance", "1e-6"]);
    let estimated = far["accuracy"]["estimated"].as_f64().unwrap();
    assert!(apart(&far, &near) < 10.0 * estimated && estimated > 1e-6, "{}", far["accuracy"]);
    assert_eq!(far["accuracy"]["reached"], false);
    assert!(warns(&far, "spring \"far\" reaches 1.0e10 m") && warns(&far, "--tolerance 2e-4"), "{}", far["warnings"]);
    assert!(warns(&far, "the energy balance says nothing of this run"), "{}", far["warnings"]);
    // Nor do fixed steps take an estimate from it.
    let fixed = report(&folder, &hub("1e10", "0.5"), &["--stages", "5", "--step", "0.005"]);
    assert!(fixed["step_error"].is_null() && !warns(&fixed, "too long"), "{}", fixed["warnings"]);
    let enough = report(&folder, &hub("1e10", "0.5"), &["--tolerance", "2.2e-4"]);
    assert!(enough["accuracy"]["reached"] == true && !warns(&enough, "reaches"), "{}", enough["warnings"]);
}
