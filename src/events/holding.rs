//! The efforts λ that hold joints at an instant, at the level of accelerations.
//!
//! With the accelerations `a` of what moves (zero for what is held), Newton and Euler on the whole tree give the effort that each joint needs;
//! what is not from its forces is what holds it:
//!
//! ```text
//!     no loops:   λ_i = Σ_j m_j (z_j · (reaction of joint j for a) − τ_j)    z_j its axis, τ_j springs, loads and efforts
//!     loops:      D λ = −b,   D = W Y Wᵀ,  b = W a_free                      W: rows of the held freedoms
//! ```
//!
//! with the sum over the joint and all that follow it by ratios m_j. Where D is singular λ is not unique, and the question is whether any admissible λ exists:
//!
//! ```text
//!     margin = max m    subject to  D λ = −b,   lo_i + m w_i ≤ λ_i ≤ hi_i − m w_i       w_i = τ_f,i, or the size of the load
//! ```
//!
//! a linear programme, solved by clarabel. Source of the tree: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, section 5.3.

use crate::events::held::Held as Moving;
use crate::events::mode::{JointMode, Mode};
use crate::instant::bounded;
use crate::instant::elements::Elements;
use crate::instant::response::Response;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::joint::JointKind;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::forces::total::{BodyWrench, body_wrenches, joint_efforts};
use crate::mechanism::motion::kinematics::{BodyAcceleration, body_accelerations, place_bodies};
use crate::mechanism::motion::state::State;
use crate::reduced::{Reaction, reactions_under};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use nalgebra::DMatrix;

/// Held joints whose response is singular to this part are held more than once.
const SINGULAR: f64 = 1e-10;

/// Roundings of an effort, relative to what it is the difference of.
const ROUNDING: f64 = 2e-15;

/// A mechanism, its elements, what they do, and what moves while they do it.
#[derive(Clone, Copy)]
pub(crate) struct Present<'p> {
    pub whole: &'p Mechanism,
    pub elements: &'p Elements,
    pub mode: &'p Mode,
    pub moving: &'p Moving,
}

/// Works out what holds the joints of one mode.
pub(crate) struct Holding {
    /// Index among the elements, and degree of freedom, of each held joint.
    joints: Vec<(usize, usize)>,
    /// λ of every element joint; zero for those that are free.
    efforts: Vec<f64>,
    /// The size of what each of them is the difference of.
    sizes: Vec<f64>,
    /// m.
    margin: f64,
    how: How,
}

enum How {
    /// Nothing is held.
    Nothing,
    /// In a tree.
    Tree(Box<Tree>),
    /// With closures, and whether λ is unique.
    Closed { unique: bool },
}

/// The workspace for a tree.
struct Tree {
    /// Of what moves.
    response: Response,
    small: State,
    small_efforts: Vec<f64>,
    small_accelerations: Vec<f64>,
    accelerations: Vec<f64>,
    bodies: Vec<BodyState>,
    motion: Vec<BodyAcceleration>,
    applied: Vec<BodyWrench>,
    reactions: Vec<Reaction>,
    own: Vec<f64>,
}

impl Holding {
    /// For a mode in a state, and what moves in it.
    pub fn new(at: &Present, response: &mut Response, state: &State) -> Self {
        let Present { whole, elements, mode, moving } = *at;
        let joints: Vec<(usize, usize)> = (elements.joints.iter().zip(&mode.joints).enumerate())
            .filter(|(_, (_, mode))| matches!(mode, JointMode::Held { .. }))
            .map(|(index, (joint, _))| (index, joint.coordinate.freedom))
            .collect();
        let how = if joints.is_empty() {
            How::Nothing
        } else if !whole.loops.is_empty() {
            let freedoms: Vec<usize> = joints.iter().map(|&(_, freedom)| freedom).collect();
            How::Closed { unique: is_regular(&response.matrix(state, &freedoms).1) }
        } else {
            // Motors act through the efforts that are handed over, not as forces of what moves.
            let mut bare = moving.mechanism.clone();
            bare.forces.joint_springs.truncate(count_springs(whole, moving));
            bare.forces.joint_dampers.truncate(count_dampers(whole, moving));
            let count = whole.bodies.len();
            How::Tree(Box::new(Tree {
                response: Response::new(&bare),
                small: State::zero(&bare),
                small_efforts: vec![0.0; bare.velocity_count],
                small_accelerations: vec![0.0; bare.velocity_count],
                accelerations: vec![0.0; whole.velocity_count],
                bodies: vec![WORLD; count],
                motion: vec![BodyAcceleration::default(); count],
                applied: vec![BodyWrench::default(); count],
                reactions: vec![Reaction::default(); count],
                own: vec![0.0; whole.velocity_count],
            }))
        };
        let nothing = vec![0.0; elements.joints.len()];
        Holding { joints, efforts: nothing.clone(), sizes: nothing, margin: f64::INFINITY, how }
    }

