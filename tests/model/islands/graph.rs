//! The islands of a mechanism are those of its graph: bodies, joints, loops, mimics, and springs between bodies.

use super::{parts, side_by_side, spring_between};
use crate::common::Numbers;
use crate::models::{self, Model};
use catena::mechanism::description::closure::{Coordinate, LoopJoint, LoopKind, Mimic};
use catena::mechanism::description::forces::{Forces, PointSpring};
use catena::mechanism::description::joint::{Joint, Pose};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::forces::total::{Stored, stored};
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::islands::islands;
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// A forest of random trees with random couplings.
fn random_mechanism(numbers: &mut Numbers) -> Model {
    let count = numbers.next(1.0, 14.0) as usize;
    let mut bodies = Vec::new();
    let mut branch: Vec<usize> = Vec::new();
    for index in 0..count {
        let depth = numbers.next(0.0, 1.8 * branch.len() as f64 + 0.9) as usize;
        branch.truncate(depth);
        let kind = models::JOINT_KINDS[numbers.next(0.0, models::JOINT_KINDS.len() as f64) as usize];
        let place = Vector3::new(numbers.next(-1.0, 1.0), numbers.next(-1.0, 1.0), numbers.next(-1.0, 1.0));
        let joint =
            Joint::new(&format!("joint{index}"), kind, Pose::translation(place.x, place.y, place.z), Pose::identity());
        let inertia = Vector3::new(0.1, 0.2, 0.25);
        bodies.push(models::body(&format!("body{index}"), branch.last().copied(), 1.0, inertia, joint));
        branch.push(index);
    }
    let mut mechanism = Mechanism::new("random", models::gravity(), bodies).expect("depth first");
    let mut state = State::zero(&mechanism);
    let displaced: Vec<f64> = (0..mechanism.velocity_count).map(|_| numbers.next(-1.0, 1.0)).collect();
    state.displace(&mechanism, &displaced);
    state.velocity.iter_mut().for_each(|rate| *rate = numbers.next(-1.0, 1.0));
    let any = |numbers: &mut Numbers| numbers.next(0.0, count as f64) as usize;
    let scalar = |mechanism: &Mechanism, body: usize| {
        let joint = &mechanism.bodies[body].joint;
        Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
    };
    for _ in 0..numbers.next(0.0, 3.0) as usize {
        let (a, b) = (any(numbers), any(numbers));
        mechanism.forces.point_springs.push(spring_between(a, b));
        let world = if numbers.next(0.0, 1.0) < 0.5 { None } else { Some(any(numbers)) };
        let ends = (models::point_of(Some(any(numbers)), [0.1; 3]), models::point_of(world, [0.3; 3]));
        mechanism.loops.push(LoopJoint { name: "loop".into(), kind: LoopKind::Spherical, a: ends.0, b: ends.1 });
    }
    if numbers.next(0.0, 1.0) < 0.5 {
        let (follower, leader) = (scalar(&mechanism, any(numbers)), scalar(&mechanism, any(numbers)));
        mechanism.mimics.push(Mimic {
            name: "mimic".into(),
            follower,
            leader,
            multiplier: 2.0,
            offset: 0.0,
            more: Vec::new(),
            over_time: None,
        });
    }
    let Forces { joint_dampers, joint_loads, wrenches, .. } = models::every_force(&mechanism).pop().expect("all").1;
    mechanism.forces = Forces { joint_dampers, joint_loads, wrenches, ..mechanism.forces };
    Model { mechanism, state }
}

