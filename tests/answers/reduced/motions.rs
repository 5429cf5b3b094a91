//! The comparator moves as published, and ends where independent codes end.

#![allow(clippy::excessive_precision)] // Reference values stand as their sources print them.

use super::{GRAVITY, body, chain, integrate, pose};
use catena::invariants::momentum;
use catena::kinematics::body_states;
use catena::model::joint::rotation_from_wxyz;
use catena::model::{JointKind, Mechanism, Pose};
use catena::reduced::Dop853;
use catena::state::State;
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// IFToMM benchmark A01: a point of 1 kg on a massless metre, released level at (−1, 0); t, x, y, ẋ, ẏ.
#[test]
fn the_simple_pendulum_follows_the_table_of_the_iftomm_library() {
    let table = [
        (1.0, 0.98629175113187528, -0.16501085312554117, 0.29690551591631581, 1.7746436411126556),
        (2.0, -0.79356619534332173, -0.60848393044379157, -2.1024378744361258, 2.7419353930105093),
        (5.0, -0.9423054350437573, -0.3347543384140006, 0.85790425688594907, -2.4149286543704886),
        (9.99, -0.31643646991303231, -0.94861370457577654, 4.0924519914940207, -1.3651511202403046),
        (10.0, -0.27508746257611688, -0.96141920509912504, 4.1755981009517287, -1.1947490545604753),
    ];
    let joint = (JointKind::Revolute, Pose::identity(), pose([1.0, 0.0, 0.0], [0.0; 3]));
    let bodies = vec![body(0, None, 1.0, [0.0; 3], joint)];
    let mechanism = Mechanism::new("A01", Vector3::new(0.0, -GRAVITY, 0.0), bodies).expect("a pendulum");
    let mut state = State::zero(&mechanism);
    let mut integrator = Dop853::new(&mechanism, 1e-13);
    for (time, x, y, vx, vy) in table {
        let rest = time - state.time;
        integrate(&mechanism, &mut state, &mut integrator, rest);
        let tip = body_states(&mechanism, &state)[0];
        let error =
            (tip.position - Vector3::new(x, y, 0.0)).amax().max((tip.velocity - Vector3::new(vx, vy, 0.0)).amax());
        // The tolerance times the growth of phase errors over ten seconds; speeds reach 4.4 m/s.
        assert!(error < 1e-10, "t = {time}: {error:e}");
    }
}

/// The fast heavy top of Géradin and Cardona 2001; 150 rad/s, so 24 turns in the second that is compared.
#[test]
fn the_heavy_top_follows_its_reference() {
    let joint = (JointKind::Spherical, Pose::identity(), pose([0.0, -1.0, 0.0], [0.0; 3]));
    let bodies = vec![body(0, None, 15.0, [0.234375, 0.46875, 0.234375], joint)];
    let mechanism = Mechanism::new("heavy top", Vector3::new(0.0, 0.0, -GRAVITY), bodies).expect("a top");
    let fast = [
        (0.1, [0.42129665892540202, 0.89457197434559299, -0.14916470056189962]),
        (0.5, [-0.70246829705658564, -0.021165184701923325, -0.71140025765173442]),
        (1.0, [0.17334396409838604, 0.64008859207056878, -0.7484907911335813]),
    ];
    let slow = [
        (0.5, [0.0072227982418607084, 0.40584229862183535, -0.91391458016321325]),
        (1.0, [-0.03116864706262382, -0.9833836814196768, -0.17884364835735481]),
    ];
    let quaternion = [0.73294398067966371, -0.2782857193376127, 0.53182461133416259, -0.32017614273624928];
    for (rate, table) in [([0.0, 150.0, -4.61538], &fast[..]), ([0.0, 1.5, -0.0461538], &slow[..])] {
        let mut state = State::zero(&mechanism);
        state.velocity.copy_from_slice(&rate);
        let mut integrator = Dop853::new(&mechanism, 1e-13);
        for &(time, expected) in table {
            let rest = time - state.time;
            integrate(&mechanism, &mut state, &mut integrator, rest);
            let top = body_states(&mechanism, &state)[0];
            // Some 1e4 steps at 1e-13.
            assert!((top.position - Vector3::from(expected)).amax() < 1e-9, "{rate:?} at {time}: {}", top.position);
            let spin = (top.rotation.transpose() * top.angular_velocity).y;
            assert!((spin - rate[1]).abs() < 1e-9 * rate[1], "the spin of a symmetric top is constant: {spin}");
        }
        if rate[1] == 150.0 {
            let turned = body_states(&mechanism, &state)[0].rotation;
            assert!((turned - rotation_from_wxyz(&quaternion)).amax() < 1e-8, "{turned}");
        }
    }
}

