//! Linear relations of several joints (`[[coupling]]`): a differential between two wheels and its carrier, and a screw, against closed forms.

use crate::common::scratch;
use crate::scene_files::{joint, report};
use catena::report::Report;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Moments about the axes of left wheel, right wheel and carrier [kg m²], and the coefficients of `left + right − 2 carrier = 0`.
const MOMENTS: [f64; 3] = [0.4, 0.7, 0.3];
const TERMS: [f64; 3] = [1.0, 1.0, -2.0];
const NAMES: [&str; 3] = ["left", "right", "carrier"];

/// Three bodies that turn about vertical axes, coupled as a differential, with more tables.
fn differential(folder: &str, more: &str) -> PathBuf {
    let folder = scratch(folder);
    let mut urdf = String::from("<robot name='axle'><link name='base'/>");
    for (name, moment) in NAMES.iter().zip(MOMENTS) {
        write!(
            urdf,
            "<link name='{name}_link'><inertial><mass value='1'/><inertia ixx='0.1' iyy='0.1' izz='{moment}' ixy='0' ixz='0' iyz='0'/>\
             </inertial></link><joint name='{name}' type='continuous'><parent link='base'/><child link='{name}_link'/><axis xyz='0 0 1'/>\
             </joint>"
        )
        .expect("text");
    }
    std::fs::write(folder.join("axle.urdf"), urdf + "</robot>").expect("a robot");
    let file = folder.join("axle.toml");
    let coupling = "[[coupling]]\nname = \"differential\"\njoints = { left = 1.0, right = 1.0, carrier = -2.0 }\n";
    std::fs::write(&file, format!("[[robot]]\nurdf = \"axle.urdf\"\n{coupling}{more}")).expect("a scene");
    file
}

fn loads(efforts: [f64; 3]) -> String {
    let load = |(name, effort): (&&str, f64)| format!("[[load]]\njoint = \"{name}\"\neffort = {effort:?}\n");
    NAMES.iter().zip(efforts).map(load).collect()
}

/// `I q̈ = τ + cᵀ λ`, `c q̈ = 0`: the accelerations of those that move.
fn accelerations(efforts: [f64; 3], moves: [bool; 3]) -> [f64; 3] {
    let over = |index: usize| if moves[index] { 1.0 / MOMENTS[index] } else { 0.0 };
    let sum = |value: &dyn Fn(usize) -> f64| (0..3).map(value).sum::<f64>();
    let multiplier = -sum(&|i| TERMS[i] * efforts[i] * over(i)) / sum(&|i| TERMS[i] * TERMS[i] * over(i));
    [0, 1, 2].map(|i| (efforts[i] + TERMS[i] * multiplier) * over(i))
}

fn assert_all(what: &str, report: &Report, wanted: [(f64, f64); 3], bound: f64) {
    for (name, (q, v)) in NAMES.iter().zip(wanted) {
        let (is, rate) = joint(report, name);
        assert!((is - q).abs() < bound && (rate - v).abs() < bound, "{what}, {name}: {is} {rate} instead of {q} {v}");
    }
}

#[test]
fn a_differential_shares_efforts_as_its_equations_say() {
    let efforts = [0.8, -0.5, 1.3];
    let a = accelerations(efforts, [true; 3]);
    let end = report(&differential("free", &loads(efforts)), &[], &[], Some(2.0), 1e-11);
    assert_all("free", &end, a.map(|a| (2.0 * a, 2.0 * a)), 1e-10);
    assert!(end.constraint.max_position < 1e-14 && end.energy.max_relative_error < 1e-12, "{:?}", end.constraint);
    // Positions of two joints decide the third.
    let start = report(&differential("start", ""), &[("left", 0.6), ("carrier", 0.1)], &[], Some(0.1), 1e-9);
    assert_all("start", &start, [(0.6, 0.0), (-0.4, 0.0), (0.1, 0.0)], 1e-14);
}

#[test]
fn a_wheel_of_a_differential_that_is_stopped_leaves_the_other_two() {
    // The left wheel stops dead at 0.2 rad: the impulse on it acts through the relation, too.
    let efforts = [0.8, -0.1, 1.3];
    let limit = "[[joint]]\nname = \"left\"\nlimit = [-1.0, 0.2]\n";
    let a = accelerations(efforts, [true; 3]);
    assert!(a[0] > 0.0);
    let time = (2.0 * 0.2 / a[0]).sqrt();
    let before = a.map(|a| a * time);
    // v⁺ = v − Y e (e Y e)⁻¹ v₁, with Y e the answer to an impulse on the left wheel.
    let answer = accelerations([1.0, 0.0, 0.0], [true; 3]);
    let after = [0, 1, 2].map(|i| before[i] - answer[i] / answer[0] * before[0]);
    let then = accelerations(efforts, [false, true, true]);
    let left = 1.0 - time;
    let wanted = [0, 1, 2].map(|i| {
        let start = 0.5 * a[i] * time * time;
        (start + after[i] * left + 0.5 * then[i] * left * left, after[i] + then[i] * left)
    });
    let end = report(&differential("limit", &(loads(efforts) + limit)), &[], &[], Some(1.0), 1e-11);
    assert_all("limit", &end, wanted, 1e-9);
    let lost = 0.5 * before[0] * before[0] / answer[0];
    assert!((end.energy.impacts - lost).abs() < 1e-10, "{} instead of {lost}", end.energy.impacts);
    // Friction of the carrier holds it under small efforts: both wheels turn against each other.
    let friction = "[[joint]]\nname = \"carrier\"\nfriction = 5.0\n";
    let efforts = [0.8, -0.5, 0.2];
    let a = accelerations(efforts, [true, true, false]);
    let end = report(&differential("friction", &(loads(efforts) + friction)), &[], &[], Some(2.0), 1e-11);
    assert_all("friction", &end, a.map(|a| (2.0 * a, 2.0 * a)), 1e-10);
}

