//! Islands: unconnected parts of a mechanism, each a mechanism of its own.
//!
//! The trees of the mechanism are the nodes of a graph, and every loop joint, closed contact, mimic relation, point spring and pair that may touch
//! between two of them is an edge; the islands are its connected components. The world does not connect its neighbours, because it does not move.
//! Gravity and loads do not connect bodies either: the force on one body does not depend on the place of another.
//!
//! Islands are numbered by their first bodies, and keep the order of bodies, closures and forces within them, so that an
//! island is the mechanism one would have got without the others.

use crate::description::closure::Attachment;
use crate::description::mechanism::{Body, Mechanism};
use crate::description::nonsmooth::Nonsmooth;
use crate::ground::disjoint_sets::DisjointSets;
use crate::motion::state::State;
use crate::structure::renumbering::Renumbering;
use std::ops::Range;

/// A part of a mechanism without connection to the rest.
#[derive(Clone, Debug)]
pub struct Island {
    /// The part alone.
    pub mechanism: Mechanism,
    /// The places of its bodies and their coordinates in the whole, one piece after another.
    pub pieces: Vec<Piece>,
}

/// Whole trees that follow each other in the mechanism and belong to the same island.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The bodies, in the whole.
    pub bodies: Range<usize>,
    /// Their entries of the position vector of the whole.
    pub positions: Range<usize>,
    /// Their entries of the velocity vector of the whole.
    pub velocities: Range<usize>,
}

/// The islands of a mechanism; empty for a mechanism without bodies.
pub fn islands(mechanism: &Mechanism) -> Vec<Island> {
    groups(mechanism, &island_of_each_body(mechanism))
}

/// The groups of bodies with these numbers, from 0 in the order of their first bodies, each as an island; the caller knows that no group acts on another.
pub fn groups(mechanism: &Mechanism, of_body: &[usize]) -> Vec<Island> {
    let count = of_body.iter().max().map_or(0, |last| last + 1);
    if count == 1 {
        return vec![Island::whole(mechanism)];
    }
    let mut pieces: Vec<Vec<Piece>> = vec![Vec::new(); count];
    for (index, &number) in of_body.iter().enumerate() {
        add_body(&mut pieces[number], mechanism, index);
    }
    pieces.into_iter().enumerate().map(|(number, pieces)| Island::cut_out(mechanism, pieces, of_body, number)).collect()
}

/// The group of this number among those.
pub fn group(mechanism: &Mechanism, of_body: &[usize], number: usize) -> Island {
    let mut pieces = Vec::new();
    for index in (0..of_body.len()).filter(|&index| of_body[index] == number) {
        add_body(&mut pieces, mechanism, index);
    }
    Island::cut_out(mechanism, pieces, of_body, number)
}

/// Adds a body to the last piece, or to a new one.
fn add_body(pieces: &mut Vec<Piece>, mechanism: &Mechanism, index: usize) {
    let joint = &mechanism.bodies[index].joint;
    let (positions, velocities) = (joint.position_range(), joint.velocity_range());
    match pieces.last_mut() {
        Some(piece) if piece.bodies.end == index => {
            piece.bodies.end = index + 1;
            piece.positions.end = positions.end;
            piece.velocities.end = velocities.end;
        }
        _ => pieces.push(Piece { bodies: index..index + 1, positions, velocities }),
    }
}

/// The number of the island of every body.
fn island_of_each_body(mechanism: &Mechanism) -> Vec<usize> {
    let ropes = mechanism.nonsmooth.reevings.iter().flat_map(|rope| joined_by_rope(&rope.points));
    tied(mechanism, touching_ends(&mechanism.nonsmooth).chain(ropes)).numbers()
}

/// For every body the first body to which its joints, closures, mimic relations and springs tie it now, without pairs that may touch and ropes that may
/// go taut.
pub fn first_of_tied(mechanism: &Mechanism) -> Vec<usize> {
    tied(mechanism, std::iter::empty()).firsts()
}

/// The same with ropes: only pairs of shapes can bring its parts together.
pub fn first_of_parts(mechanism: &Mechanism) -> Vec<usize> {
    tied(mechanism, mechanism.nonsmooth.reevings.iter().flat_map(|rope| joined_by_rope(&rope.points))).firsts()
}

/// For every body the first body to which its joints, closures and mimic relations connect it: bodies that share equations of motion.
pub fn first_of_connected(mechanism: &Mechanism) -> Vec<usize> {
    connected(mechanism, std::iter::empty()).firsts()
}

/// The bodies that joints, closures, mimic relations, springs, taut ropes and other pairs of bodies tie.
fn tied(mechanism: &Mechanism, others: impl Iterator<Item = (usize, usize)>) -> DisjointSets {
    let springs = mechanism.forces.point_springs.iter().filter_map(|spring| spring.a.body.zip(spring.b.body));
    let ropes = mechanism.touches.iter().flat_map(|joint| joined_by_rope(&joint.reeved));
    connected(mechanism, springs.chain(ropes).chain(others))
}