/// The pendulum chains of ConstrainedDynamics.jl (WAFR 2020): straight, 45° from hanging, at rest; time, tip x, tip z.
#[test]
fn pendulum_chains_follow_their_references() {
    let slender = 1.0 / 12.0;
    let cylinder = 0.5 * (0.05 * 0.05 + 1.0 / 6.0);
    let table = [
        (1, slender, 10.0, 0.51702394091770754, -0.85597093672502855),
        (2, slender, 10.0, 1.0728298206051816, -1.640155336197975),
        (5, slender, 10.0, -3.1795454449721978, -3.7776517651265764),
        (10, slender, 1.0, 3.9378119839602022, -8.8552619087095543),
        (10, slender, 10.0, 4.5987504311334506, -8.4776573542354932),
        (2, cylinder, 3.0, 0.11532083836514852, -1.9954794058718262),
        (5, cylinder, 3.0, 0.71897703839699123, -4.9444562136688237),
    ];
    for (count, inertia, time, x, z) in table {
        let mechanism = chain(count, 1.0, 1.0, [inertia; 3], |_| [0.0, 1.0, 0.0]);
        let mut state = State::zero(&mechanism);
        // A positive angle about y swings −z towards −x.
        state.position[0] = -std::f64::consts::FRAC_PI_4;
        integrate(&mechanism, &mut state, &mut Dop853::new(&mechanism, 1e-13), time);
        let last = body_states(&mechanism, &state)[count - 1];
        let tip = last.position - last.rotation * Vector3::z() * 0.5;
        let error = (tip - Vector3::new(x, 0.0, z)).amax();
        // Errors grow at most sevenfold in ten seconds (same source), and lengths reach ten metres.
        assert!(error < 1e-9, "{count} links at {time} s: {error:e}");
    }
}

/// The free box of scpeters/benchmark, spinning near its intermediate axis while it falls.
#[test]
fn a_free_box_keeps_its_momentum_and_follows_its_reference() {
    let joint = (JointKind::Floating, Pose::identity(), Pose::identity());
    let inertia = [10.0 / 12.0 * (0.16 + 0.81), 10.0 / 12.0 * (0.01 + 0.81), 10.0 / 12.0 * (0.01 + 0.16)];
    let gravity = Vector3::new(0.0, 0.0, -9.8);
    let mechanism = Mechanism::new("box", gravity, vec![body(0, None, 10.0, inertia, joint)]).expect("a box");
    let mut state = State::zero(&mechanism);
    let thrown = Vector3::new(-2.0, 2.0, 8.0);
    state.velocity.copy_from_slice(&[thrown.x, thrown.y, thrown.z, 0.1, 5.0, 0.1]);
    let spin = |state: &State| {
        let moving = body_states(&mechanism, state)[0];
        momentum(&mechanism, &[moving]).1 - 10.0 * moving.position.cross(&moving.velocity)
    };
    let before = spin(&state);
    integrate(&mechanism, &mut state, &mut Dop853::new(&mechanism, 1e-13), 10.0);
    let expected = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(
        0.22516456341395816,
        -0.61992756249945247,
        -0.27702915068719458,
        0.69874572364031018,
    ));
    let moving = body_states(&mechanism, &state)[0];
    let error = (moving.rotation - expected.to_rotation_matrix().matrix()).amax();
    // The unstable axis spreads errors over three flips in ten seconds.
    assert!(error < 1e-9, "attitude {error:e}");
    assert!(
        (spin(&state) - before).amax() < 1e-11,
        "angular momentum of 3.4 N m s: {:e}",
        (spin(&state) - before).amax()
    );
    let flight = thrown * 10.0 + gravity * 50.0;
    assert!((moving.position - flight).amax() < 1e-10, "the parabola reaches 410 m: {}", moving.position - flight);
}

