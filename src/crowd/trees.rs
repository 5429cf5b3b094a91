//! The trees of a mechanism, each with its mass matrix in independent joint rates. Trees that closures connect are one.
//!
//! ```text
//!     v(x) = Σ_j (l_j + ω_j × (x − x₀)) q̇_j          freedoms j on the path to a body; x₀: the root of the tree (m)
//!     M_ij = l_i · p_j + ω_i · L_j,    p_j = m l_j + ω_j × s,    L_j = s × l_j + Θ ω_j
//!     M_jj += A_j                                    rotor of joint j, A_j: its reflected inertia [kg m² or kg]
//! ```
//!
//! `m`, `s` and `Θ` are mass, first moment and inertia about x₀ of all bodies beyond freedom j (composite bodies). Trees that touch share no freedoms.
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 6.

use crate::closures::{Closures, Motions};
use crate::tree::Tree;
use catena_mechanism::description::body_state::{BodyState, WORLD};
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::kinematics::place_bodies;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::islands::first_of_connected;
use nalgebra::{Matrix3, Vector3};

/// Loops are closed up to this [m or rad] in so many rounds at most.
const CLOSED: f64 = 1e-14;
const ROUNDS: usize = 8;
/// A change that is no smaller than half the last one, and below this, is rounding.
const ROUNDING: f64 = 1e-12;

/// All trees.
#[derive(Clone)]
pub struct Trees {
    pub trees: Vec<Tree>,
    /// The tree of each body.
    pub of_body: Vec<usize>,
    /// The tree of each freedom, and its number among all of that.
    pub of_freedom: Vec<(usize, usize)>,
    /// The freedoms on the path from the root to each body, by their numbers among all of the tree.
    pub paths: Vec<Vec<usize>>,
    /// The motion that each freedom gives: `l` [m/s] and `ω` [rad/s].
    motions: Vec<(Vector3<f64>, Vector3<f64>)>,
    composite: Vec<Composite>,
}

/// Mass, first moment and inertia of a body with all beyond it.
#[derive(Clone, Copy, Default)]
struct Composite {
    mass: f64,
    moment: Vector3<f64>,
    inertia: Matrix3<f64>,
}

