//! Impacts with known answers, and random ones, which gain no energy.

use super::*;
use crate::instant::cone::cascade::solve;
use crate::instant::cone::problem::outside_cone;
use crate::instant::cone::scenes::{Body, Random, Scene, random, stack};
use nalgebra::Vector3;

/// Balls of mass 1 in a row along x that touch, with these velocities.
fn cradle(velocities: &[f64]) -> Scene {
    let bodies = velocities.iter().enumerate().map(|(index, &velocity)| {
        let mut ball = Body::cuboid(1.0, [0.1; 3], Vector3::new(0.2 * index as f64, 0.0, 0.0));
        ball.velocity.x = velocity;
        ball
    });
    let mut scene = Scene::new(bodies.collect());
    for index in 1..velocities.len() {
        let point = Vector3::new(0.2 * index as f64 - 0.1, 0.0, 0.0);
        scene.touch(index, Some(index - 1), point, Vector3::x(), Law::Contact { friction: 0.0 });
    }
    scene.build(0.0)
}

/// Velocities of the balls after an impact.
fn after(velocities: &[f64], found: &Impact) -> Vec<f64> {
    let mut after = velocities.to_vec();
    for (contact, impulse) in found.impulses.chunks(3).enumerate() {
        after[contact] -= impulse[0];
        after[contact + 1] += impulse[0];
    }
    after
}

#[test]
fn the_last_balls_of_a_cradle_leave() {
    for (before, wanted) in
        [([1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0]), ([1.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 1.0])]
    {
        let scene = cradle(&before);
        let found = impact(&scene.problem(), &[1.0; 4], &mut ContactSolvers::default()).expect("an impact");
        let after = after(&before, &found);
        assert!(after.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-14), "{after:?}");
        assert!(found.lost.abs() < 1e-15);
    }
    let before = [1.0, 0.0, 0.0, 0.0, 0.0];
    let scene = cradle(&before);
    let plastic = impact(&scene.problem(), &[0.0; 4], &mut ContactSolvers::default()).expect("an impact");
    assert!(after(&before, &plastic).iter().all(|v| (v - 0.2).abs() < 1e-15));
    let half = impact(&scene.problem(), &[0.5; 4], &mut ContactSolvers::default()).expect("an impact");
    let after = after(&before, &half);
    let energy: f64 = after.iter().map(|v| 0.5 * v * v).sum();
    assert!(after.windows(2).all(|pair| pair[0] <= pair[1] + 1e-10), "{after:?}");
    assert!((0.1..=0.5).contains(&energy) && (after.iter().sum::<f64>() - 1.0).abs() < 1e-14);
}

#[test]
fn an_elastic_impact_of_a_heavy_body_on_a_light_one_before_a_wall_keeps_its_energy_however_many_rounds_it_takes() {
    // ⌊π √(M/m)⌋ collisions in all: G. Galperin, Playing pool with π, Regular and Chaotic Dynamics 8 (2003).
    for (heavy, collisions) in [(1e2, 31), (1e4, 314), (1e6, 3141)] {
        let mut first = Body::cuboid(heavy, [0.1; 3], Vector3::zeros());
        first.velocity.x = 1.0;
        let mut scene = Scene::new(vec![first, Body::cuboid(1.0, [0.1; 3], Vector3::new(0.2, 0.0, 0.0))]);
        let law = Law::Contact { friction: 0.0 };
        scene.touch(1, Some(0), Vector3::new(0.1, 0.0, 0.0), Vector3::x(), law);
        scene.touch(1, None, Vector3::new(0.3, 0.0, 0.0), -Vector3::x(), law);
        let scene = scene.build(0.0);
        let found = impact(&scene.problem(), &[1.0; 2], &mut ContactSolvers::default()).expect("an impact");
        // It turns round but for what the light body keeps, a speed no larger than its own: 1 − v² ≤ m/M.
        let after = 1.0 - found.impulses[0] / heavy;
        println!("{heavy}: {} rounds, {after}, {:e} lost", found.rounds, found.lost);
        assert!(found.rounds == collisions && found.cut == 0.0, "{} rounds", found.rounds);
        assert!((after + 1.0).abs() < 1.0 / heavy, "{after}");
        // Each round has the roundings of a few terms of the energy.
        assert!(found.lost.abs() <= 1e-15 * collisions as f64 * 0.5 * heavy, "{:e} J of {} J", found.lost, 0.5 * heavy);
    }
}

