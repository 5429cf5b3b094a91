//! Planar linkages as lists of rods and hinges, written on any spanning tree one likes.

// Every program of tests uses some of it.
#![allow(dead_code)]

use catena::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

/// A rod of 1 m and 1 kg: the angle of its x axis (rad), and its rate [rad/s].
#[derive(Clone)]
pub struct Rod {
    pub name: String,
    pub angle: f64,
    pub rate: f64,
}

/// A hinge about z: the bodies (none is the world) and its place on both (m).
#[derive(Clone)]
pub struct Hinge {
    pub name: String,
    pub on: [(Option<usize>, [f64; 2]); 2],
}

#[derive(Clone)]
pub struct Linkage {
    pub rods: Vec<Rod>,
    pub hinges: Vec<Hinge>,
}

impl Linkage {
    fn rod(&mut self, name: String, angle: f64, rate: f64) -> usize {
        self.rods.push(Rod { name, angle, rate });
        self.rods.len() - 1
    }

    fn hinge(&mut self, name: String, a: (Option<usize>, [f64; 2]), b: (Option<usize>, [f64; 2])) {
        self.hinges.push(Hinge { name, on: [a, b] });
    }

    /// Parallelograms side by side, cranks upright with their tips at `speed`; where three rods meet, couplers are on cranks, or with `chained`
    /// each on the one before.
    pub fn four_bars(count: usize, speed: f64, chained: bool) -> Self {
        let mut all = Linkage { rods: Vec::new(), hinges: Vec::new() };
        let (foot, tip) = ([-0.5, 0.0], [0.5, 0.0]);
        for index in 0..=count {
            let crank = all.rod(format!("crank{index}"), std::f64::consts::FRAC_PI_2, -speed);
            all.hinge(format!("pin{index}"), (None, [index as f64, 0.0]), (Some(crank), foot));
            if index > 0 {
                all.hinge(format!("knee{index}"), (Some(crank - 1), tip), (Some(crank), tip));
            }
            if index < count {
                let coupler = all.rod(format!("coupler{index}"), 0.0, 0.0);
                let before = if chained && index > 0 { crank - 1 } else { crank };
                all.hinge(format!("elbow{index}"), (Some(before), tip), (Some(coupler), foot));
            }
        }
        all
    }

    /// Crossed rods, hung by one end: scissors with hinges in the middle of each cell and between the cells. They swing and fold.
    pub fn scissors(count: usize) -> Self {
        let mut all = Linkage { rods: Vec::new(), hinges: Vec::new() };
        let half = 0.4_f64;
        for cell in 0..count {
            let falling = all.rod(format!("falling{cell}"), -half, 0.3);
            let rising = all.rod(format!("rising{cell}"), half - std::f64::consts::PI, 0.3);
            all.hinge(format!("middle{cell}"), (Some(falling), [0.0; 2]), (Some(rising), [0.0; 2]));
            if cell == 0 {
                all.hinge("top".into(), (None, [0.0; 2]), (Some(falling), [-0.5, 0.0]));
            } else {
                let (above, beside) = (falling - 2, falling - 1);
                all.hinge(format!("left{cell}"), (Some(beside), [0.5, 0.0]), (Some(falling), [-0.5, 0.0]));
                all.hinge(format!("right{cell}"), (Some(above), [0.5, 0.0]), (Some(rising), [-0.5, 0.0]));
            }
        }
        all
    }

    /// The mechanism with the hinges that come first in `preferred` in its tree and the others as loops, and its start.
    pub fn written(&self, preferred: &[usize]) -> (Mechanism, State) {
        let world = self.rods.len();
        let node = |end: Option<usize>| end.unwrap_or(world);
        let mut part: Vec<usize> = (0..=world).collect();
        let mut used = vec![false; self.hinges.len()];
        for &hinge in preferred {
            let [a, b] = self.hinges[hinge].on.map(|(end, _)| part[node(end)]);
            if a != b {
                part.iter_mut().filter(|own| **own == a).for_each(|own| *own = b);
                used[hinge] = true;
            }
        }
        // Depth first.
        let (mut bodies, mut number) = (Vec::new(), vec![None; world]);
        let (mut angles, mut rates) = (Vec::new(), Vec::new());
        let mut waiting: Vec<(usize, usize)> = Vec::new();
        let next = |from: usize, waiting: &mut Vec<(usize, usize)>| {
            let at =
                |hinge: &&usize| used[**hinge] && self.hinges[**hinge].on.iter().any(|(end, _)| node(*end) == from);
            waiting.extend(preferred.iter().filter(at).map(|&hinge| (from, hinge)));
        };
        next(world, &mut waiting);
        let at = |[x, y]: [f64; 2]| Pose::translation(x, y, 0.0);
        while let Some((from, hinge)) = waiting.pop() {
            let Hinge { name, on } = &self.hinges[hinge];
            let forwards = node(on[0].0) == from;
            let (parent, child) = if forwards { (on[0], on[1]) } else { (on[1], on[0]) };
            let Some(rod) = child.0.filter(|&rod| number[rod].is_none()) else { continue };
            let above = parent.0.map_or((0.0, 0.0), |above: usize| (self.rods[above].angle, self.rods[above].rate));
            angles.push(self.rods[rod].angle - above.0);
            rates.push(self.rods[rod].rate - above.1);
            number[rod] = Some(bodies.len());
            bodies.push(Body {
                name: self.rods[rod].name.clone(),
                parent: parent.0.and_then(|above| number[above]),
                mass: 1.0,
                inertia: Vector3::new(1e-3, 1.0 / 12.0, 1.0 / 12.0),
                joint: Joint::new(name, JointKind::Revolute, at(parent.1), at(child.1)),
            });
            next(rod, &mut waiting);
        }
        let mut mechanism = Mechanism::new("linkage", Vector3::new(0.0, -9.81, 0.0), bodies).unwrap();
        for (hinge, _) in self.hinges.iter().zip(&used).filter(|(_, used)| !**used) {
            let [a, b] =
                hinge.on.map(|(end, place)| Attachment { body: end.and_then(|rod| number[rod]), frame: at(place) });
            mechanism.loops.push(LoopJoint { name: hinge.name.clone(), kind: LoopKind::Revolute, a, b });
        }
        let mut state = State::zero(&mechanism);
        (state.position, state.velocity) = (angles, rates);
        (mechanism, state)
    }

    /// The hinges in an order: those whose names begin so come first, then the others as they are listed.
    pub fn first(&self, names: &[&str]) -> Vec<usize> {
        let rank = |hinge: &usize| names.iter().position(|name| self.hinges[*hinge].name.starts_with(name));
        let mut all: Vec<usize> = (0..self.hinges.len()).collect();
        all.sort_by_key(|hinge| rank(hinge).unwrap_or(names.len()));
        all
    }
}

/// A row of four-bars as a path: only the first crank is on the ground in the tree, all others are pinned to it by loops.
pub fn path(count: usize, speed: f64) -> (Mechanism, State) {
    let row = Linkage::four_bars(count, speed, true);
    row.written(&row.first(&["pin0", "elbow", "knee"]))
}
