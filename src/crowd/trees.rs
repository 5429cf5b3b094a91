//! The trees of a mechanism without loops, each with its mass matrix in joint rates.
//!
//! ```text
//!     v(x) = Σ_j (l_j + ω_j × (x − x₀)) q̇_j          freedoms j on the path to a body; x₀: the root of the tree (m)
//!     M_ij = l_i · p_j + ω_i · L_j,    p_j = m l_j + ω_j × s,    L_j = s × l_j + Θ ω_j
//!     M_jj += A_j                                    rotor of joint j, A_j: its reflected inertia [kg m² or kg]
//!     M̃ = M + b D + b² K = L Lᵀ                      damping D and stiffness K within a step, b: the time in which they act (s)
//! ```
//!
//! `m`, `s` and `Θ` are mass, first moment and inertia about x₀ of all bodies beyond freedom j (composite bodies). Trees that touch share no freedoms.
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 6.

use catena_mechanism::description::body_state::{BodyState, WORLD};
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use nalgebra::{Matrix3, Vector3};

/// All trees.
#[derive(Clone)]
pub struct Trees {
    pub trees: Vec<Tree>,
    /// The tree of each body.
    pub of_body: Vec<usize>,
    /// The tree of each freedom, and its number there.
    pub of_freedom: Vec<(usize, usize)>,
    /// The freedoms on the path from the root to each body, by their numbers in the tree.
    pub paths: Vec<Vec<usize>>,
    /// The motion that each freedom gives: `l` [m/s] and `ω` [rad/s].
    motions: Vec<(Vector3<f64>, Vector3<f64>)>,
    composite: Vec<Composite>,
}

/// One tree.
#[derive(Clone, Default)]
pub struct Tree {
    pub bodies: Vec<usize>,
    /// Its freedoms by their numbers in the mechanism.
    pub freedoms: Vec<usize>,
    /// x₀.
    pub root: Vector3<f64>,
    /// M, and the factor L of M̃, row by row.
    pub mass: Vec<f64>,
    pub softened: Vec<f64>,
    factor: Vec<f64>,
    /// The inverses of the diagonal entries of L.
    reciprocals: Vec<f64>,
    /// M̃⁻¹ of a free body, which is asked for most often.
    inverse: Option<[[f64; 6]; 6]>,
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
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let number = body.parent.map_or(own.trees.len(), |parent| own.of_body[parent]);
            if number == own.trees.len() {
                own.trees.push(Tree::default());
            }
            let tree = &mut own.trees[number];
            let mut path = body.parent.map_or_else(Vec::new, |parent| own.paths[parent].clone());
            for freedom in body.joint.velocity_range() {
                path.push(tree.freedoms.len());
                own.of_freedom[freedom] = (number, tree.freedoms.len());
                tree.freedoms.push(freedom);
            }
            tree.bodies.push(index);
            own.of_body.push(number);
            own.paths.push(path);
        }
        for tree in &mut own.trees {
            let size = tree.freedoms.len().pow(2);
            (tree.mass, tree.softened, tree.factor) = (vec![0.0; size], vec![0.0; size], vec![0.0; size]);
            tree.reciprocals = vec![0.0; tree.freedoms.len()];
        }
        own
    }

    /// Takes the poses of all bodies: the motions of the freedoms, and M.
    pub fn place(&mut self, mechanism: &Mechanism, bodies: &[BodyState]) {
        let Trees { trees, of_body, of_freedom, paths, motions, composite } = self;
        for tree in trees.iter_mut() {
            tree.root = tree.bodies.first().map_or(Vector3::zeros(), |&body| bodies[body].position);
            tree.mass.fill(0.0);
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
        for (index, body) in mechanism.bodies.iter().enumerate().rev() {
            let own = composite[index];
            let tree = &mut trees[of_body[index]];
            let count = tree.freedoms.len();
            for freedom in body.joint.velocity_range() {
                let (linear, turn) = motions[freedom];
                let momentum = own.mass * linear + turn.cross(&own.moment);
                let spin = own.moment.cross(&linear) + own.inertia * turn;
                let column = of_freedom[freedom].1;
                for &row in paths[index].iter().take_while(|row| **row <= column) {
                    let (linear, turn) = motions[tree.freedoms[row]];
                    let entry = linear.dot(&momentum) + turn.dot(&spin);
                    tree.mass[row * count + column] = entry;
                    tree.mass[column * count + row] = entry;
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
            tree.mass[own * (tree.freedoms.len() + 1)] += armature;
        }
    }

    /// The entries of a row for the freedoms on the way to a body: the work of a unit force along a direction at a point.
    pub fn row<'t>(
        &'t self,
        body: usize,
        point: &Vector3<f64>,
        along: &Vector3<f64>,
    ) -> impl Iterator<Item = f64> + use<'t> {
        let tree = &self.trees[self.of_body[body]];
        let (torque, along) = ((point - tree.root).cross(along), *along);
        self.paths[body].iter().map(move |&freedom| {
            let (linear, turn) = &self.motions[tree.freedoms[freedom]];
            linear.dot(&along) + turn.dot(&torque)
        })
    }
}

