//! Claims about the example scenes in `robots/`: they load, they are assembled, and they are the mechanisms they say.

use crate::common::{run_until, stem};
use catena::instant::start::assembly::assemble;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::energy::energy;
use catena::mechanism::motion::gaps::{loop_gaps, mimic_gap};
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::islands::islands;
use catena::model::Model;
use catena::scene::{PackagePath, Scene, read_scene};
use catena::stepping::integrator::Lobatto;
use catena::stepping::trees::other_tree::other_tree;
use nalgebra::{DMatrix, Vector3};
use std::path::PathBuf;

/// Every scene with its degrees of freedom: those of the joints less the independent equations of loops and mimic relations.
const MOBILITY: [(&str, usize); 22] = [
    ("andrews_squeezer", 1),
    ("arm7_held", 7),
    ("bouncing_pendulum", 1),
    ("bricard", 1),
    ("cart_pole_light", 2),
    ("cassie_like_leg", 7),
    ("damped_oscillator", 1),
    ("damped_pendulum", 1),
    ("flyball_governor", 4),
    ("four_bar_1", 1),
    ("four_bar_10", 1),
    ("four_bar_2", 1),
    ("four_bar_40", 1),
    ("friction_pendulum", 1),
    ("gripper", 1),
    ("heavy_top_fast", 3),
    ("heavy_top_slow", 3),
    ("ring_100", 98),
    ("simple_pendulum", 1),
    ("slider_crank", 1),
    ("stewart_platform", 6),
    ("strandbeest_leg", 1),
];

fn scene_files() -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("robots");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    // A sweep is no scene.
    files.retain(|file| {
        file.extension().is_some_and(|extension| extension == "toml")
            && !file.to_string_lossy().ends_with("_sweep.toml")
    });
    files.sort();
    files
}

fn load(name: &str) -> (Scene, Model, State) {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("robots").join(format!("{name}.toml"));
    let scene = read_scene(&file, &PackagePath::default()).unwrap_or_else(|error| panic!("{error}"));
    let (model, start) = Model::from_scene(&scene).unwrap_or_else(|error| panic!("{error}"));
    let state = model.initial_state(&start.positions, &start.velocities, None).unwrap();
    (scene, model, state)
}

/// The gaps of all loops.
fn gaps(mechanism: &Mechanism, state: &State) -> Vec<f64> {
    let bodies = body_states(mechanism, state);
    let gaps = mechanism.loops.iter().map(|closing| loop_gaps(closing, &bodies));
    gaps.flat_map(|gaps| gaps.position[..gaps.count].to_vec()).collect()
}

/// The gaps' rates for joint velocities, by a central difference over `2 step` of time.
fn gap_rates(mechanism: &Mechanism, state: &State, velocity: &[f64], step: f64) -> Vec<f64> {
    let at = |time: f64| {
        let mut moved = state.clone();
        moved.displace(mechanism, &velocity.iter().map(|rate| rate * time).collect::<Vec<f64>>());
        gaps(mechanism, &moved)
    };
    at(step).iter().zip(at(-step)).map(|(after, before)| (after - before) / (2.0 * step)).collect()
}

#[test]
fn every_scene_says_what_it_shows_and_how_to_run_it() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/README.md")).unwrap();
    for file in scene_files() {
        let text = std::fs::read_to_string(&file).unwrap();
        let header: String = text.lines().take_while(|line| line.starts_with('#')).collect();
        let command = format!("catena simulate robots/{}.toml", stem(&file));
        assert!(header.contains(&command) && header.contains("Look:"), "{}", file.display());
        assert!(page.contains(&command), "{}: robots/README.md does not say how to run it", file.display());
    }
}

#[test]
fn every_scene_is_assembled_at_its_start_in_position_and_velocity() {
    let files = scene_files();
    assert!(files.len() >= 22, "only {} scenes", files.len());
    for file in files {
        let (_, model, state) = load(stem(&file));
        let mechanism = &model.mechanism;
        let gap = gaps(mechanism, &state).iter().fold(0.0_f64, |most, gap| most.max(gap.abs()));
        // Sums of lengths of up to 5 m and of up to a hundred angles, each rounded to 1e-16.
        assert!(gap < 1e-13, "{}: {gap:e}", file.display());
        // A central difference over 2e-5 s errs by 1e-10 times the third derivatives, which are of the order of the
        // cube of the speeds (at most 6 rad/s in a scene with loops), and by 1e-15/1e-5 of rounding.
        let rates = gap_rates(mechanism, &state, &state.velocity, 1e-5);
        let rate = rates.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
        assert!(rate < 1e-7, "{}: {rate:e}", file.display());
    }
}