/// The bodies that joints, closures, mimic relations and other pairs of bodies connect.
fn connected(mechanism: &Mechanism, others: impl Iterator<Item = (usize, usize)>) -> DisjointSets {
    let mut bodies = DisjointSets::new(mechanism.bodies.len());
    let joints = mechanism.bodies.iter().enumerate().filter_map(|(index, body)| Some((index, body.parent?)));
    let loops = mechanism.closing_ends().filter_map(|[a, b]| a.body.zip(b.body));
    let mimics = mechanism.mimics.iter();
    let mimics = mimics.flat_map(|mimic| mimic.terms().skip(1).map(|(own, _)| (mimic.follower.body, own.body)));
    for (one, other) in joints.chain(loops).chain(mimics).chain(others) {
        bodies.unite(one, other);
    }
    bodies
}

/// The bodies at the points of a rope, each with the first of them.
fn joined_by_rope(points: &[Attachment]) -> impl Iterator<Item = (usize, usize)> + '_ {
    let mut bodies = points.iter().filter_map(|point| point.body);
    let first = bodies.next();
    bodies.filter_map(move |body| Some((first?, body)))
}

/// Bodies that pairs join. Colliders that an earlier run has joined with each other, all of them fixed in bodies, are joined by one of them.
fn touching_ends(nonsmooth: &Nonsmooth) -> impl Iterator<Item = (usize, usize)> + '_ {
    let body = |collider: usize| nonsmooth.colliders[collider].body;
    let mut joined = 0..0;
    nonsmooth.pairs.runs().iter().flat_map(move |run| {
        let others = run.first.b..run.first.b + run.count;
        let known = joined.start <= others.start && others.end <= joined.end;
        if !known && body(run.first.a).is_some() && others.clone().all(|other| body(other).is_some()) {
            joined = others.clone();
        }
        let count = if known { 1 } else { run.count };
        others.take(count).filter_map(move |other| body(run.first.a).zip(body(other)))
    })
}

impl Island {
    /// The whole mechanism as its only island.
    pub fn whole(mechanism: &Mechanism) -> Self {
        let piece = Piece {
            bodies: 0..mechanism.bodies.len(),
            positions: 0..mechanism.position_count,
            velocities: 0..mechanism.velocity_count,
        };
        Island { mechanism: mechanism.clone(), pieces: vec![piece] }
    }

    /// Several islands of a mechanism as one, to be run together.
    pub fn together(whole: &Mechanism, islands: &[Island]) -> Self {
        let mut all: Vec<Piece> = islands.iter().flat_map(|island| island.pieces.clone()).collect();
        all.sort_by_key(|piece| piece.bodies.start);
        let mut pieces: Vec<Piece> = Vec::with_capacity(all.len());
        for piece in all {
            match pieces.last_mut() {
                Some(last) if last.bodies.end == piece.bodies.start => {
                    last.bodies.end = piece.bodies.end;
                    last.positions.end = piece.positions.end;
                    last.velocities.end = piece.velocities.end;
                }
                _ => pieces.push(piece),
            }
        }
        // The first body is of the first island.
        let number = usize::from(pieces.first().is_some_and(|piece| piece.bodies.start > 0));
        let mut of_body = vec![number + 1; whole.bodies.len()];
        pieces.iter().for_each(|piece| of_body[piece.bodies.clone()].fill(number));
        Island::cut_out(whole, pieces, &of_body, number)
    }

