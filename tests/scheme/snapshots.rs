//! What is logged of several instants at once is what is worked out for one instant after the other.

use crate::common::Numbers;
use crate::models;
use catena::instant::exerting::snapshots::{SerialInstants, View};
use catena::kernels::instants_for;
use catena::lobatto::instants::snapshot::{INSTANTS, Instants, LinkPlace, Row, Snapshots};
use catena::lobatto::instants::tree::LaneInstants;
use catena::lobatto::vectors::portable::Portable;
use catena::mechanism::description::joint::{JointKind, Pose};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::state::State;
use catena::model::{Base, ModelOptions};
use catena::scene::{PackagePath, read_urdf};
use nalgebra::Vector3;
use std::path::Path;

/// Mechanisms of all kinds of joints, with and without forces in them.
fn trees() -> Vec<Mechanism> {
    let mut all: Vec<Mechanism> =
        [models::double_pendulum(), models::floating_tree(), models::spatial_pendulum(), models::free_body()]
            .into_iter()
            .map(|model| model.mechanism)
            .collect();
    all.extend(models::JOINT_KINDS.map(|kind| models::one_joint(kind).mechanism));
    for file in
        ["arm7.urdf", "quadruped.urdf", "humanoid.urdf", "gantry.urdf", "planar_slider.urdf", "spherical_chain.urdf"]
    {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(file);
        let robot = read_urdf(&path, &PackagePath::default()).unwrap();
        let options = ModelOptions { base: Base::Fixed, ..ModelOptions::default() };
        all.push(catena::model::Model::new(robot, &options).unwrap().mechanism);
    }
    let mut forced = models::floating_tree();
    for forces in [models::joint_dampers, models::joint_springs, models::joint_loads] {
        let forces = forces(&forced.mechanism);
        forced = models::with_forces(forced, forces);
        all.push(forced.mechanism.clone());
    }
    all
}

/// A link on every body, one of them turned, and one in the world.
fn links(mechanism: &Mechanism) -> Vec<LinkPlace> {
    let turned = models::turned_frame(Vector3::new(0.1, -0.2, 0.3), Vector3::new(2.0, -1.0, 0.5));
    let on_bodies = (0..mechanism.bodies.len()).flat_map(|body| [(Some(body), Pose::identity()), (Some(body), turned)]);
    [(None, turned)].into_iter().chain(on_bodies).collect()
}

/// Positions and velocities of some instants, one after the other.
fn states(mechanism: &Mechanism, count: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut random, mut positions, mut velocities) = (Numbers::new(7), Vec::new(), Vec::new());
    for _ in 0..count {
        let mut state = State::zero(mechanism);
        let turn: Vec<f64> = (0..mechanism.velocity_count).map(|_| random.next(-3.0, 3.0)).collect();
        state.displace(mechanism, &turn);
        positions.extend_from_slice(&state.position);
        velocities.extend((0..mechanism.velocity_count).map(|_| random.next(-5.0, 5.0)));
    }
    (positions, velocities)
}

fn look(
    what: &mut dyn Instants,
    mechanism: &Mechanism,
    links: usize,
    (p, v): &(Vec<f64>, Vec<f64>),
    count: usize,
) -> Snapshots {
    let mut out = Snapshots::new(mechanism, links);
    what.look(p, v, count, &mut out);
    out
}

fn numbers(snapshots: &Snapshots) -> [Vec<Row>; 3] {
    let Snapshots { poses, wrenches, efforts, .. } = snapshots;
    [poses.concat(), wrenches.concat(), efforts.clone()]
}