/// Reads a scene of serial revolute links, as far as these tests need it: a world link and the tree below it.
fn scene(name: &str) -> Option<(Mechanism, State, serde_json::Value)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/reference");
    let urdf = folder.join(format!("scenes/{name}.urdf"));
    let Ok(text) = std::fs::read_to_string(folder.join(format!("answers/{name}.json"))) else {
        println!("skipped: there is no reference data at {}", folder.display());
        return None;
    };
    let answer: serde_json::Value = serde_json::from_str(&text).expect("an answer in JSON");
    let robot = urdf_rs::read_file(urdf).expect("a scene in URDF");
    let link = |name: &str| robot.links.iter().find(|link| link.name == name).expect("a link of that name");
    // The principal frame of a link, seen from its own frame, and the principal moments.
    let principal = |name: &str| {
        let inertial = &link(name).inertial;
        let i = &inertial.inertia;
        let tensor = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
        let eigen = tensor.symmetric_eigen();
        let mut axes = eigen.eigenvectors;
        axes *= axes.determinant().signum();
        let r = inertial.origin.rpy.0;
        let rotation = Rotation3::from_euler_angles(r[0], r[1], r[2]) * Rotation3::from_matrix_unchecked(axes);
        let centre = Translation3::from(Vector3::from(inertial.origin.xyz.0));
        (Pose::from_parts(centre, rotation), eigen.eigenvalues, inertial.mass.value)
    };
    let bodies = robot.joints.iter().enumerate().map(|(index, joint)| {
        let parent = robot.joints.iter().position(|other| other.child.link == joint.parent.link);
        let r = joint.origin.rpy.0;
        let origin = Pose::from_parts(
            Translation3::from(Vector3::from(joint.origin.xyz.0)),
            Rotation3::from_euler_angles(r[0], r[1], r[2]),
        );
        let axis = Vector3::from(joint.axis.xyz.0);
        let turn = Rotation3::rotation_between(&Vector3::z(), &axis)
            .unwrap_or_else(|| Rotation3::new(Vector3::x() * std::f64::consts::PI));
        let turn = Pose::from_parts(Translation3::identity(), turn);
        let on_parent = match parent {
            Some(_) => principal(&joint.parent.link).0.inverse() * origin * turn,
            None => origin * turn,
        };
        let (frame, moments, mass) = principal(&joint.child.link);
        let mut body =
            body(index, parent, mass, moments.into(), (JointKind::Revolute, on_parent, frame.inverse() * turn));
        body.joint.name.clone_from(&joint.name);
        body
    });
    let gravity = Vector3::from_iterator(answer["gravity"].as_array()?.iter().filter_map(|value| value.as_f64()));
    let mechanism = Mechanism::new(name, gravity, bodies.collect()).expect("joints listed depth first");
    let mut state = State::zero(&mechanism);
    for body in &mechanism.bodies {
        let initial = &answer["initial"][&body.joint.name];
        state.position[body.joint.position_index] = initial["position"].as_f64()?;
        state.velocity[body.joint.velocity_index] = initial["velocity"].as_f64()?;
    }
    Some((mechanism, state, answer))
}

#[test]
fn scenes_end_where_three_independent_codes_end() {
    // Bounds: the arm is chaotic and the heavy tip weighs 1e4 links, which spread rounding errors to these lengths.
    for (name, bound) in
        [("pendulum3d_double_T3", 1e-11), ("arm7_T1", 1e-8), ("chain_10_T05", 1e-9), ("heavy_tip_T05", 1e-7)]
    {
        let Some((mechanism, mut state, answer)) = scene(name) else { return };
        let duration = answer["duration"].as_f64().expect("a duration");
        let summary = integrate(&mechanism, &mut state, &mut Dop853::new(&mechanism, 1e-13), duration);
        let last = answer["com"].as_array().and_then(|rows| rows.last()).expect("centres of mass");
        let mut worst = 0.0_f64;
        for (index, moving) in body_states(&mechanism, &state).iter().enumerate() {
            for axis in 0..3 {
                let expected = last[index][axis].as_f64().expect("a coordinate");
                worst = worst.max((moving.position[axis] - expected).abs());
            }
        }
        println!("{name}: {worst:.1e} m after {} steps, {} rejected", summary.steps, summary.rejected_steps);
        assert!(worst < bound, "{name}: {worst:e}");
    }
}
