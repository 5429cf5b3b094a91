//! Closed loops: order, gaps, redundancy and singular positions.

mod closed;

use catena::kinematics::body_states;
use catena::lobatto::Lobatto;
use catena::simulation::Integrator;

/// Error of the tip of the first crank of an N-four-bar at t = 1 s.
fn four_bar_error(count: usize, rows: usize, stages: usize, step: f64, until: f64, expected: [f64; 2]) -> (f64, usize) {
    let (mechanism, mut state) = closed::four_bars(count, rows);
    let mut lobatto = Lobatto::fixed(&mechanism, stages, step).unwrap();
    let mut iterations = 0;
    let mut steps = 0;
    while state.time < until {
        let outcome = lobatto.advance(&mechanism, &mut state, until).unwrap();
        iterations += outcome.iterations;
        steps += 1;
        assert_eq!(outcome.rejected, 0, "at {}", state.time);
    }
    println!("iterations/step {}", iterations as f64 / steps as f64);
    let crank = &body_states(&mechanism, &state)[0];
    let tip = crank.position + crank.rotation * nalgebra::Vector3::new(0.5, 0.0, 0.0);
    ((tip.x - expected[0]).hypot(tip.z - expected[1]), iterations)
}

#[test]
fn a_four_bar_converges_with_the_order_of_the_tree() {
    let expected = [-0.26071267518365038, -0.96541643915907316];
    for rows in [2, 5] {
        for stages in [2, 3, 4, 5] {
            let (coarse, _) = four_bar_error(1, rows, stages, 0.1, 1.0, expected);
            let (fine, iterations) = four_bar_error(1, rows, stages, 0.05, 1.0, expected);
            println!(
                "{rows} {stages}: {coarse:.2e} {fine:.2e} ratio {:.1} iterations {}",
                coarse / fine,
                iterations as f64 / 20.0
            );
        }
    }
}

#[test]
fn bricard_ends_where_the_reference_says() {
    for (stages, step) in [(3, 0.16), (3, 0.08), (4, 0.16), (4, 0.08), (5, 0.16), (5, 0.08), (9, 0.24)] {
        let (mechanism, mut state) = closed::bricard();
        let mut lobatto = Lobatto::fixed(&mechanism, stages, step).unwrap();
        let (mut iterations, mut steps, mut gap) = (0, 0, 0.0_f64);
        while state.time < 2.4 {
            let outcome = lobatto.advance(&mechanism, &mut state, 2.4).unwrap();
            iterations += outcome.iterations;
            steps += 1;
            let bodies = body_states(&mechanism, &state);
            gap = gap.max(catena::closures::loop_gaps(&mechanism.loops[0], &bodies).largest().0);
        }
        let rod = &body_states(&mechanism, &state)[1];
        let tip = rod.position + rod.rotation * nalgebra::Vector3::new(0.0, -0.5, 0.0);
        let expected = nalgebra::Vector3::new(-0.9910312231896985, -0.99996013963756425, -0.0089285573315649579);
        println!(
            "bricard s={stages} h={step}: {:.3e} iterations {:.1} gap {gap:.1e}",
            (tip - expected).norm(),
            iterations as f64 / steps as f64
        );
    }
}

#[test]
fn singular_positions_are_passed_at_any_step_size() {
    for count in [1, 2, 10] {
        for stages in [3, 4, 5, 9] {
            let (mut failed, mut rejected, mut bad, mut wrong) = (0, 0, 0, 0);
            let mut iterations = 0;
            let mut steps = 0;
            let runs = if count == 10 { 20 } else { 200 };
            for run in 0..runs {
                let step = 0.005 * 10.0_f64.powf(run as f64 / runs as f64 + 0.001);
                let (mechanism, mut state) = closed::four_bars(count, 5);
                let energy = |state: &catena::state::State| {
                    catena::invariants::energy(&mechanism, &body_states(&mechanism, state)).total()
                };
                let start = energy(&state);
                let mut lobatto = Lobatto::fixed(&mechanism, stages, step).unwrap();
                while state.time < 5.0 {
                    match lobatto.advance(&mechanism, &mut state, 5.0) {
                        Ok(outcome) => {
                            rejected += outcome.rejected;
                            iterations += outcome.iterations;
                            steps += 1;
                        }
                        Err(error) => {
                            failed += 1;
                            println!("h {step}: {error}");
                            break;
                        }
                    }
                }
                let drift = (energy(&state) - start).abs();
                if drift > 1e-3 {
                    wrong += 1;
                }
                if drift > 1e-6 {
                    bad += 1;
                }
            }
            println!(
                "N={count} s={stages}: failed {failed} rejected {rejected} wrong {wrong} >1e-6 {bad} iterations {:.2}",
                iterations as f64 / steps as f64
            );
        }
    }
}
