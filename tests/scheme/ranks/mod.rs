//! Ranks are decided once, by kinematics: the count is right in every order of the loops, and every run goes to its end.

pub(crate) mod random;

use catena::instant::start::assembly::{assemble, assemble_counted, redundancy};
use catena::lobatto::coupled::counted::Counted;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::stepping::Lobatto;
use random::{gradient, mechanism, orders, rank, reordered};
use std::sync::Arc;

/// How long the random mechanisms move (s).
const SPAN: f64 = 0.1;

/// Whether a random mechanism could be judged; its count in all orders is that of the singular values.
fn counts_are_right(seed: u64) -> bool {
    let (mechanism, state) = mechanism(seed);
    let Some(rank) = rank(&gradient(&mechanism, &state)) else { return false };
    for order in orders(mechanism.loops.len()) {
        let found = redundancy(&reordered(&mechanism, &order), &state);
        assert_eq!(found.equations - found.count(), rank, "mechanism {seed}, loops in order {order:?}: {found:?}");
        assert_eq!(found.degrees_of_freedom(&mechanism), mechanism.velocity_count - rank, "mechanism {seed}");
    }
    true
}

/// Where a mechanism is at the end, from its start with the velocities that the loops allow.
fn end(seed: u64, mechanism: &Mechanism, state: &State, mut lobatto: Lobatto) -> State {
    let mut state = state.clone();
    assemble(mechanism, &mut state).unwrap_or_else(|error| panic!("mechanism {seed}: {error}"));
    while state.time < SPAN {
        let ended = lobatto.advance(mechanism, &mut state, SPAN);
        ended.unwrap_or_else(|error| panic!("mechanism {seed}: {error}"));
    }
    let bodies = body_states(mechanism, &state);
    for joint in &mechanism.loops {
        let (gap, _) = loop_gaps(joint, &bodies).largest();
        assert!(gap < 1e-12, "mechanism {seed}: {} is open by {gap:e}", joint.name);
    }
    state
}

/// Runs a random mechanism with its loops in two orders, by tolerance and in fixed steps; returns how far the ends are apart.
fn runs_reach_one_end(seed: u64) -> f64 {
    let (mechanism, state) = mechanism(seed);
    let backwards = reordered(&mechanism, &(0..mechanism.loops.len()).rev().collect::<Vec<_>>());
    let fixed = |mechanism: &Mechanism| Lobatto::fixed(mechanism, 6, 0.005).unwrap();
    let chosen = |mechanism: &Mechanism| Lobatto::adaptive(mechanism, 1e-9);
    let ends = [
        end(seed, &mechanism, &state, fixed(&mechanism)),
        end(seed, &backwards, &state, fixed(&backwards)),
        end(seed, &mechanism, &state, chosen(&mechanism)),
        end(seed, &backwards, &state, chosen(&backwards)),
    ];
    let apart = |one: &State, other: &State| {
        let bodies = [one, other].map(|state| body_states(&mechanism, state));
        let pairs = bodies[0].iter().zip(&bodies[1]);
        pairs.map(|(a, b)| (a.position - b.position).norm().max((a.rotation - b.rotation).norm())).fold(0.0, f64::max)
    };
    let same_steps = apart(&ends[0], &ends[1]);
    // Two orders of one step differ by rounding, which a tenth of a second does not amplify a thousandfold.
    assert!(same_steps < 1e-11, "mechanism {seed}: the order of the loops changes the end by {same_steps:e}");
    apart(&ends[0], &ends[2]).max(apart(&ends[0], &ends[3]))
}

fn random_mechanisms(seeds: std::ops::Range<u64>) {
    let (mut judged, mut worst) = (0, 0.0_f64);
    let count = seeds.end - seeds.start;
    let mut wrong = Vec::new();
    for seed in seeds {
        match std::panic::catch_unwind(|| (u64::from(counts_are_right(seed)), runs_reach_one_end(seed))) {
            Ok((clear, apart)) => (judged, worst) = (judged + clear, worst.max(apart)),
            Err(_) => wrong.push(seed),
        }
    }
    assert!(wrong.is_empty(), "of {count} mechanisms {}: {wrong:?}", wrong.len());
    println!("{judged} of {count} judged; by tolerance at most {worst:.1e} from fixed steps");
    // A singular value between rounding and mechanics is not seen once in a hundred.
    assert!(judged * 100 >= count * 99, "{judged} of {count} are clear");
    // A tolerance of 1e-9 is that of the steps alone here.
    assert!(worst < 1e-6, "{worst:e}");
}

#[test]
fn what_was_counted_at_the_start_changes_no_bit_of_a_run_and_what_was_counted_elsewhere_is_not_taken() {
    for seed in 0..20 {
        let (mechanism, state) = mechanism(seed);
        let mut closed = state.clone();
        let Ok((_, counted)) = assemble_counted(&mechanism, &mut closed) else { continue };
        let fixed = || Lobatto::fixed(&mechanism, 6, 0.005).unwrap();
        let elsewhere = Arc::new(Counted::at(&mechanism, &State::zero(&mechanism)));
        let expected = end(seed, &mechanism, &state, fixed());
        assert!(counted.as_ref().is_some_and(|counted| counted.is_at(&closed)), "mechanism {seed}");
        for counted in [counted, Some(elsewhere)] {
            let mut lobatto = fixed();
            lobatto.take_counted(counted);
            assert_eq!(end(seed, &mechanism, &state, lobatto), expected, "mechanism {seed}");
        }
    }
}

#[test]
fn fifty_random_mechanisms_are_counted_right_and_move_alike_in_every_order_of_their_loops() {
    random_mechanisms(0..50);
}

#[test]
#[ignore = "minutes; cargo test --release --test scheme ranks:: -- --ignored --nocapture"]
fn two_thousand_random_mechanisms_are_counted_right_and_move_alike_in_every_order_of_their_loops() {
    random_mechanisms(50..2050);
}