    /// Whether the efforts are unique.
    pub fn is_unique(&self) -> bool {
        !matches!(self.how, How::Closed { unique: false })
    }

    /// λ of a joint [N m or N].
    pub fn of(&self, joint: usize) -> f64 {
        self.efforts[joint]
    }

    /// What its roundings may be [N m or N].
    pub fn rounding(&self, joint: usize) -> f64 {
        ROUNDING * self.sizes[joint].max(1.0)
    }

    /// m: positive while some efforts can hold all.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// Works them out for a state of the whole under efforts from outside, of friction and of motors: one entry a degree of freedom.
    pub fn evaluate(&mut self, at: &Present, response: &mut Response, state: &State, efforts: &[f64]) {
        let Present { whole, elements, mode, moving } = *at;
        let Holding { joints, efforts: found, sizes, margin, how } = self;
        match how {
            How::Nothing => {}
            How::Tree(tree) => {
                tree.evaluate(whole, moving, state, efforts);
                for &(joint, _) in joints.iter() {
                    // What follows a joint hands on what it needs by their ratio.
                    (found[joint], sizes[joint]) = (0.0, 0.0);
                    for member in &elements.joints[joint].members {
                        let at = member.coordinate;
                        let (needed, size) = tree.needed(whole, at.body);
                        found[joint] += member.factor * (needed - efforts[at.freedom]);
                        sizes[joint] += member.factor.abs() * (size + efforts[at.freedom].abs());
                    }
                }
            }
            How::Closed { unique } => {
                let freedoms: Vec<usize> = joints.iter().map(|&(_, freedom)| freedom).collect();
                let (_, square) = response.matrix(state, &freedoms);
                let mut free = vec![0.0; whole.velocity_count];
                response.accelerations(state, efforts, &mut free);
                let offset: Vec<f64> = freedoms.iter().map(|&freedom| free[freedom]).collect();
                let unbounded = vec![(f64::NEG_INFINITY, f64::INFINITY); freedoms.len()];
                let least = bounded::minimise(&square, &offset, &unbounded).efforts;
                for (&(joint, _), effort) in joints.iter().zip(&least) {
                    found[joint] = *effort;
                }
                if !*unique {
                    let bounds: Vec<(f64, f64)> =
                        joints.iter().map(|&(joint, _)| mode.joints[joint].holding(&elements.joints[joint])).collect();
                    *margin = largest_margin(&square, &least, &bounds);
                }
            }
        }
    }
}

/// The springs and dampers of what moves that were forces of the whole: those of motors come after them.
fn count_springs(whole: &Mechanism, moving: &Moving) -> usize {
    whole.forces.joint_springs.iter().filter(|spring| moving.coordinate(whole, spring.coordinate).is_some()).count()
}

fn count_dampers(whole: &Mechanism, moving: &Moving) -> usize {
    let owner = |freedom: usize| whole.bodies.partition_point(|body| body.joint.velocity_index <= freedom) - 1;
    whole.forces.joint_dampers.iter().filter(|damper| !moving.is_held[owner(damper.freedom)]).count()
}