#[test]
fn a_nut_on_a_screw_falls_slowly_and_turns() {
    // 3 kg with 0.02 kg m² on a thread of 0.05 m a turn: (m + I k²) z̈ = −m g, k = 2π/0.05.
    let folder = scratch("screw");
    let urdf = "<robot name='r'><link name='base'/><link name='slider'/><link name='nut'><inertial><mass value='3'/><inertia ixx='0.01' \
                iyy='0.01' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='slide' type='prismatic'><parent link='base'/>\
                <child link='slider'/><axis xyz='0 0 1'/><limit lower='-inf' upper='inf' effort='inf' velocity='inf'/></joint>\
                <joint name='turn' type='continuous'><parent link='slider'/><child link='nut'/><axis xyz='0 0 1'/></joint></robot>";
    std::fs::write(folder.join("nut.urdf"), urdf).expect("a robot");
    let k = std::f64::consts::TAU / 0.05;
    let file = folder.join("nut.toml");
    let scene = format!("[[robot]]\nurdf = \"nut.urdf\"\n[[coupling]]\njoints = {{ turn = 1.0, slide = {:?} }}\n", -k);
    std::fs::write(&file, scene).expect("a scene");
    let end = report(&file, &[], &[], Some(4.0), 1e-11);
    let a = -3.0 * 9.81 / (3.0 + 0.02 * k * k);
    let ((z, v), (turn, _)) = (joint(&end, "slide"), joint(&end, "turn"));
    assert!((z - 8.0 * a).abs() < 1e-10 && (v - 4.0 * a).abs() < 1e-10, "{z} {v} instead of {} {}", 8.0 * a, 4.0 * a);
    assert!((turn - k * z).abs() < 1e-10, "{turn} {z}");
    // The same as one joint of the URDF.
    let urdf = "<robot name='r'><link name='base'/><link name='nut'><inertial><mass value='3'/><inertia ixx='0.01' iyy='0.01' izz='0.02' \
                ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='thread' type='screw'><parent link='base'/><child link='nut'/>\
                <axis xyz='0 0 1'/><thread_pitch value='0.05'/></joint></robot>";
    let screw = folder.join("screw.urdf");
    std::fs::write(&screw, urdf).expect("a robot");
    let end = report(&screw, &[], &[], Some(4.0), 1e-11);
    let ((turn, rate), (z, v)) = (joint(&end, "thread"), joint(&end, "thread_slide"));
    assert!((z - 8.0 * a).abs() < 1e-10 && (v - 4.0 * a).abs() < 1e-10, "{z} {v} instead of {} {}", 8.0 * a, 4.0 * a);
    assert!((turn - k * z).abs() < 1e-10 && (rate - k * v).abs() < 1e-9, "{turn} {z}");
    std::fs::write(&screw, urdf.replace("0.05", "0")).expect("a robot");
    let error = catena::session::Model::load(&screw).expect_err("no thread").to_string();
    assert!(error.contains("screw.urdf:1: joint \"thread\": a screw needs its thread"), "{error}");
}

#[test]
fn couplings_that_cannot_be_are_refused_and_every_number_has_a_key_path() {
    for (table, reason) in [
        ("[[coupling]]\njoints = { left = 1 }\n", "two joints or more"),
        ("[[coupling]]\njoints = { left = 1, right = 0 }\n", "is not zero"),
        ("[[coupling]]\njoints = { left = 1, rear = 2 }\n", "there is no joint \"rear\""),
        ("[[coupling]]\nname = \"differential\"\njoints = { left = 1, right = 1 }\n", "line 3"),
    ] {
        let error = catena::session::Model::load(differential("refused", table)).expect_err(reason).to_string();
        assert!(error.contains("axle.toml:") && error.contains(reason) && !error.contains('\n'), "{error}");
    }
    let file = differential("keys", &loads([0.1, 0.0, 0.0]));
    let scene = catena::scene::read_scene(&file, &Default::default()).expect("a scene");
    let keys: Vec<String> = scene.parameters().iter().map(|parameter| parameter.key().to_string()).collect();
    for key in
        ["coupling.differential.joints.left", "coupling.differential.offset", "joint.left.armature", "load.left.effort"]
    {
        assert!(keys.iter().any(|known| known == key), "{key}");
    }
}
