//! Velocities beside singular positions of joint coordinates: how many digits are left of them.

use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::StopRule;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::energy::energy;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::stepping::integrator::Lobatto;
use catena::study::stress::Problem;

/// The top in gimbals, turning about an axis that the gimbals hardly see: `angle` from lock (rad), and as fast as one over that.
pub(crate) fn beside_lock(angle: f64) -> (Mechanism, State) {
    let problem = Problem::all().into_iter().find(|problem| problem.name == "gimbal_lock").unwrap();
    let case = (problem.build)(4).unwrap();
    let mut state = case.start;
    state.position.copy_from_slice(&[0.3, angle, 0.2]);
    state.velocity.copy_from_slice(&[1.0 / angle, -0.5, 2.0 - 1.0 / angle]);
    (case.mechanism, state)
}

/// The state after twenty steps, and the largest deviation of the energy on the way, over the kinetic energy.
fn twenty_steps(mechanism: &Mechanism, start: &State, mut lobatto: Lobatto) -> (State, f64) {
    let mut state = start.clone();
    let initial = energy(mechanism, &body_states(mechanism, start));
    let mut largest = 0.0_f64;
    for _ in 0..20 {
        lobatto.advance(mechanism, &mut state, f64::INFINITY).unwrap();
        let now = energy(mechanism, &body_states(mechanism, &state)).total();
        largest = largest.max((now - initial.total()).abs() / initial.kinetic);
    }
    (state, largest)
}

#[test]
fn beside_a_gimbal_lock_what_is_lost_grows_as_the_angle_falls_and_not_as_its_square() {
    for angle in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        let (mechanism, start) = beside_lock(angle);
        let step = 0.01 * angle;
        let top = |state: &State| body_states(&mechanism, state).last().unwrap().velocity;
        let (right, _) = twenty_steps(&mechanism, &start, Lobatto::precise(&mechanism, 9, step).unwrap());
        // The last two are vectors that have the general sweeps alone.
        for (stages, isa) in [(9, Isa::Avx512), (9, Isa::Avx2), (5, Isa::Portable), (11, Isa::Avx512)] {
            let fixed = Lobatto::fixed_with(&mechanism, stages, step, StopRule::ROUNDING, isa).unwrap();
            let (ended, off) = twenty_steps(&mechanism, &start, fixed);
            let setting = format!("{angle} rad from lock, {stages} stages, {isa:?}");
            // Rates of 1/angle are rounded; measured are 2e-15 to 6e-15 over the angle, and 5e-14 to 2e-10 with the velocities as they are
            // first solved for.
            assert!(off < 2e-14 / angle, "{setting}: energy off by {off:.1e}");
            let apart = (top(&ended) - top(&right)).norm();
            // Measured: 2e-12 at the first angle and 2e-13 at the others; 1e-11 to 3e-4 otherwise.
            assert!(apart < 5e-12, "{setting}: {apart:.1e} m/s from the step of 32 digits");
        }
    }
}