#[test]
fn the_loops_leave_the_degrees_of_freedom_that_the_literature_counts() {
    for (name, mobility) in MOBILITY {
        let (_, model, state) = load(name);
        let mechanism = &model.mechanism;
        let rows = gaps(mechanism, &state).len();
        let mut jacobian = DMatrix::zeros(rows, mechanism.velocity_count);
        for freedom in 0..mechanism.velocity_count {
            let mut unit = vec![0.0; mechanism.velocity_count];
            unit[freedom] = 1.0;
            let column = gap_rates(mechanism, &state, &unit, 1e-5);
            column.iter().enumerate().for_each(|(row, rate)| jacobian[(row, freedom)] = *rate);
        }
        // Differences are good to some 1e-9; independent rows of these mechanisms have singular values above 1e-4.
        let rank = if rows == 0 { 0 } else { jacobian.singular_values().iter().filter(|&&value| value > 1e-6).count() };
        // Mimic relations here couple no joints of loops.
        let freedoms = mechanism.velocity_count - rank - mechanism.mimics.len();
        assert_eq!(freedoms, mobility, "{name}: {rows} rows of rank {rank}");
    }
}

#[test]
fn the_squeezer_has_the_mass_matrix_and_the_closures_of_the_test_set() {
    let (_, model, _) = load("andrews_squeezer");
    let mechanism = &model.mechanism;
    // beta, theta, gamma, phi, delta, omega, epsilon; nothing special about the numbers.
    let names = ["beta", "theta", "gamma", "phi", "delta", "omega", "epsilon"];
    let q = [0.3, -0.7, 0.5, 0.2, 0.4, -0.3, 1.1];
    let positions: Vec<(String, Vec<f64>)> = names.iter().zip(q).map(|(name, q)| (name.to_string(), vec![q])).collect();
    let kinetic = |rates: &[(usize, f64)]| {
        let velocities: Vec<(String, Vec<f64>)> =
            rates.iter().map(|&(joint, rate)| (names[joint].to_string(), vec![rate])).collect();
        let state = model.initial_state(&positions, &velocities, None).unwrap();
        energy(mechanism, &body_states(mechanism, &state)).kinetic
    };
    let entry = |i: usize, j: usize| match i == j {
        true => 2.0 * kinetic(&[(i, 1.0)]),
        false => kinetic(&[(i, 1.0), (j, 1.0)]) - kinetic(&[(i, 1.0)]) - kinetic(&[(j, 1.0)]),
    };
    let [b, t, g, p, d, o, e] = q;
    let (m1, m2, m3, m4, m5, m6, m7) = (0.04325, 0.00365, 0.02373, 0.00706, 0.0705, 0.00706, 0.05498);
    let (i1, i2, i3, i4, i5, i6, i7) = (2.194e-6, 4.41e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5);
    let (rr, ra, da, dd, ss, sa, sb): (f64, f64, f64, f64, f64, f64, f64) =
        (0.007, 0.00092, 0.0115, 0.028, 0.035, 0.01874, 0.01043);
    let (ee, ea, zt, ta, tb, zf, fa): (f64, f64, f64, f64, f64, f64, f64) =
        (0.02, 0.01421, 0.04, 0.02308, 0.00916, 0.02, 0.01421);
    let (u, ua, ub): (f64, f64, f64) = (0.04, 0.01228, 0.00449);
    let expected = [
        (0, 0, m1 * ra * ra + m2 * (rr * rr - 2.0 * da * rr * t.cos() + da * da) + i1 + i2),
        (0, 1, m2 * (da * da - da * rr * t.cos()) + i2),
        (1, 1, m2 * da * da + i2),
        (2, 2, m3 * (sa * sa + sb * sb) + i3),
        (3, 3, m4 * (ee - ea).powi(2) + i4),
        (3, 4, m4 * ((ee - ea).powi(2) + zt * (ee - ea) * p.sin()) + i4),
        (
            4,
            4,
            m4 * (zt * zt + 2.0 * zt * (ee - ea) * p.sin() + (ee - ea).powi(2)) + m5 * (ta * ta + tb * tb) + i4 + i5,
        ),
        (5, 5, m6 * (zf - fa).powi(2) + i6),
        (5, 6, m6 * ((zf - fa).powi(2) - u * (zf - fa) * o.sin()) + i6),
        (6, 6, m6 * ((zf - fa).powi(2) - 2.0 * u * (zf - fa) * o.sin() + u * u) + m7 * (ua * ua + ub * ub) + i6 + i7),
        (0, 2, 0.0),
        (1, 4, 0.0),
    ];
    for (i, j, wanted) in expected {
        // A difference of energies of the order of 1e-4.
        assert!((entry(i, j) - wanted).abs() < 1e-18, "{} {}: {:e}, not {wanted:e}", names[i], names[j], entry(i, j));
    }

    let state = model.initial_state(&positions, &[], None).unwrap();
    let bodies = body_states(mechanism, &state);
    let (xa, ya, xb, yb) = (-0.06934, -0.00227, -0.03635, 0.03273);
    let connector = [rr * b.cos() - dd * (b + t).cos(), rr * b.sin() - dd * (b + t).sin()];
    let others = [
        [ss * g.sin() + xb, -ss * g.cos() + yb],
        [ee * (p + d).sin() + zt * d.cos() + xa, -ee * (p + d).cos() + zt * d.sin() + ya],
        [zf * (o + e).cos() + u * e.sin() + xa, zf * (o + e).sin() - u * e.cos() + ya],
    ];
    for (closing, other) in mechanism.loops.iter().zip(others) {
        let gap = closing.b.place(&bodies).0 - closing.a.place(&bodies).0;
        for axis in 0..2 {
            let wanted = other[axis] - connector[axis];
            assert!((gap[axis] - wanted).abs() < 1e-16, "{}: {} not {wanted}", closing.name, gap[axis]);
        }
    }
    let (sc, sd, xc, yc) = (0.018, 0.02, 0.014, 0.072);
    let spring = &mechanism.forces.point_springs[0];
    let wanted = Vector3::new(sd * g.cos() + sc * g.sin() + xb - xc, sd * g.sin() - sc * g.cos() + yb - yc, 0.0);
    let apart = spring.a.place(&bodies).0 - spring.b.place(&bodies).0;
    assert!((apart - wanted).amax() < 1e-16, "{apart}");
    assert_eq!(mechanism.forces.joint_loads.len(), 1);
    assert_eq!(mechanism.bodies[0].joint.velocity_index, mechanism.forces.joint_loads[0].freedom);
}