#[test]
fn a_rocking_block_keeps_housners_part_of_its_rotation() {
    // A block of half width b and half height h turns about its left edge and lands on its right one: C8 has b/h = 1/3.
    for (half_width, half_height, wanted) in [(0.1, 0.3, 0.85), (0.25, 0.3, 0.385_245_901_639_344_3)] {
        let centre = Vector3::new(0.0, 0.0, half_height);
        let mut block = Body::cuboid(1.3, [2.0 * half_width, 0.2, 2.0 * half_height], centre);
        let spin = Vector3::new(0.0, 1.0, 0.0);
        block.velocity = spin.cross(&(centre - Vector3::new(-half_width, 0.0, 0.0)));
        block.spin = spin;
        let mut scene = Scene::new(vec![block]);
        for (x, y) in [(-1.0, -0.1), (-1.0, 0.1), (1.0, -0.1), (1.0, 0.1)] {
            let point = Vector3::new(x * half_width, y, 0.0);
            scene.touch(0, None, point, Vector3::z(), Law::Contact { friction: 0.8 });
        }
        let scene = scene.build(0.0);
        let found = impact(&scene.problem(), &[0.0; 4], &mut ContactSolvers::default()).expect("an impact");
        // About the right edge, that is the rate at which the left one rises, 2 b ω.
        let after = found.rates[0] / (2.0 * half_width);
        assert!((after - wanted).abs() < 1e-14, "{after} instead of {wanted}");
    }
}

#[test]
fn the_share_of_rebound_ends_where_no_energy_is_gained() {
    let mut cut = 0;
    for seed in 0..400 {
        let scene = random(1 + seed as usize % 3, 1, 0.0, (0.5, 1.5), seed);
        let problem = scene.problem();
        let mut target = scene.free.clone();
        problem.starts().iter().for_each(|&start| target[start] += target[start].min(0.0));
        let plastic = solve(&problem, None).expect("a plastic impact").forces;
        let Ok(newton) = solve(&Problem { free: &target, ..problem }, None) else { continue };
        // Contacts that pinch the body have forces whose rounding is as large as the energy: they gain no energy, but the root is rough.
        let pinched = newton.forces.iter().any(|force| force.abs() > 1e6);
        let share = largest_share(&problem, &plastic, &newton.forces);
        // ΔE at a share, and the size of its terms.
        let gain = |share: f64| {
            let mixed = plastic.iter().zip(&newton.forces);
            let impulses: Vec<f64> = mixed.map(|(plastic, newton)| plastic + share * (newton - plastic)).collect();
            let after = problem.rates(&impulses);
            let terms = impulses.iter().zip(scene.free.iter().zip(&after));
            terms.fold((0.0, 0.0), |(sum, size), (impulse, (one, other))| {
                (sum + 0.5 * impulse * (one + other), size + (impulse * one).abs() + (impulse * other).abs())
            })
        };
        let (found, size) = gain(share);
        assert!(found <= 1e-14 * size, "seed {seed}: gains {found:e} at {share}");
        if share < 1.0 && !pinched {
            cut += 1;
            assert!(gain((share + 1e-6).min(1.0)).0 > found, "seed {seed}: {share} is not the largest");
            assert!(found.abs() <= 1e-13 * size, "seed {seed}: {found:e} is left at {share}");
        }
    }
    assert!(cut > 0, "Newton's law gains energy in none of these impacts");
}

#[test]
fn no_random_impact_gains_energy() {
    let mut random_numbers = Random::new(11);
    let (mut most, mut rounds, mut without_rebound) = (0.0_f64, 0, 0);
    for seed in 0..200 {
        let scene = match seed % 4 {
            0 => random(3, 1, 2.0, (0.05, 1.2), seed),
            1 => random(8, 3, 2.0, (0.05, 1.2), seed),
            2 => random(4, 3, 4.0, (0.0, 1.2), seed),
            _ => stack(&[1.0, 10.0, 0.1], 0.4, 1.0),
        };
        let restitution: Vec<f64> = scene.laws.iter().map(|_| random_numbers.between(-0.3, 1.0).max(0.0)).collect();
        let found = impact(&scene.problem(), &restitution, &mut ContactSolvers::default()).expect("an impact");
        let rates = scene.problem().rates(&found.impulses);
        let terms = found.impulses.iter().zip(scene.free.iter().zip(&rates));
        let gained: f64 = terms.clone().map(|(impulse, (one, other))| 0.5 * impulse * (one + other)).sum();
        let size: f64 = terms.map(|(impulse, (one, other))| 0.5 * (impulse * (one + other)).abs()).sum();
        most = most.max(gained / size.max(f64::MIN_POSITIVE));
        rounds = rounds.max(found.rounds);
        without_rebound += found.without_rebound;
        assert!((gained + found.lost).abs() <= 1e-12 * size, "seed {seed}: {gained:e} gained, {:e} lost", found.lost);
        let fastest = scene.free.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
        for (law, start) in scene.laws.iter().zip(scene.problem().starts()) {
            let Law::Contact { friction } = *law else { continue };
            let impulse = &found.impulses[start..start + 3];
            let beyond = outside_cone(friction, [impulse[0], impulse[1], impulse[2]]);
            assert!(beyond <= 1e-12 * found.impulses.iter().fold(0.0, |most, p| p.abs().max(most)), "seed {seed}");
            assert!(rates[start] >= -2.0 * APPROACHES * fastest, "seed {seed}: {:e} approaches", rates[start]);
        }
    }
    println!("most energy gained {most:e}, most rounds {rounds}, without rebound {without_rebound}");
    assert!(most <= 2e-15, "{most:e}");
}

