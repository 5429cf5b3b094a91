//! The solver on whole scenes.

use crate::instant::cone::bounded::minimise;
use crate::instant::cone::cascade::{EVERYDAY, SOFT, soft};
use crate::instant::cone::impact::impulse_without_collision;
use crate::instant::cone::laws::natural_map;
use crate::instant::cone::newton::{Settings, improve};
use crate::instant::cone::oracle::convex_rounds;
use crate::instant::cone::problem::{BlockState, Law, Problem, Unsolved, outside_cone};
use crate::instant::cone::scaled::Scaled;
use crate::instant::cone::scenes::{Body, Random, Scene, arch, chain, random, stack, wedge};
use crate::instant::cone::{least_compliance, margin, solve};
use nalgebra::{DMatrix, DVector, Vector3};

/// Solves a scene and checks what the law says, literally.
fn check(name: &str, scene: &Scene) -> f64 {
    let problem = scene.problem();
    let answer = match solve(&problem, None) {
        Ok(answer) => answer,
        Err(unsolved) => panic!("{name}: {unsolved}"),
    };
    let scale = answer.forces.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
    for ((law, start), state) in scene.laws.iter().zip(problem.starts()).zip(&answer.states) {
        let Law::Contact { friction } = *law else { continue };
        let (force, rate) = (&answer.forces[start..start + 3], &answer.rates[start..start + 3]);
        let beyond = outside_cone(friction, [force[0], force[1], force[2]]);
        assert!(force[0] >= 0.0 && beyond <= 1e-12 * scale, "{name}: the force is outside of its cone by {beyond:e}");
        match state {
            BlockState::Open => assert!(force == [0.0; 3] && rate[0] >= 0.0, "{name}: {force:?} {rate:?}"),
            BlockState::Slips => assert!(rate[0] == 0.0 && force[0] > 0.0, "{name}: {force:?} {rate:?}"),
            _ => assert!(rate == [0.0; 3], "{name}: {rate:?}"),
        }
    }
    answer.residual
}

#[test]
fn random_problems_are_solved() {
    let (mut missed, mut worst) = (Vec::new(), 0.0_f64);
    for (contacts, bodies, decades, friction, seeds) in [
        (1, 1, 4.0, (0.05, 1.5), 100),
        (4, 1, 4.0, (0.05, 1.5), 100),
        (4, 3, 4.0, (0.05, 1.5), 100),
        (16, 5, 4.0, (0.05, 1.0), 100),
        (16, 3, 2.0, (0.05, 1.5), 50),
        (40, 12, 2.0, (0.05, 1.0), 10),
        (64, 20, 2.0, (0.05, 1.0), 6),
    ] {
        for seed in 0..seeds {
            let scene = random(contacts, bodies, decades, friction, seed);
            match solve(&scene.problem(), None) {
                Ok(answer) => worst = worst.max(answer.residual),
                Err(unsolved) => missed.push(format!("{contacts} on {bodies}, seed {seed}: {unsolved}")),
            }
        }
    }
    println!("worst {worst:e}");
    assert!(missed.is_empty(), "{} {missed:#?}", missed.len());
}

#[test]
fn limits_friction_of_joints_and_known_slips_are_solved_together() {
    let (mut sliding, mut inconsistent, mut worst) = (0, 0, 0.0_f64);
    for seed in 0..200 {
        let mut numbers = Random::new(seed + 77);
        let mut scene = random(6, 4, 2.0, (0.05, 0.4), seed);
        for law in &mut scene.laws {
            let angle = numbers.between(0.0, 6.3_f64);
            let friction = numbers.between(0.0, 0.4);
            if numbers.signed() > 0.3 {
                *law = Law::Sliding { friction, direction: [angle.cos(), angle.sin()] };
            }
        }
        for (body, (lower, upper)) in
            [(0.0, f64::INFINITY), (-0.1, 0.1), (f64::NEG_INFINITY, f64::INFINITY)].into_iter().enumerate()
        {
            let row = scene.row(body, Some(3), numbers.direction(), numbers.direction());
            scene.hold(row, Law::Interval { lower, upper });
        }
        let scene = scene.build(0.5);
        match solve(&scene.problem(), None) {
            Ok(answer) => worst = worst.max(answer.residual),
            Err(Unsolved::Inconsistent { .. }) => inconsistent += 1,
            Err(unsolved) => panic!("seed {seed}: {unsolved}"),
        }
        sliding += scene.laws.iter().filter(|law| matches!(law, Law::Sliding { .. })).count();
    }
    println!("{sliding} slide, {inconsistent} without a solution, worst {worst:e}");
    assert!(sliding > 300 && inconsistent <= 10 && worst <= 1e-10, "{sliding}, {inconsistent}, {worst:e}");
}