#[test]
fn the_governor_starts_with_free_springs_and_the_rod_of_the_slider_crank_turns_as_published() {
    let (_, model, state) = load("flyball_governor");
    let bodies = body_states(&model.mechanism, &state);
    for spring in &model.mechanism.forces.point_springs {
        let length = (spring.a.place(&bodies).0 - spring.b.place(&bodies).0).norm();
        assert!((length - spring.rest_length).abs() < 1e-15, "{length}");
    }
    let (_, model, state) = load("slider_crank");
    let bodies = body_states(&model.mechanism, &state);
    let (velocity, turn) = model.link_velocity(&bodies, model.link("rod").unwrap());
    assert!((turn - Vector3::new(1.92, -0.96, 0.48)).amax() < 1e-14, "{turn}");
    assert!((velocity - Vector3::new(0.12, -0.24, 0.0)).amax() < 1e-14, "{velocity}");
}

/// Where a point of a link is after running a scene from its start with fixed steps.
fn run_to(name: &str, link: &str, point: Vector3<f64>, stages: usize, step: f64, until: f64) -> Vector3<f64> {
    let (_, model, mut state) = load(name);
    let correction = assemble(&model.mechanism, &mut state).unwrap();
    assert!(correction.position < 1e-13 && correction.velocity < 1e-12, "{name}: {correction:?}");
    let mut lobatto = Lobatto::fixed(&model.mechanism, stages, step).unwrap();
    run_until(&model.mechanism, &mut state, &mut lobatto, until);
    let (place, axes) = model.link_pose(&body_states(&model.mechanism, &state), model.link(link).unwrap());
    place + axes * point
}

#[test]
fn mechanisms_with_loops_move_as_published_from_their_files() {
    let up = Vector3::z();
    // Problems A02 and A04 of the IFToMM library (lim.ii.udc.es/IFToMM), computed to 17 digits; a step of the order 6 errs by some 1e-7 and 1e-9 here.
    for (name, end) in [
        ("four_bar_1", Vector3::new(-0.260_712_675_183_650_4, 0.0, -0.965_416_439_159_073_2)),
        ("four_bar_2", Vector3::new(-0.195_020_301_949_435_1, 0.0, -0.980_799_205_662_173_8)),
    ] {
        let error = (run_to(name, "crank0", up, 4, 0.05, 1.0) - end).norm();
        assert!(error < 2e-7, "{name}: {error:e}");
    }
    let corner = run_to("bricard", "rod2", Vector3::new(0.0, -1.0, 0.0), 4, 0.08, 2.4);
    let published = Vector3::new(-0.991_031_223_189_698_5, -0.999_960_139_637_564_2, -0.008_928_557_331_564_958);
    assert!((corner - published).norm() < 2e-9, "{:e}", (corner - published).norm());
}