#[test]
fn eight_instants_at_once_are_eight_instants_one_after_the_other() {
    for mechanism in trees() {
        let links = links(&mechanism);
        let states = states(&mechanism, INSTANTS);
        let serial = look(&mut SerialInstants::new(&mechanism, &links), &mechanism, links.len(), &states, INSTANTS);
        let ways: [Box<dyn Instants>; 2] =
            [instants_for(&mechanism, &links), Box::new(LaneInstants::<Portable<8>>::new(&mechanism, &links))];
        // What bodies that fly freely carry is zero as the difference of what their motion needs and has.
        let moving = mechanism.bodies.iter().map(|body| 10.0 * body.mass + 25.0 * body.inertia.sum()).sum();
        let wrenches = serial.wrenches.iter().flatten().flatten();
        let largest = wrenches.fold(moving, |most: f64, number| most.max(number.abs()));
        for mut way in ways {
            let lanes = look(way.as_mut(), &mechanism, links.len(), &states, INSTANTS);
            let [poses, wrenches, efforts] = [0, 1, 2].map(|what| {
                let (a, b) = (&numbers(&serial)[what], &numbers(&lanes)[what]);
                let differences = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs());
                // A NaN is the worst.
                differences.fold(0.0, |worst: f64, other| if worst.is_nan() || other <= worst { worst } else { other })
            });
            // Poses gather some roundings a body. What is carried goes through the inverse of inertias that lie within 1e4 of one
            // another.
            assert!(poses < 1e-13, "{}: poses differ by {poses:.1e}", mechanism.name);
            let (wrenches, efforts) = (wrenches / largest, efforts / largest);
            assert!(wrenches < 1e-11 && efforts < 1e-11, "{}: {wrenches:.1e}, {efforts:.1e}", mechanism.name);
        }
    }
}

/// What a log has must not depend on when its thread looked at the samples.
#[test]
fn an_instant_is_the_same_to_the_bit_in_every_lane_and_in_every_company() {
    for mechanism in trees() {
        let links = links(&mechanism);
        let states = states(&mechanism, INSTANTS);
        let together = look(instants_for(&mechanism, &links).as_mut(), &mechanism, links.len(), &states, INSTANTS);
        let mut alone = instants_for(&mechanism, &links);
        for instant in 0..INSTANTS {
            let of = |numbers: &[f64]| {
                let count = numbers.len() / INSTANTS;
                numbers[instant * count..][..count].to_vec()
            };
            let own = look(alone.as_mut(), &mechanism, links.len(), &(of(&states.0), of(&states.1)), 1);
            let (own, all) = (numbers(&own), numbers(&together));
            for (own, all) in own.iter().flatten().zip(all.iter().flatten()) {
                assert_eq!(own[0].to_bits(), all[instant].to_bits(), "{}, instant {instant}", mechanism.name);
            }
        }
    }
}

#[test]
fn quaternions_have_unit_length_after_a_thousand_joints() {
    let mechanism = models::chain(1000).mechanism;
    let links: Vec<LinkPlace> = (0..1000).map(|body| (Some(body), Pose::identity())).collect();
    let states = states(&mechanism, 3);
    let out = look(&mut View::new(&mechanism, &links), &mechanism, links.len(), &states, 3);
    for [_, _, _, w, x, y, z] in &out.poses {
        for instant in 0..3 {
            let length = [w, x, y, z].iter().map(|row| row[instant] * row[instant]).sum::<f64>();
            assert!((length - 1.0).abs() < 2e-15, "{length}");
            assert!(w[instant] >= 0.0);
        }
    }
}

#[test]
fn joints_that_have_turned_a_million_times_are_where_they_are() {
    let mechanism = models::one_joint(JointKind::Revolute).mechanism;
    let links = links(&mechanism);
    let turn = std::f64::consts::TAU;
    let angles = [0.0, 0.5 * turn, -0.5 * turn, 1.5 * turn + 1e-9, 1e3, -1e4 * turn, 6e6 + 0.1, f64::MIN_POSITIVE];
    let states = (angles.iter().flat_map(|&angle| [angle, -angle]).collect(), vec![1.0; 2 * INSTANTS]);
    let serial = look(&mut SerialInstants::new(&mechanism, &links), &mechanism, links.len(), &states, INSTANTS);
    let lanes = look(&mut View::new(&mechanism, &links), &mechanism, links.len(), &states, INSTANTS);
    for (of_link, serial) in lanes.poses.iter().zip(&serial.poses) {
        for instant in 0..INSTANTS {
            let numbers = |pose: &[Row; 7]| pose.map(|row| row[instant]);
            let (ours, theirs) = (numbers(of_link), numbers(serial));
            let near = |sign: f64| {
                let distances = (0..7).map(|n| (ours[n] - if n < 3 { theirs[n] } else { sign * theirs[n] }).abs());
                // A rounding or two of lengths below a metre.
                distances.fold(0.0, f64::max) < 1e-15
            };
            // At half a turn w is zero, and its sign is rounding.
            assert!(near(1.0) || theirs[3] < 1e-12 && near(-1.0), "{} rad: {ours:?} {theirs:?}", angles[instant]);
        }
    }
}