#[test]
fn nothing_is_called_a_paradox_that_has_an_answer() {
    // Boxes on each other, each of which slides another way: if Newton's method stops short, the blocks that it holds closed may be a paradox of
    // their own.
    let (mut solved, mut paradoxes) = (0, Vec::new());
    for seed in 0..300 {
        let numbers = &mut Random::new(seed);
        let mut scene = stack(&[1.0; 6], 0.5, 1.0);
        for level in scene.laws.chunks_mut(4) {
            let (angle, friction) = (numbers.between(0.0, 6.3_f64), numbers.between(0.2, 0.6));
            level.fill(Law::Sliding { friction, direction: [angle.cos(), angle.sin()] });
        }
        for body in &mut scene.bodies {
            (body.velocity, body.spin) = (numbers.direction() * 0.3, numbers.direction() * 0.3);
        }
        let scene = scene.build(1.0);
        let problem = scene.problem();
        match solve(&problem, None) {
            Ok(_) => solved += 1,
            Err(Unsolved::Inconsistent { .. }) if soft(&Scaled::new(&problem)).is_some() => paradoxes.push(seed),
            Err(_) => {}
        }
    }
    println!("{solved} have answers");
    assert!(paradoxes.is_empty() && solved > 250, "{solved} have answers, and so have {paradoxes:?}");
}

#[test]
fn built_scenes_are_solved() {
    for (name, scene) in [
        ("box", stack(&[1.0], 0.5, 1.0)),
        ("stack of 10", stack(&[1.0; 10], 0.5, 1.0)),
        ("1 under 1e4", stack(&[1.0, 1e4], 0.5, 1.0)),
        ("1 under 1e8", stack(&[1.0, 1e8], 0.5, 1.0)),
        ("arch 11, 0.7", arch(11, 0.2, 0.7, 1.0)),
        ("arch 11, 0.3", arch(11, 0.2, 0.3, 1.0)),
        ("arch 11, 0.1", arch(11, 0.2, 0.1, 1.0)),
        ("arch 21", arch(21, 0.12, 0.7, 1.0)),
        ("wedge inside", wedge(0.2, 0.5, 1.0)),
        ("wedge outside", wedge(0.2, 0.1, 1.0)),
        ("wedge on the edge", wedge(0.2, 0.2_f64.tan(), 1.0)),
        ("chain of 20", chain(20, 1.0, 0.5)),
        ("chain of 20, heavy tip", chain(20, 1e3, 0.5)),
    ] {
        let residual = check(name, &scene);
        println!("{name}: {residual:.1e}");
        // Some times rounding times the square root of the largest mass ratio, which is 2e-12.
        assert!(residual <= 1e-11, "{name}: {residual:e}");
    }
}

/// The rod of C7 of the reference: half length 1/2, radius 0.01, mass 1, 0.6 from upright, with the law of its tip.
fn painleve(law: Law, gravity: f64, slip: f64) -> Scene {
    let (half, radius, lean) = (0.5, 0.01, 0.6_f64);
    let mut rod = Body::cuboid(1.0, [1.0; 3], Vector3::new(half * lean.sin(), 0.0, half * lean.cos() + radius));
    rod.inertia = Vector3::repeat(half * half / 3.0);
    rod.velocity.x = slip;
    let mut scene = Scene::new(vec![rod]);
    scene.touch(0, None, Vector3::zeros(), Vector3::z(), law);
    scene.build(gravity)
}

#[test]
fn painleves_rod_has_no_acceleration_and_takes_the_impulse_of_the_reference() {
    // The second tangent is −x, along which it slides with 1.
    let slides = painleve(Law::Sliding { friction: 2.0, direction: [0.0, 1.0] }, 9.81, 0.0);
    match solve(&slides.problem(), None) {
        // The determinant of the reference times 1/m.
        Err(Unsolved::Inconsistent { block: 0, mobility }) => {
            assert!((mobility + 0.907_410_986_424_093_7).abs() < 1e-14, "{mobility}");
        }
        other => panic!("{other:?}"),
    }
    // Below the critical friction it slides on.
    let slides = painleve(Law::Sliding { friction: 1.0, direction: [0.0, 1.0] }, 9.81, 0.0);
    let answer = solve(&slides.problem(), None).expect("an acceleration");
    assert!(answer.states == [BlockState::Slips] && answer.residual < 1e-14 && answer.forces[2] == -answer.forces[0]);
    let touches = painleve(Law::Contact { friction: 2.0 }, 0.0, -1.0);
    let answer = impulse_without_collision(&touches.problem(), 0, &mut Default::default()).expect("an impulse");
    let expected = [0.349_232_503_887_203_5, 0.0, -0.477_158_224_309_854_9];
    for (found, expected) in answer.forces.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-14, "{found} instead of {expected}");
    }
    assert!(answer.states == [BlockState::Sticks] && answer.rates == [0.0; 3]);
}