/// The position of a joint of one number after running a scene from its start with fixed steps.
fn joint_after(name: &str, joint: &str, stages: usize, step: f64, until: f64) -> f64 {
    let (_, model, mut state) = load(name);
    let mut lobatto = Lobatto::fixed(&model.mechanism, stages, step).unwrap();
    run_until(&model.mechanism, &mut state, &mut lobatto, until);
    model.joint_user_coordinates(model.joint(joint).unwrap(), &state.position, &state.velocity).0[0]
}

#[test]
fn mechanisms_with_springs_dampers_and_loads_move_as_published_from_their_files() {
    // Problems A03, A05 and A01 of the IFToMM library and a damped pendulum, computed in quadruple precision, and an exact solution. The
    // bounds are some ten times what these steps leave.
    let oscillator = {
        let frequency = 96.0_f64.sqrt();
        0.1 * (-2.0_f64).exp() * (frequency.cos() + 2.0 / frequency * frequency.sin())
    };
    for (name, joint, stages, step, until, published, bound) in [
        ("andrews_squeezer", "beta", 5, 1.25e-4, 0.03, 15.810_771_195_153_707, 1e-10),
        ("flyball_governor", "slide", 4, 0.002, 0.5, 0.743_249_424_786_325_7, 1e-10),
        ("damped_pendulum", "hinge", 5, 0.02, 1.0, -0.731_225_677_681_585_9, 1e-13),
        ("damped_oscillator", "slide", 5, 0.02, 1.0, oscillator, 1e-13),
        // The angle whose sine and cosine are the published place of the bob.
        ("simple_pendulum", "hinge", 5, 0.02, 10.0, 0.275_087_462_576_48_f64.asin(), 1e-10),
    ] {
        let error = (joint_after(name, joint, stages, step, until) - published).abs();
        println!("{name}: {error:e}");
        assert!(error < bound, "{name}: {error:e}");
    }
}

#[test]
#[ignore = "half an hour; cargo test --release --test model scenes:: -- --ignored"]
fn the_gaps_of_every_closed_scene_are_rounding_over_a_million_steps() {
    for file in scene_files() {
        let name = stem(&file);
        let (_, model, mut state) = load(name);
        let mechanism = &model.mechanism;
        // The scheme alone knows no contact: what falls is 5000 km away in the end.
        if !mechanism.has_closures() || !mechanism.nonsmooth.pairs.is_empty() {
            continue;
        }
        assemble(mechanism, &mut state).unwrap();
        let step = match name {
            // Its motor spins it up without end: within 0.1 s to some 4000 rad/s.
            "andrews_squeezer" => 1e-7,
            // It cracks like a whip, and three stages are stable up to 1.4 ms at first.
            "ring_100" => 2e-4,
            _ => 0.002,
        };
        let mut lobatto = Lobatto::fixed(mechanism, 3, step).unwrap();
        let (mut gap, mut size) = (0.0_f64, 1.0_f64);
        for _ in 0..1_000_000 {
            let until = state.time + step;
            lobatto.advance(mechanism, &mut state, until).unwrap_or_else(|error| panic!("{name}: {error}"));
            let bodies = body_states(mechanism, &state);
            let gaps = mechanism.loops.iter().map(|closing| loop_gaps(closing, &bodies).largest().0);
            gap = gaps.chain(mechanism.mimics.iter().map(|mimic| mimic_gap(mimic, &state).0.abs())).fold(gap, f64::max);
            size = bodies.iter().fold(size, |most, body| most.max(body.position.amax()));
        }
        println!("{name}: {gap:.1e} m of {size:.1} m");
        // Roundings of the places of bodies far from the origin, over the bodies of a loop.
        assert!(gap < 1e-14 * size * (1.0 + mechanism.bodies.len() as f64).sqrt(), "{name}: {gap:e} of {size}");
    }
}

#[test]
fn every_scene_is_written_on_the_spanning_tree_that_a_run_takes() {
    for file in scene_files() {
        let (_, model, _) = load(stem(&file));
        for kept in [&[][..], &[Rule::Planar]] {
            for island in islands(&model.mechanism) {
                let tree = other_tree(&island.mechanism, &[], kept);
                assert!(tree.is_none(), "{}: its results would change: {tree:?}", file.display());
            }
            assert!(other_tree(&model.mechanism, &[], kept).is_none(), "{}", file.display());
        }
    }
}