/// Which bodies can be reached from each, by trying every edge again and again.
fn reachable(mechanism: &Mechanism) -> BTreeSet<BTreeSet<usize>> {
    let mut edges: Vec<(usize, usize)> = Vec::new();
    edges.extend(mechanism.bodies.iter().enumerate().filter_map(|(index, body)| Some((index, body.parent?))));
    edges.extend(mechanism.loops.iter().filter_map(|joint| joint.a.body.zip(joint.b.body)));
    edges.extend(mechanism.mimics.iter().map(|mimic| (mimic.follower.body, mimic.leader.body)));
    edges.extend(mechanism.forces.point_springs.iter().filter_map(|spring| spring.a.body.zip(spring.b.body)));
    let from = |body: usize| {
        let mut seen = BTreeSet::from([body]);
        for _ in 0..mechanism.bodies.len() {
            for &(a, b) in &edges {
                if seen.contains(&a) || seen.contains(&b) {
                    seen.extend([a, b]);
                }
            }
        }
        seen
    };
    (0..mechanism.bodies.len()).map(from).collect()
}

#[test]
fn islands_are_what_a_search_of_the_graph_finds_and_each_is_the_mechanism_it_would_be_alone() {
    let mut numbers = Numbers::new(6);
    let mut several = 0;
    for case in 0..300 {
        let Model { mechanism, state } = random_mechanism(&mut numbers);
        let found = islands(&mechanism);
        several += usize::from(found.len() > 1);
        let of = |island: &catena::mechanism::structure::islands::Island| -> BTreeSet<usize> {
            island.pieces.iter().flat_map(|piece| piece.bodies.clone()).collect()
        };
        assert_eq!(found.iter().map(of).collect::<BTreeSet<_>>(), reachable(&mechanism), "case {case}");
        assert_eq!(found.iter().map(|island| of(island).len()).sum::<usize>(), mechanism.bodies.len(), "case {case}");

        let whole = body_states(&mechanism, &state);
        let Stored { spring, load } = stored(&mechanism, &state.position, &whole);
        let (mut springs, mut loads, mut rebuilt) = (0.0, 0.0, State::zero(&mechanism));
        for island in &found {
            let own = island.state(&state);
            let mut bodies = vec![catena::mechanism::description::body_state::WORLD; whole.len()];
            let alone = body_states(&island.mechanism, &own);
            island.put(&alone, &mut bodies, |piece| &piece.bodies);
            for body in of(island) {
                assert_eq!(bodies[body], whole[body], "case {case}: body {body} is elsewhere");
            }
            island.put(&own.position, &mut rebuilt.position, |piece| &piece.positions);
            island.put(&own.velocity, &mut rebuilt.velocity, |piece| &piece.velocities);
            let theirs = stored(&island.mechanism, &own.position, &alone);
            (springs, loads) = (springs + theirs.spring, loads + theirs.load);
        }
        assert_eq!(rebuilt, state, "case {case}");
        // Sums of a few numbers of order ten in another order.
        assert!((springs - spring).abs() < 1e-11 && (loads - load).abs() < 1e-11, "case {case}: forces got lost");
        let count =
            |what: &dyn Fn(&Mechanism) -> usize| found.iter().map(|island| what(&island.mechanism)).sum::<usize>();
        assert_eq!(count(&|part| part.loops.len()), mechanism.loops.len(), "case {case}");
        assert_eq!(count(&|part| part.mimics.len()), mechanism.mimics.len(), "case {case}");
        assert_eq!(count(&|part| part.forces.joint_dampers.len()), mechanism.forces.joint_dampers.len(), "case {case}");
    }
    assert!(several > 100, "only {several} cases have several islands");
}

#[test]
fn two_robots_with_a_spring_between_them_are_one_island() {
    let mut model =
        side_by_side(vec![parts(models::double_pendulum()), parts(models::chain(4)), parts(models::double_pendulum())]);
    assert_eq!(islands(&model.mechanism).len(), 3);
    model.mechanism.forces.point_springs.push(spring_between(1, 7));
    let found = islands(&model.mechanism);
    assert_eq!(found.len(), 2);
    assert_eq!(found[0].pieces.len(), 2, "the first and the last robot, with another between them");
    assert_eq!(found[0].mechanism.bodies.len(), 4);
    // A spring to the world connects nobody.
    let to_world = PointSpring { b: models::point_of(None, [0.0; 3]), ..spring_between(3, 3) };
    model.mechanism.forces.point_springs.push(to_world);
    assert_eq!(islands(&model.mechanism).len(), 2);
}
