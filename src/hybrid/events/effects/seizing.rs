//! The impulse without collision of contacts that slide while no acceleration fits Coulomb's law (Painlevé), all of them plastic.
//!
//! ```text
//!     u⁺ = D P + u⁻,    contacts: Signorini's and Coulomb's law between P and u⁺,    limits that joints are on:  0 ≤ P ⊥ u⁺ ≥ 0
//!     v⁺ = v⁻ + Y Wᵀ P,    lost = −½ (u⁻ + u⁺)ᵀ P ≥ 0  (J)
//! ```
//!
//! Source: F. Génot, B. Brogliato, New results on Painlevé paradoxes, European Journal of Mechanics A 18 (1999).

use crate::events::effects::contacts::Contacts;
use crate::events::effects::decision::{Candidate, Scene};
use crate::instant::cone::impact::impulse_without_collision;
use crate::instant::cone::problem::{Law, Problem};
use crate::instant::holding::blocks::{Block, Of, Rows};
use crate::instant::holding::elements::inward;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;

/// The impulse of contacts that jam.
pub(super) struct Seized {
    /// The energy that it takes, and the work of driven surfaces (J).
    pub lost: f64,
    pub driven: f64,
    /// The normal impulses, each of a contact of a pair (N s).
    pub impulses: Vec<(usize, f64)>,
}

impl Contacts {
    /// The impulse of a candidate whose accelerations all violate the law, at which joints on their limits bear; `None` if it is not found.
    pub(super) fn seize(&self, scene: &mut Scene, state: &mut State, candidate: usize) -> Option<Seized> {
        let bodies = body_states(scene.whole, state);
        let number = |candidate: &Candidate| self.all.iter().position(|contact| *contact == candidate.contact);
        let numbers: Vec<usize> = self.candidates.iter().filter_map(number).collect();
        let mut blocks: Vec<Block> = numbers.iter().map(|&index| self.block(scene, &bodies, index)).collect();
        let (contacts, contact_rows) = (blocks.len(), blocks.iter().map(|block| block.rows.len()).sum::<usize>());
        let joints = scene.elements.joints.iter().enumerate().filter_map(|(index, joint)| {
            let side = joint.side(joint.position(state))?;
            let lower = if joint.is_locked() { f64::NEG_INFINITY } else { 0.0 };
            let (freedom, count) = (joint.coordinate.freedom, state.velocity.len());
            Some(Block::of_joint(index, freedom, count, inward(side), [lower, f64::INFINITY]))
        });
        blocks.extend(joints);
        let rows = Rows::of(scene.response, state, &blocks);
        let before = rows.rates(&state.velocity);
        let laws: Vec<Law> = blocks.iter().map(|block| block.law).collect();
        let problem = Problem { mobility: &rows.square, free: &before, laws: &laws };
        let impulses = impulse_without_collision(&problem, candidate, scene.solvers).ok()?.forces;
        rows.add(&impulses, &mut state.velocity);
        let after = rows.rates(&state.velocity);
        for (block, impulse) in blocks[contacts..].iter().zip(&impulses[contact_rows..]) {
            if let Of::Joint(index) = block.of
                && *impulse != 0.0
            {
                state.velocity[scene.elements.joints[index].coordinate.freedom] = 0.0;
            }
        }
        let lost = impulses.iter().zip(before.iter().zip(&after)).map(|(impulse, (a, b))| -0.5 * impulse * (a + b));
        let mut row = 0;
        let normal = numbers.iter().zip(&blocks).map(|(&number, block)| {
            let impulse = impulses[row];
            row += block.rows.len();
            (self.all[number].pair, impulse)
        });
        let normal = normal.collect();
        Some(Seized { lost: lost.sum(), driven: rows.work_of_belts(&impulses), impulses: normal })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::effects::decision::Yielding;
    use crate::events::effects::memory::Found;
    use crate::events::finding::watched::Watched;
    use crate::events::modes::mode::Mode;
    use crate::instant::dynamics::response::Response;
    use crate::instant::holding::elements::Elements;
    use crate::instant::holding::touching::Touching;
    use crate::mechanism::description::closure::{Coordinate, JointLimit};
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::{Body, Mechanism};
    use crate::mechanism::motion::contact_solvers::ContactSolvers;
    use crate::mechanism::motion::energy::energy;
    use crate::mechanism::motion::touches::touch_motion;
    use nalgebra::{Rotation3, Translation3, Vector3};

    /// A rod of 1 m and 1 kg that leans on a floor with one end and slides so that it jams. At its other end an arm of 0.2 m hangs on a hinge that is
    /// on one of these limits (rad).
    fn jamming_rod(limits: [f64; 2]) -> (Mechanism, State) {
        let joint = Joint::new("rod", JointKind::Floating, Pose::identity(), Pose::identity());
        let about = Vector3::new(0.25 / 3.0, 0.25 / 3.0, 1e-3);
        let rod = Body { name: "rod".into(), parent: None, mass: 1.0, inertia: about, joint };
        let across = Rotation3::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_2);
        let frame = |z: f64| Pose::from_parts(Translation3::new(0.0, 0.0, z), across);
        let joint = Joint::new("hinge", JointKind::Revolute, frame(0.5), frame(0.2));
        let arm = Body { name: "arm".into(), parent: Some(0), mass: 0.3, inertia: Vector3::repeat(1e-3), joint };
        let mut mechanism = Mechanism::new("rod", Vector3::z() * -9.81, vec![rod, arm]).expect("two bodies");
        let hinge = &mechanism.bodies[1].joint;
        let coordinate = Coordinate { body: 1, position: hinge.position_index, freedom: hinge.velocity_index };
        let nonsmooth = &mut mechanism.nonsmooth;
        let [lower, upper] = limits;
        nonsmooth.limits.push(JointLimit { coordinate, lower, upper, restitution: 0.0 });
        let end = Pose::translation(0.0, 0.0, -0.5);
        for (body, pose, shape) in
            [(Some(0), end, Shape::Sphere { radius: 0.01 }), (None, Pose::identity(), Shape::HalfSpace)]
        {
            nonsmooth.colliders.push(Collider::still("one", body, pose, shape));
        }
        nonsmooth.pairs.push(ContactPair::without_moments(0, [0, 1], 3.0, 0.0));
        let (half, mut state) = (0.25_f64, State::zero(&mechanism));
        state.position[2] = 0.5 * (2.0 * half).cos() + 0.01;
        state.position[3..7].copy_from_slice(&[half.cos(), 0.0, half.sin(), 0.0]);
        state.velocity[0] = -2.0;
        (mechanism, state)
    }