#[test]
fn velocities_agree_with_rounds_of_convex_problems() {
    // For little friction the answer is unique; clarabel and Newton go different ways to it.
    let (mut compared, mut worst) = (0, 0.0_f64);
    for seed in 0..40 {
        let scene = random(1 + seed as usize % 8, 1 + seed as usize % 3, 2.0, (0.05, 0.3), seed);
        let problem = scene.problem();
        let answer = solve(&problem, None).expect("an answer");
        let scaled = Scaled::new(&problem);
        let mut forces = convex_rounds(&scaled, None).expect("rounds");
        improve(&scaled, &mut forces, EVERYDAY);
        let mut rates = vec![0.0; forces.len()];
        scaled.rates(&forces, &mut rates);
        if scaled.residual(&forces, &rates) > 1e-10 {
            continue;
        }
        compared += 1;
        let size = scene.free.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
        let literal = problem.rates(&scaled.unscale(&forces));
        for (found, literal) in answer.rates.iter().zip(&literal) {
            worst = worst.max((found - literal).abs() / size);
        }
    }
    println!("{compared} compared, worst {worst:e}");
    assert!(compared >= 36 && worst < 2e-10, "{compared} compared, worst {worst:e}");
}

#[test]
fn forces_of_least_compliance_do_not_depend_on_the_start() {
    let mut numbers = Random::new(5);
    for (name, scene) in [
        ("box", stack(&[1.0], 0.5, 1.0)),
        ("stack of 3", stack(&[1.0, 2.0, 0.5], 0.5, 1.0)),
        ("wedge", wedge(0.2, 0.5, 1.0)),
        ("arch", arch(7, 0.2, 0.7, 1.0)),
    ] {
        let problem = scene.problem();
        let mut first: Option<Vec<f64>> = None;
        for round in 0..10 {
            let start: Vec<f64> = scene.free.iter().map(|_| numbers.between(0.0, 0.5)).collect();
            let answer = solve(&problem, Some(&start)).expect("an answer");
            let forces = least_compliance(&problem, &answer);
            let off = Scaled::new(&problem).residual_of(&forces);
            assert!(off < 1e-10, "{name}: {off:e} off the law");
            let size = forces.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
            let first = first.get_or_insert_with(|| forces.clone());
            let apart =
                forces.iter().zip(first.iter()).fold(0.0_f64, |most, (one, other)| most.max((one - other).abs()));
            assert!(apart <= 1e-6 * size, "{name}, start {round}: {apart:e} apart, of {size}");
        }
        if name == "box" {
            // Equal corners, up to the compliance.
            for force in first.expect("forces").chunks(3) {
                assert!((force[0] - 0.25).abs() < 1e-6 && force[1].abs() < 1e-6 && force[2].abs() < 1e-6, "{force:?}");
            }
        }
    }
}

/// A box of weight 1 whose feet are at (±1, ±1), with its centre over a point (C10 of the reference).
fn on_four_feet(x: f64, y: f64, friction: f64) -> Scene {
    let mut scene = Scene::new(vec![Body::cuboid(1.0, [2.0; 3], Vector3::new(x, y, 1.0))]);
    for (x, y) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        scene.touch(0, None, Vector3::new(x, y, 0.0), Vector3::z(), Law::Contact { friction });
    }
    scene.build(1.0)
}