    fn cut_out(whole: &Mechanism, pieces: Vec<Piece>, of_body: &[usize], number: usize) -> Self {
        let here = |body: usize| of_body[body] == number;
        // Closures with both ends in the world do not act on any body; the first island keeps them.
        let touches = |a: &Attachment, b: &Attachment| a.body.or(b.body).map_or(number == 0, here);
        let acts_here = |freedom: usize| whole.body_of_freedom(freedom).is_some_and(here);
        let into = Into { pieces: &pieces };
        let bodies: Vec<Body> = pieces
            .iter()
            .flat_map(|piece| piece.bodies.clone())
            .map(|index| {
                let mut body = whole.bodies[index].clone();
                body.parent = body.parent.map(|parent| into.body(parent));
                body.joint.position_index = into.position(body.joint.position_index);
                body.joint.velocity_index = into.freedom(body.joint.velocity_index);
                body
            })
            .collect();
        let mut mechanism = Mechanism {
            name: whole.name.clone(),
            gravity: whole.gravity,
            bodies,
            loops: whole.loops.iter().filter(|joint| touches(&joint.a, &joint.b)).cloned().collect(),
            touches: whole.touches.iter().filter(|joint| touches(&joint.a, &joint.b)).cloned().collect(),
            mimics: whole.mimics.iter().filter(|mimic| here(mimic.follower.body)).cloned().collect(),
            limits: whole.limits.iter().filter(|limit| here(limit.coordinate.body)).cloned().collect(),
            nonsmooth: whole.nonsmooth.clone(),
            forces: whole.forces.clone(),
            position_count: pieces.iter().map(|piece| piece.positions.len()).sum(),
            velocity_count: pieces.iter().map(|piece| piece.velocities.len()).sum(),
        };
        let forces = &mut mechanism.forces;
        forces.joint_dampers.retain(|damper| acts_here(damper.freedom));
        forces.joint_springs.retain(|spring| here(spring.coordinate.body));
        forces.joint_loads.retain(|load| acts_here(load.freedom));
        forces.point_springs.retain(|spring| touches(&spring.a, &spring.b));
        forces.wrenches.retain(|wrench| here(wrench.body));
        forces.joint_courses.retain(|load| acts_here(load.freedom));
        forces.link_loads.retain(|load| here(load.body));
        forces.drags.retain(|drag| here(drag.body));
        forces.gravity_compensations.retain(|holding| acts_here(holding.freedom));

        mechanism.nonsmooth.keep_bodies(|body| here(body).then(|| into.body(body)));
        let Nonsmooth { limits, friction, motors, speeds, colliders: _, pairs: _, reevings: _ } =
            &mut mechanism.nonsmooth;
        limits.retain(|limit| here(limit.coordinate.body));
        friction.retain(|friction| here(friction.coordinate.body));
        motors.retain(|motor| here(motor.coordinate.body));
        speeds.retain(|limit| here(limit.coordinate.body));
        let (body, position) = (|body: usize| into.body(body), |position: usize| into.position(position));
        let freedom = |freedom: usize| into.freedom(freedom);
        Renumbering { body: &body, position: &position, freedom: &freedom }.apply(&mut mechanism);
        Island { mechanism, pieces }
    }

    /// The number in the whole of a body of the island.
    pub fn body_of_whole(&self, body: usize) -> usize {
        let mut rest = body;
        for Piece { bodies, .. } in &self.pieces {
            if rest < bodies.len() {
                return bodies.start + rest;
            }
            rest -= bodies.len();
        }
        body
    }

    /// The names of the bodies that hang on the world.
    pub fn roots(&self) -> impl Iterator<Item = &str> {
        self.mechanism.bodies.iter().filter(|body| body.parent.is_none()).map(|body| body.name.as_str())
    }

    /// The state of the island, taken from the state of the whole.
    pub fn state(&self, whole: &State) -> State {
        let mut state = State::zero(&self.mechanism);
        state.time = whole.time;
        let mut next = 0;
        for Piece { positions, .. } in &self.pieces {
            let own = next..next + positions.len();
            state.position[own.clone()].copy_from_slice(&whole.position[positions.clone()]);
            state.compensation[own].copy_from_slice(&whole.compensation[positions.clone()]);
            next += positions.len();
        }
        let mut next = 0;
        for Piece { velocities, .. } in &self.pieces {
            state.velocity[next..next + velocities.len()].copy_from_slice(&whole.velocity[velocities.clone()]);
            next += velocities.len();
        }
        state
    }

    /// Copies a state of the island, without its time, to its places in the whole.
    pub fn put_state(&self, own: &State, whole: &mut State) {
        self.put(&own.position, &mut whole.position, |piece| &piece.positions);
        self.put(&own.compensation, &mut whole.compensation, |piece| &piece.positions);
        self.put(&own.velocity, &mut whole.velocity, |piece| &piece.velocities);
    }

    /// Copies entries of the island to their places in the whole; `range` says which range of a piece is meant.
    pub fn put<T: Copy>(&self, own: &[T], whole: &mut [T], range: impl Fn(&Piece) -> &Range<usize>) {
        let mut rest = own;
        for place in self.pieces.iter().map(range) {
            let (here, later) = rest.split_at(place.len());
            whole[place.clone()].copy_from_slice(here);
            rest = later;
        }
    }
}

/// Translates the numbering of the whole into the numbering of an island.
struct Into<'p> {
    pieces: &'p [Piece],
}

impl Into<'_> {
    /// The index within the island; the pieces are in order of any of their ranges.
    fn index(&self, of_whole: usize, range: impl Fn(&Piece) -> &Range<usize>) -> usize {
        let before = self.pieces.iter().map(range).take_while(|place| place.start <= of_whole);
        before.map(|place| place.end.min(of_whole) - place.start).sum()
    }

    fn body(&self, body: usize) -> usize {
        self.index(body, |piece| &piece.bodies)
    }

    fn position(&self, position: usize) -> usize {
        self.index(position, |piece| &piece.positions)
    }

    fn freedom(&self, freedom: usize) -> usize {
        self.index(freedom, |piece| &piece.velocities)
    }
}