impl Tree {
    fn evaluate(&mut self, whole: &Mechanism, moving: &Moving, state: &State, efforts: &[f64]) {
        let Tree { response, small, small_efforts, small_accelerations, accelerations, .. } = self;
        if !moving.is_empty() {
            moving.gather_positions(whole, &state.position, &mut small.position);
            moving.gather_positions(whole, &state.compensation, &mut small.compensation);
            moving.gather_velocities(whole, &state.velocity, &mut small.velocity);
            moving.gather_velocities(whole, efforts, small_efforts);
            response.accelerations(small, small_efforts, small_accelerations);
        }
        moving.spread_velocities(whole, small_accelerations, accelerations);
        let Tree { bodies, motion, applied, reactions, own, .. } = self;
        place_bodies(whole, state, bodies);
        body_accelerations(whole, bodies, &state.velocity, &self.accelerations, motion);
        body_wrenches(whole, bodies, applied);
        reactions_under(whole, bodies, motion, applied, reactions);
        joint_efforts(whole, &state.position, &state.velocity, own);
    }

    /// What the joint of a body has to carry along its axis besides its own springs and loads, and the size of all that it carries.
    fn needed(&self, whole: &Mechanism, body: usize) -> (f64, f64) {
        let joint = &whole.bodies[body].joint;
        let axis = self.bodies[body].rotation * joint.on_child.rotation.matrix().column(2);
        let Reaction { force, torque, .. } = &self.reactions[body];
        let carried = if joint.kind == JointKind::Prismatic { axis.dot(force) } else { axis.dot(torque) };
        let size = if joint.kind == JointKind::Prismatic { force.norm() } else { torque.norm() };
        (carried - self.own[joint.velocity_index], size + self.own[joint.velocity_index].abs())
    }
}

/// Whether a response is regular, whatever the units of its rows.
fn is_regular(square: &DMatrix<f64>) -> bool {
    let scale: Vec<f64> = (0..square.nrows()).map(|row| square[(row, row)].max(0.0).sqrt()).collect();
    if scale.contains(&0.0) {
        return false;
    }
    let scaled = DMatrix::from_fn(square.nrows(), square.ncols(), |row, column| {
        square[(row, column)] / (scale[row] * scale[column])
    });
    let values = scaled.symmetric_eigenvalues();
    values.min() > SINGULAR * values.max()
}

/// The largest margin of efforts that hold what `least` holds: over `λ = least + n`, `D n = 0`.
fn largest_margin(square: &DMatrix<f64>, least: &[f64], bounds: &[(f64, f64)]) -> f64 {
    let count = least.len();
    let size = least.iter().fold(0.0_f64, |most, effort| most.max(effort.abs())).max(f64::MIN_POSITIVE);
    let weight = |&(low, high): &(f64, f64)| match (low.abs(), high.abs()) {
        (low, high) if low.is_finite() && low > 0.0 => {
            if high.is_finite() {
                low.min(high)
            } else {
                low
            }
        }
        (_, high) if high.is_finite() && high > 0.0 => high,
        _ => size,
    };
    // Unknowns: the coefficients of the null vectors of D, and m.
    let eigen = square.clone().symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let null: Vec<usize> = (0..count).filter(|&index| eigen.eigenvalues[index] <= SINGULAR * largest).collect();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut limits: Vec<f64> = Vec::new();
    for index in 0..count {
        let along =
            |sign: f64| null.iter().map(|&vector| sign * eigen.eigenvectors[(index, vector)]).collect::<Vec<f64>>();
        let (low, high) = bounds[index];
        for (finite, sign, room) in
            [(high.is_finite(), 1.0, high - least[index]), (low.is_finite(), -1.0, least[index] - low)]
        {
            if finite {
                let mut row = along(sign);
                row.push(weight(&bounds[index]));
                rows.push(row);
                limits.push(room);
            }
        }
    }
    if rows.is_empty() {
        return f64::INFINITY;
    }
    let mut objective = vec![0.0; null.len() + 1];
    objective[null.len()] = -1.0;
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-13,
        tol_gap_rel: 1e-13,
        tol_feas: 1e-13,
        ..DefaultSettings::default()
    };
    let solver = DefaultSolver::new(
        &CscMatrix::zeros((null.len() + 1, null.len() + 1)),
        &objective,
        &CscMatrix::from(&rows),
        &limits,
        &[SupportedConeT::NonnegativeConeT(rows.len())],
        settings,
    );
    let Ok(mut solver) = solver else { return f64::NEG_INFINITY };
    solver.solve();
    solver.solution.x.last().copied().unwrap_or(f64::NEG_INFINITY)
}