#[test]
fn the_margin_of_a_box_on_four_feet_is_that_of_the_reference() {
    // The largest least force is (1 − max(|x|, |y|))/4, with and without friction.
    for (x, y, wanted) in [(0.6, 0.6, 0.1), (0.9, 0.2, 0.025), (1.01, 0.0, -0.0025), (0.0, 0.0, 0.25)] {
        for friction in [0.0, 0.5] {
            let found = margin(&on_four_feet(x, y, friction).problem());
            assert!((found - wanted).abs() < 1e-8, "{x}, {y}, friction {friction}: {found} instead of {wanted}");
        }
    }
    // One contact that must slip: determinate, r_N = 1 and |r_T| = 1/2 of a rod that a slope of 1/2 holds.
    let mut scene = Scene::new(vec![Body::cuboid(1.0, [1.0; 3], Vector3::zeros())]);
    let normal = Vector3::new(-0.6, 0.0, 0.8);
    scene.touch(0, None, Vector3::zeros(), normal, Law::Contact { friction: 0.5 });
    let found = margin(&scene.build(1.0).problem());
    assert!((found - (0.8 - 0.6 / 0.5)).abs() < 1e-14, "{found}");
}

#[test]
fn least_compliance_is_the_least_weighted_norm() {
    // Three equations for four forces: r = V Aᵀ (A V Aᵀ)⁻¹ load, V = 1/w.
    let (x, y) = (0.2, 0.1);
    let scene = on_four_feet(x, y, 0.0);
    let problem = scene.problem();
    let forces = least_compliance(&problem, &solve(&problem, None).expect("an answer"));
    let feet = DMatrix::from_row_slice(3, 4, &[1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0, 1.0]);
    let inverse = DMatrix::from_diagonal(&DVector::from_fn(4, |foot, _| {
        let mobility = |row: usize| scene.mobility[(3 * foot + row, 3 * foot + row)];
        3.0 / (mobility(0) + mobility(1) + mobility(2))
    }));
    let load = DVector::from_column_slice(&[1.0, x, y]);
    let middle = &feet * &inverse * feet.transpose();
    let literal = inverse * feet.transpose() * middle.try_inverse().expect("independent") * load;
    for (foot, literal) in literal.iter().enumerate() {
        assert!((forces[3 * foot] - literal).abs() < 1e-6, "{forces:?} instead of {literal}");
    }
}

#[test]
fn intervals_agree_with_the_active_set_method() {
    let mut numbers = Random::new(9);
    for round in 0..300 {
        let count = 1 + round % 7;
        let rank = 1 + (round / 7) % count;
        let rows = DMatrix::from_fn(rank, count, |_, _| numbers.signed());
        let mobility = rows.transpose() * rows;
        let free: Vec<f64> = (&mobility * DVector::from_fn(count, |_, _| numbers.signed())).iter().copied().collect();
        let bounds: Vec<(f64, f64)> = (0..count)
            .map(|index| match index % 4 {
                0 => (0.0, f64::INFINITY),
                1 => (-0.3, 0.3),
                2 => (f64::NEG_INFINITY, f64::INFINITY),
                _ => (-numbers.between(0.0, 1.0), numbers.between(0.0, 1.0)),
            })
            .collect();
        let laws: Vec<Law> = bounds.iter().map(|&(lower, upper)| Law::Interval { lower, upper }).collect();
        let answer = solve(&Problem { mobility: &mobility, free: &free, laws: &laws }, None).expect("an answer");
        let literal = minimise(&mobility, &free, &bounds);
        for (found, expected) in answer.rates.iter().zip(&literal.rest) {
            // Both have the rounding of forces as large as 1 over the least eigenvalue.
            assert!((found - expected).abs() < 1e-9, "round {round}: {:?} instead of {:?}", answer.rates, literal.rest);
        }
    }
}

#[test]
fn the_same_problem_has_the_same_answer_to_the_last_bit() {
    let scene = random(16, 3, 2.0, (0.05, 1.5), 3);
    let bits = |forces: &[f64]| forces.iter().map(|force| force.to_bits()).collect::<Vec<u64>>();
    let (one, other) = (solve(&scene.problem(), None).expect("one"), solve(&scene.problem(), None).expect("other"));
    assert_eq!(bits(&one.forces), bits(&other.forces));
    // Started at its own answer, it stays there.
    let warm = solve(&scene.problem(), Some(&one.forces)).expect("warm");
    let size = one.forces.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
    assert!(one.forces.iter().zip(&warm.forces).all(|(one, warm)| (one - warm).abs() <= 1e-10 * size));
}