#[test]
fn a_contact_with_fewer_freedoms_than_rows_gets_impulses_of_the_size_of_the_momentum() {
    // Two freedoms and three rows: D has rank 2, and rates with a part along its null vector are no rates of the mechanism. Newton's law asks for
    // such rates, and roundings of D times impulses of 1e12 would give them.
    let mut random_numbers = Random::new(7);
    for round in 0..2000 {
        let rows = DMatrix::from_fn(3, 2, |_, _| random_numbers.signed());
        let mobility = &rows * rows.transpose();
        let momentum = nalgebra::DVector::from_fn(2, |_, _| random_numbers.signed());
        let before = &rows * &momentum;
        let laws = [Law::Contact { friction: random_numbers.between(0.05, 1.5) }];
        let problem = Problem { mobility: &mobility, free: before.as_slice(), laws: &laws };
        let found =
            impact(&problem, &[random_numbers.between(0.0, 1.0)], &mut ContactSolvers::default()).expect("an impact");
        let kinetic = 0.5 * momentum.norm_squared();
        let after =
            (&rows.transpose() * nalgebra::DVector::from_vec(found.impulses.clone()) + &momentum).norm_squared();
        let normal = rows.row(0).norm();
        // Friction that nearly jams has impulses that are larger than the momentum; laws are solved to 1e-11 of impulses that are not larger than 100.
        assert!(found.impulses[0] <= 1e6 * kinetic.sqrt() / normal, "round {round}: {:?}", found.impulses);
        assert!((0.5 * after - (kinetic - found.lost)).abs() <= 1e-9 * kinetic, "round {round}: {after}");
        assert!(
            found.lost >= -1e-9 * kinetic && found.lost <= (1.0 + 1e-9) * kinetic,
            "round {round}: {:e}",
            found.lost
        );
    }
}

#[test]
fn what_is_not_touched_by_colliding_bodies_changes_no_digit_of_their_impact() {
    // Two boxes that collide on a floor, without restitution; beside them a ball that lies on the floor, with and without restitution.
    let collision = |beside: Option<f64>| {
        let mut boxes: Vec<Body> = [0.0, 0.2].map(|x| Body::cuboid(1.0, [0.1; 3], Vector3::new(x, 0.0, 0.1))).into();
        boxes[0].velocity = Vector3::new(1.0, 0.2, 0.0);
        boxes.extend(beside.map(|_| Body::cuboid(1.0, [0.1; 3], Vector3::new(5.0, 0.0, 0.1))));
        let count = boxes.len();
        let mut scene = Scene::new(boxes);
        let friction = Law::Contact { friction: 0.4 };
        scene.touch(1, Some(0), Vector3::new(0.1, 0.03, 0.15), Vector3::x(), friction);
        for body in 0..count {
            let at = scene.bodies[body].center - Vector3::z() * 0.1;
            scene.touch(body, None, at + Vector3::new(0.05, 0.02, 0.0), Vector3::z(), friction);
        }
        let scene = scene.build(0.0);
        let mut restitution = vec![0.0; 3];
        restitution.extend(beside);
        impact(&scene.problem(), &restitution, &mut ContactSolvers::default()).expect("an impact")
    };
    let alone = collision(None);
    assert!(alone.lost > 0.05 && alone.impulses[0] > 0.1, "{alone:?}");
    for beside in [0.0, 0.5] {
        let found = collision(Some(beside));
        assert_eq!((&found.impulses[..9], found.lost), (&alone.impulses[..], alone.lost), "{beside}");
        assert_eq!(found.impulses[9..], [0.0; 3], "{beside}");
    }
}