impl Tree {
    /// Factors M̃ for dampings and stiffnesses of the freedoms of the mechanism, which act for a time (s); `false` if it is singular.
    pub fn factor(&mut self, time: f64, damping: &[f64], stiffness: &[f64]) -> bool {
        let count = self.freedoms.len();
        self.softened.copy_from_slice(&self.mass);
        for (own, &freedom) in self.freedoms.iter().enumerate() {
            self.softened[own * count + own] += time * (damping[freedom] + time * stiffness[freedom]);
        }
        for row in 0..count {
            for column in 0..=row {
                let (upper, lower) = self.factor.split_at(row * count);
                let left = &lower[..column];
                let other = if column == row { left } else { &upper[column * count..column * count + column] };
                let sum = left.iter().zip(other).fold(self.softened[row * count + column], |sum, (a, b)| sum - a * b);
                let entry = if column < row {
                    sum * self.reciprocals[column]
                } else if sum > 0.0 {
                    self.reciprocals[row] = 1.0 / sum.sqrt();
                    sum.sqrt()
                } else {
                    return false;
                };
                self.factor[row * count + column] = entry;
            }
        }
        self.inverse = None;
        if self.freedoms.len() == 6 && self.bodies.len() == 1 {
            let mut inverse = [[0.0; 6]; 6];
            for (row, entries) in inverse.iter_mut().enumerate() {
                entries[row] = 1.0;
                self.solve(entries);
            }
            self.inverse = Some(inverse);
        }
        true
    }

    /// x ← M̃⁻¹ x.
    pub fn solve(&self, x: &mut [f64]) {
        if let (Some(inverse), Ok(x)) = (&self.inverse, <&mut [f64; 6]>::try_from(&mut *x)) {
            // It is symmetric: rows are columns.
            let mut sums = [0.0; 6];
            for (row, entry) in inverse.iter().zip(x.iter()) {
                (0..6).for_each(|column| sums[column] += row[column] * entry);
            }
            *x = sums;
            return;
        }
        self.solve_lower(x);
        let count = self.freedoms.len();
        for row in (0..count).rev() {
            let value = x[row] * self.reciprocals[row];
            x[row] = value;
            let (before, own) = (&mut x[..row], &self.factor[row * count..row * count + row]);
            before.iter_mut().zip(own).for_each(|(entry, factor)| *entry -= factor * value);
        }
    }

    /// x ← L⁻¹ x.
    pub fn solve_lower(&self, x: &mut [f64]) {
        let count = self.freedoms.len();
        for row in 0..count {
            let own = &self.factor[row * count..row * count + row];
            let sum = own.iter().zip(&x[..row]).fold(x[row], |sum, (factor, entry)| sum - factor * entry);
            x[row] = sum * self.reciprocals[row];
        }
    }

    /// y ← y + M̃ x.
    pub fn add_softened(&self, x: &[f64], y: &mut [f64]) {
        multiply_add(&self.softened, x, y);
    }

    /// y ← y + M x.
    pub fn add_mass(&self, x: &[f64], y: &mut [f64]) {
        multiply_add(&self.mass, x, y);
    }
}

fn multiply_add(matrix: &[f64], x: &[f64], y: &mut [f64]) {
    for (row, sum) in matrix.chunks_exact(x.len().max(1)).zip(y) {
        *sum += row.iter().zip(x).map(|(entry, x)| entry * x).sum::<f64>();
    }
}