#[test]
fn bad_numbers_are_errors() {
    let mobility = DMatrix::identity(3, 3);
    let solve =
        |mobility: &DMatrix<f64>, free: &[f64], law: Law| super::solve(&Problem { mobility, free, laws: &[law] }, None);
    let contact = Law::Contact { friction: 0.5 };
    let free = [-1.0, 0.0, 0.0];
    assert!(matches!(solve(&mobility, &free[..2], contact), Err(Unsolved::Shape { rows: 3, free: 2, .. })));
    for (free, law) in [
        ([f64::NAN, 0.0, 0.0], contact),
        (free, Law::Contact { friction: -0.1 }),
        (free, Law::Contact { friction: f64::NAN }),
        (free, Law::Sliding { friction: 0.5, direction: [0.0, 0.0] }),
    ] {
        assert!(matches!(solve(&mobility, &free, law), Err(Unsolved::Numbers { block: 0 })));
    }
    let crossing = Law::Interval { lower: 1.0, upper: 0.0 };
    assert!(matches!(solve(&DMatrix::identity(1, 1), &[0.0], crossing), Err(Unsolved::Numbers { block: 0 })));
    // A block that must move and that no force can move: no answer, and the error has the best iterate.
    match solve(&DMatrix::zeros(3, 3), &free, contact) {
        Err(Unsolved::Stopped { best }) => assert!(best.residual > 0.1),
        other => panic!("{other:?}"),
    }
    assert!(super::solve(&Problem { mobility: &DMatrix::zeros(0, 0), free: &[], laws: &[] }, None).is_ok());
}

/// A column of flat ends on each other, each of which touches the one below with this many points round its rim, that slides with some of them and is
/// hit.
fn pillar(seed: usize) -> Scene {
    let mut random = Random::new(seed as u64);
    let levels = 2 + random.below(3);
    let bodies = (0..levels).map(|level| {
        let mut body = Body::cuboid(
            10f64.powf(random.signed()),
            [0.2, 0.2, 0.1],
            Vector3::new(0.0, 0.0, 0.1 * level as f64 + 0.05),
        );
        body.velocity = Vector3::new(random.signed(), random.signed(), -random.between(0.0, 1.0));
        body.spin = Vector3::from_fn(|_, _| 3.0 * random.signed());
        body
    });
    let mut scene = Scene::new(bodies.collect());
    let friction = random.between(0.1, 1.0);
    for level in 0..levels {
        let points = 4 + random.below(8);
        let beside = Vector3::new(0.03 * random.signed(), 0.03 * random.signed(), 0.1 * level as f64);
        for point in 0..points {
            let (sine, cosine) = (std::f64::consts::TAU * point as f64 / points as f64).sin_cos();
            let at = beside + Vector3::new(cosine, sine, 0.0) * 0.08;
            scene.touch(level, level.checked_sub(1), at, Vector3::z(), Law::Contact { friction });
        }
    }
    scene.build(0.0)
}

#[test]
fn a_compliance_that_follows_the_map_solves_redundant_impacts_that_a_constant_one_does_not() {
    let (mut constant, mut following, mut all) = (0, 0, 0);
    for seed in 0..100 {
        let scene = pillar(seed);
        let scaled = Scaled::new(&scene.problem());
        let solves = |settings: Settings| {
            let mut forces = vec![0.0; scaled.free.len()];
            improve(&scaled, &mut forces, settings);
            scaled.residual_of(&scaled.unscale(&forces)) <= 1e-10
        };
        constant += usize::from(solves(EVERYDAY));
        following += usize::from(solves(SOFT));
        all += usize::from(solve(&scene.problem(), None).is_ok());
    }
    println!("constant {constant}, following {following}, all ways {all} of 100");
    assert!(following >= 95 && all >= following && constant <= following - 10, "{constant}, {following}, {all}");
}

#[test]
fn what_the_soft_way_finds_is_off_by_next_to_nothing_of_the_free_rates() {
    // Rebounds of contacts that pinch a body have no solution in many of these; forces without end do not count as solutions.
    let (mut found, mut none) = (0, 0);
    for seed in 0..300 {
        let scene = random(1 + seed as usize % 3, 1, 0.0, (0.5, 1.5), seed);
        let mut target = scene.free.clone();
        scene.problem().starts().iter().for_each(|&start| target[start] += target[start].min(0.0));
        let problem = Problem { free: &target, ..scene.problem() };
        let scaled = Scaled::new(&problem);
        let Some(forces) = soft(&scaled) else {
            none += 1;
            continue;
        };
        found += 1;
        let mut rates = vec![0.0; forces.len()];
        scaled.rates(&forces, &mut rates);
        let fastest = scaled.free.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
        for (start, law) in scaled.blocks() {
            let off = natural_map(&law, &rates[start..], &forces[start..]).norm();
            assert!(off <= 1e-10 * fastest, "seed {seed}: {off:e} of {fastest:e}");
        }
    }
    println!("{found} found, {none} not");
    assert!(found > 100 && none > 0, "{found}, {none}");
}