impl Trees {
    pub fn new(mechanism: &Mechanism) -> Self {
        let count = mechanism.velocity_count;
        let mut own = Trees {
            trees: Vec::new(),
            of_body: Vec::new(),
            of_freedom: vec![(0, 0); count],
            paths: Vec::new(),
            motions: vec![(Vector3::zeros(), Vector3::zeros()); count],
            composite: vec![Composite::default(); mechanism.bodies.len()],
        };
        let firsts = first_of_connected(mechanism);
        let mut numbers = vec![usize::MAX; mechanism.bodies.len()];
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let number = &mut numbers[firsts[index]];
            if *number == usize::MAX {
                *number = own.trees.len();
                own.trees.push(Tree::default());
            }
            let (number, tree) = (*number, &mut own.trees[*number]);
            let mut path = body.parent.map_or_else(Vec::new, |parent| own.paths[parent].clone());
            for freedom in body.joint.velocity_range() {
                path.push(tree.all.len());
                own.of_freedom[freedom] = (number, tree.all.len());
                tree.all.push(freedom);
            }
            tree.bodies.push(index);
            own.of_body.push(number);
            own.paths.push(path);
        }
        let tree_of_loop = |number: &usize| {
            let joint = &mechanism.loops[*number];
            joint.a.body.or(joint.b.body).map(|body| own.of_body[body])
        };
        let tree_of_mimic = |number: &usize| own.of_body[mechanism.mimics[*number].follower.body];
        for (number, tree) in own.trees.iter_mut().enumerate() {
            let loops: Vec<usize> =
                (0..mechanism.loops.len()).filter(|own| tree_of_loop(own) == Some(number)).collect();
            let mimics: Vec<usize> = (0..mechanism.mimics.len()).filter(|own| tree_of_mimic(own) == number).collect();
            if !loops.is_empty() || !mimics.is_empty() {
                let closures = Closures::new(mechanism, &tree.all, [&loops, &mimics], &own.paths);
                tree.closures = Some(Box::new(closures));
                tree.unclosed = vec![0.0; tree.all.len().pow(2)];
            }
            let independent = tree.closures.as_ref().map(|closures| closures.independent());
            tree.lay_out(independent.unwrap_or_else(|| (0..tree.all.len()).collect()));
        }
        own
    }

    /// Takes the poses of all bodies and chooses the independent rates there: the motions of the freedoms, and M.
    pub fn choose(&mut self, mechanism: &Mechanism, bodies: &[BodyState]) {
        self.place_motions(mechanism, bodies);
        for tree in 0..self.trees.len() {
            let mut independent = None;
            self.with_loops(tree, |closures, motions| {
                closures.choose(bodies, motions);
                independent = Some(closures.independent());
            });
            if let Some(independent) = independent {
                self.trees[tree].lay_out(independent);
            }
        }
        self.weigh(mechanism);
    }

    /// Takes the poses of all bodies: the motions of the freedoms, and M in the rates that were chosen last.
    pub fn place(&mut self, mechanism: &Mechanism, bodies: &[BodyState]) {
        self.place_for_rows(mechanism, bodies);
        self.weigh(mechanism);
    }

    /// The same without M, which rows do not need.
    pub fn place_for_rows(&mut self, mechanism: &Mechanism, bodies: &[BodyState]) {
        self.place_motions(mechanism, bodies);
        for tree in 0..self.trees.len() {
            self.with_loops(tree, |closures, motions| closures.place(bodies, motions));
        }
    }

    /// Whether the independent rates of some trees are chosen.
    pub fn have_choices(&self) -> bool {
        self.trees.iter().any(|tree| tree.ways().is_some())
    }

    /// Whether some loops change with the positions.
    pub fn have_loops(&self) -> bool {
        self.trees.iter().filter_map(|tree| tree.closures.as_ref()).any(|closures| closures.change())
    }

    /// Closes the loops of a state that places the bodies, with its dependent coordinates; trees are placed there, without their M. Returns whether all
    /// are closed.
    pub fn close(&mut self, mechanism: &Mechanism, state: &mut State, bodies: &mut [BodyState]) -> bool {
        if !self.have_loops() {
            return true;
        }
        let mut last = f64::INFINITY;
        for _ in 0..ROUNDS {
            self.place_motions(mechanism, bodies);
            let (mut moved, mut largest) = (vec![0.0; state.velocity.len()], 0.0_f64);
            for tree in 0..self.trees.len() {
                let mut changes = Vec::new();
                self.with_loops(tree, |closures, motions| {
                    changes.extend(closures.gaps(mechanism, state, bodies, motions));
                });
                for (column, change) in changes {
                    moved[self.trees[tree].all[column]] = change;
                    largest = if change.is_nan() { f64::NAN } else { largest.max(change.abs()) };
                }
            }
            if largest <= CLOSED || largest <= ROUNDING && largest > 0.5 * last {
                return self.trees.iter().all(Tree::is_fit);
            }
            if largest.is_nan() || !self.trees.iter().all(Tree::is_fit) {
                return false;
            }
            last = largest;
            state.displace(mechanism, &moved);
            place_bodies(mechanism, state, bodies);
        }
        false
    }

    /// Closes the loops of a state that places the bodies, and makes its rates follow the independent ones; these trees stay where they are. Returns whether
    /// all loops are closed.
    pub fn close_beside(&self, mechanism: &Mechanism, state: &mut State, bodies: &mut [BodyState]) -> bool {
        if !self.have_loops() {
            return true;
        }
        let mut there = self.clone();
        let closed = there.close(mechanism, state, bodies);
        there.place_for_rows(mechanism, bodies);
        there.complete(&mut state.velocity);
        closed
    }

    /// Writes the rates of dependent freedoms, which follow from the independent ones.
    pub fn complete(&self, rates: &mut [f64]) {
        self.trees.iter().for_each(|tree| tree.complete(rates));
    }

    /// Writes the independent rates of some trees, one after the other, among the rates of all freedoms, and those of the freedoms that follow them.
    pub fn spread(&self, members: &[usize], own: &[f64], rates: &mut [f64]) {
        let freedoms = members.iter().flat_map(|&tree| &self.trees[tree].freedoms);
        freedoms.zip(own).for_each(|(&freedom, rate)| rates[freedom] = *rate);
        members.iter().for_each(|&tree| self.trees[tree].complete(rates));
    }

    /// Shows the closures of a tree the motions of its freedoms, if some of them are loops.
    fn with_loops(&mut self, tree: usize, mut see: impl FnMut(&mut Closures, &Motions)) {
        let Trees { trees, motions, .. } = self;
        let Tree { closures, all, root, .. } = &mut trees[tree];
        if let Some(closures) = closures.as_mut().filter(|closures| closures.change()) {
            see(closures, &Motions { root: *root, of_column: &|column| motions[all[column]] });
        }
    }

    /// Takes the motions of the freedoms and the inertias of single bodies.
    fn place_motions(&mut self, mechanism: &Mechanism, bodies: &[BodyState]) {
        let Trees { trees, of_body, motions, composite, .. } = self;
        for tree in trees.iter_mut() {
            tree.root = tree.bodies.first().map_or(Vector3::zeros(), |&body| bodies[body].position);
        }
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let (joint, at) = (&body.joint, &bodies[index]);
            let root = trees[of_body[index]].root;
            let parent = body.parent.map_or(&WORLD, |parent| &bodies[parent]);
            let on_parent = parent.rotation * joint.on_parent.rotation.matrix();
            let on_child = at.rotation * joint.on_child.rotation.matrix();
            let anchor = at.position + at.rotation * joint.on_child.translation.vector;
            let axes = joint.kind.translation_axes();
            let first = joint.velocity_index;
            for (offset, &axis) in axes.iter().enumerate() {
                motions[first + offset] = (on_parent.column(axis).into_owned(), Vector3::zeros());
            }
            let turns: &[usize] = match joint.kind.rotation() {
                FreeRotation::None => &[],
                FreeRotation::AboutZ => &[2],
                FreeRotation::Ball => &[0, 1, 2],
            };
            for (offset, &axis) in turns.iter().enumerate() {
                let turn = on_child.column(axis).into_owned();
                motions[first + axes.len() + offset] = (turn.cross(&(root - anchor)), turn);
            }
            let arm = at.position - root;
            let square = Matrix3::identity() * arm.norm_squared() - arm * arm.transpose();
            composite[index] = Composite {
                mass: body.mass,
                moment: body.mass * arm,
                inertia: at.rotation * Matrix3::from_diagonal(&body.inertia) * at.rotation.transpose()
                    + body.mass * square,
            };
        }
    }

    /// Works out M where the motions are placed; composite bodies then have the inertias.
    fn weigh(&mut self, mechanism: &Mechanism) {
        let Trees { trees, of_body, of_freedom, paths, motions, composite } = self;
        for tree in trees.iter_mut() {
            tree.of_all().fill(0.0);
        }
        for (index, body) in mechanism.bodies.iter().enumerate().rev() {
            let own = composite[index];
            let tree = &mut trees[of_body[index]];
            let count = tree.all.len();
            for freedom in body.joint.velocity_range() {
                let (linear, turn) = motions[freedom];
                let momentum = own.mass * linear + turn.cross(&own.moment);
                let spin = own.moment.cross(&linear) + own.inertia * turn;
                let column = of_freedom[freedom].1;
                for &row in paths[index].iter().take_while(|row| **row <= column) {
                    let (linear, turn) = motions[tree.all[row]];
                    let entry = linear.dot(&momentum) + turn.dot(&spin);
                    let mass = tree.of_all();
                    mass[row * count + column] = entry;
                    mass[column * count + row] = entry;
                }
            }
            if let Some(parent) = body.parent {
                let onto = &mut composite[parent];
                onto.mass += own.mass;
                onto.moment += own.moment;
                onto.inertia += own.inertia;
            }
        }
        for (freedom, armature) in mechanism.rotors() {
            let (number, own) = of_freedom[freedom];
            let tree = &mut trees[number];
            let count = tree.all.len();
            tree.of_all()[own * (count + 1)] += armature;
        }
        trees.iter_mut().for_each(Tree::gather_mass);
    }

    /// The entries of a row for all freedoms on the way to a body: the work of a unit force along a direction at a point.
    pub fn row<'t>(
        &'t self,
        body: usize,
        point: &Vector3<f64>,
        along: &Vector3<f64>,
    ) -> impl Iterator<Item = f64> + use<'t> {
        let tree = &self.trees[self.of_body[body]];
        let (torque, along) = ((point - tree.root).cross(along), *along);
        self.paths[body].iter().map(move |&freedom| {
            let (linear, turn) = &self.motions[tree.all[freedom]];
            linear.dot(&along) + turn.dot(&torque)
        })
    }
}