    #[test]
    fn a_limit_bears_in_the_impulse_of_a_rod_that_jams_and_no_joint_is_pushed_into_it() {
        let mut rates = Vec::new();
        for (limits, inwards) in [([-1.0, 0.0], -1.0), ([0.0, 1.0], 1.0)] {
            let (mechanism, mut state) = jamming_rod(limits);
            let (elements, touching) = (Elements::new(&mechanism), Touching::new(&mechanism));
            let mut response = Response::new(&mechanism);
            let mut solvers = ContactSolvers::default();
            let mut scene = Scene {
                whole: &mechanism,
                elements: &elements,
                touching: &touching,
                near: &[0],
                response: &mut response,
                solvers: &mut solvers,
            };
            let before = Mode {
                joints: Vec::new(),
                motors: Vec::new(),
                contacts: Vec::new(),
                idle: Vec::new(),
                kept: Vec::new(),
                unpressed: Vec::new(),
                seams: Vec::new(),
            };
            let found = Found { triggers: &[Watched::Approach(0)], height: 0.0, anew: true, brief: false };
            let mut contacts = Contacts::gather(&scene, &before, &state, &found, 2.0);
            contacts.come_to_rest(&mut scene, &mut state, &Yielding::default());
            assert_eq!(contacts.candidates.len(), 1);
            let kinetic = |state: &State| energy(&mechanism, &body_states(&mechanism, state)).kinetic;
            let had = kinetic(&state);
            let Seized { lost, impulses, .. } = contacts.seize(&mut scene, &mut state, 0).expect("an impulse");
            let touch = touch_motion(&contacts.candidates[0].contact.joint, &body_states(&mechanism, &state));
            println!("{limits:?}: rate {}, {lost} J lost, {touch:?}", state.velocity[6]);
            // The end stands: of 2 m/s what the law is solved to is left.
            assert!(touch.rate.abs() <= 1e-9 && touch.slip.norm() <= 1e-9, "{touch:?}");
            assert!(impulses.len() == 1 && impulses[0].1 > 0.1, "{impulses:?}");
            assert!(lost > 0.1 && (had - kinetic(&state) - lost).abs() <= 1e-9 * had, "{lost} of {had}");
            rates.push(inwards * state.velocity[6]);
        }
        // The impulse turns the arm one way: from one of the limits it leaves, and the other one holds it.
        rates.sort_by(f64::total_cmp);
        assert!(rates[0] == 0.0 && rates[1] > 0.5, "{rates:?}");
    }
}
