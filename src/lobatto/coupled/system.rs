//! The exact Newton step, with all stages coupled: for closed loops, and for steps on which the simplified iteration does not converge.
//!
//! Newton's method on the stage equations with the multipliers of the closures, `λ_k = h² Λ_k`, all rows k and unknown stages i at once. Let η be the
//! twists about a common origin. For every body, joint axis and closure
//!
//! ```text
//!     Σ_i D_ki η_i − J_kᵀ dλ_k = −(E_k − J_kᵀ λ_k)         rows: projected on the joint axes s_k at the rows' stages
//!     J_i η_i + ε Σ_k Â_ik dλ_k = −g_i                     η_body = η_parent + s_i δ_i
//! ```
//!
//! with the mass blocks D, screws s and gradients J of a [`Geometry`]: [`crate::coupled::space`], where twists have six components, or
//! [`crate::planar::geometry`], where they have three. The elimination is in `operations`, step by step.
//!
//! ε acts on the increments only (proximal): converged gaps are zero whatever it is, and redundant equations need no decision about rank. The
//! multipliers start from zero in every step, so that undetermined parts of them are not carried on. The curvature `d(Jᵀλ)` is left out: the mass
//! matrix is exact, with the geometry of every stage, and increments fall by a factor at each iteration, not quadratically.
//!
//! For one stage, `B = Â = 1`, the same system projects velocities and positions on the closures ([`crate::coupled::projection`]).

use crate::coupled::dependent::Dependent;
use crate::coupled::front::{Fronts, Screws};
use crate::coupled::given::weights;
use crate::coupled::known::Known;
use crate::coupled::mixing::Mixing;
use crate::coupled::touching::Touching;
use crate::numbers::lanes::{Lanes, MAX_LANES, in_lanes};
use crate::plan::elimination::{Elimination, Operation, TWIST};
use crate::plan::tree::Plan;
use crate::tableau::butcher::Tableau;
use crate::vectors::portable::Portable;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::state::State;

/// One configuration, where a step has a lane for each stage.
pub type One = Portable<1>;

/// ε of all solves: large against the square of the gaps that iterates leave, small against weak mobilities.
pub const PROXIMAL: f64 = 1e-8;

/// ε of equations that others imply in the run. Iterates leave gaps in them that cannot be closed, and ε divides these gaps. The ε of the other
/// equations would make undetermined multipliers a million times as large as the constraint forces of the mechanism, and their roundings move it.
pub const IMPLIED: f64 = 1e-2;

/// ε of contacts of which some imply others through joints or around several trees. The elimination rounds their gaps, and ε divides this rounding to a
/// force that friction feels; a body alone has less rounding.
pub const SHARED: f64 = 1e-6;

/// A force and its torque about the common origin, or a twist, in the first components: six of them in space, three in a plane.
pub type Screw<V> = [V; TWIST];

/// Tangents that normals imply have ε this many times that of other implied equations, in masses of their bodies: they bear 1e-10 of a load that normals
/// share with them.
const LOOSE: f64 = 1e4;

/// The geometry of the system: the bodies and closures of a mechanism in space, or in a plane.
pub trait Geometry<V: Lanes> {
    /// Constants of the mechanism.
    type Plan: Clone + Send + Sync;
    /// The known start of a step.
    type Start: Clone + Send + Sync;
    /// Number of components of a twist.
    const WIDTH: usize;

    /// Which bodies hang where.
    fn tree(plan: &Self::Plan) -> &Plan;
    /// Room for the start of a step.
    fn start(mechanism: &Mechanism) -> Self::Start;
    /// Takes a state as the start of a step.
    fn place(plan: &Self::Plan, start: &mut Self::Start, mechanism: &Mechanism, state: &State);
    /// `q_follower − multiplier · q_leader − offset` of every mimic at the start.
    fn mimic_gaps(start: &Self::Start) -> &[f64];
    /// The rates of joints that are moved in time, one entry a mimic.
    fn mimic_rates(start: &Self::Start) -> &[f64];
    /// Number of equations of every loop, then of every contact.
    fn rows(&self) -> Vec<usize>;
    /// Takes the start of a step.
    fn begin(&mut self, plan: &Self::Plan, start: &Self::Start);
    /// Evaluates all loops, contacts and lines of springs, which have these rows: gaps, gradients at the columns' stages, and the directions in which
    /// multipliers push at the rows' stages.
    fn evaluate(&self, rows_of_loop: &[std::ops::Range<usize>], gaps: &mut [V], gradients: &mut [[Screw<V>; 2]]);
    /// The screw of a freedom at the rows' and the columns' stages; without displacements, at the start.
    fn screws(
        &self,
        plan: &Self::Plan,
        start: &Self::Start,
        displacement: &[V],
        body: usize,
        freedom: usize,
    ) -> Screws<V>;
    /// How much of the mobility of a body along a direction comes from turning it, as a part of that from shifting it, at the start.
    fn leverage(&self, _start: &Self::Start, _body: usize, _direction: &[f64; TWIST]) -> f64 {
        0.0
    }
    /// The closed contacts, where there are any.
    fn touching(&self) -> Option<&Touching<V>> {
        None
    }
    /// The same, to be told how they push.
    fn touching_mut(&mut self) -> Option<&mut Touching<V>> {
        None
    }
    /// Adds the mass blocks `D_ki` of a body to the twist part of a front.
    fn own(&self, start: &Self::Start, body: usize, mixing: &Mixing<V>, fronts: &mut Fronts<V>, level: usize);
}

/// Derivative of a force, row by row: `h² ∂F_k/∂y_i = −(stiffness h² 1 + damping h Ā B)_ki` for a scalar y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Resistance {
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
}

/// A body that a rope through several points pulls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReevedEnd {
    /// The equation of the rope.
    pub row: usize,
    /// The number of the gradient of the body, after the gradients of all rows.
    pub gradient: usize,
    /// The body.
    pub body: usize,
}

/// The linear system of a step, and its workspace.
#[derive(Clone)]
pub struct Coupled<V: Lanes> {
    pub(crate) elimination: Elimination,
    pub(crate) fronts: Fronts<V>,
    pub(crate) mixing: Mixing<V>,
    pub(crate) unit: [V; MAX_LANES],
    /// The rows of the loops and contacts, then of the springs, then of the friction that turns with the slip of contacts.
    pub(crate) rows_of_loop: Vec<std::ops::Range<usize>>,
    /// The bodies at their ends; none of a rope through several points, which has `reeved`.
    pub(crate) ends: Vec<[Option<usize>; 2]>,
    pub(crate) reeved: Vec<ReevedEnd>,
    pub(crate) loops: usize,
    /// The rows of the mimics; the rows of the springs' tensions come after them, and then the rows of turning friction.
    pub(crate) mimic_rows: std::ops::Range<usize>,
    /// Resistance of friction to the turning of slips, and of rolling, row by row: times h² and `Ā B` it is the change of the friction for a displacement across a
    /// slip [kg].
    pub(crate) turning_friction: Vec<V>,
    /// Change of the rates of rolling contacts besides their gradients, at both ends of a row, times `h a_ij`; `None` for all other rows.
    pub(crate) rolling: Vec<Option<[Screw<V>; 2]>>,
    /// Resistances of the point springs, and of every freedom's joint springs and dampers.
    pub(crate) resistances: Vec<Resistance>,
    pub(crate) in_joints: Vec<Resistance>,
    /// Inertia of the rotor of every freedom [kg m² or kg].
    pub(crate) rotors: Vec<f64>,
    /// Efforts along the freedoms, times h².
    pub efforts: Vec<V>,
    /// Length of the step (s).
    pub step: f64,
    /// ε, as a part of the mobility of an equation.
    pub proximal: f64,
    /// Ranks and flags of the closures from kinematics.
    pub known: Known,
    /// Residual of every body, about the common origin.
    pub bias: Vec<Screw<V>>,
    /// One entry a row: the direction in which its multiplier pushes on the second end of its loop, at the columns' and at the
    /// rows' stages. Then those in which ropes through several points pull each of their bodies.
    pub(crate) gradients: Vec<[Screw<V>; 2]>,
    /// The right-hand side of the closures.
    pub gaps: Vec<V>,
    /// `λ`, and its latest increment.
    pub multipliers: Vec<V>,
    pub(crate) multiplier_increments: Vec<V>,
    pub(crate) twists: Vec<Screw<V>>,
    pub(crate) screws: Vec<Screw<V>>,
    pub(crate) kept: Vec<V>,
    pub(crate) kept_at: Vec<usize>,
    /// First row of the inverse pivot of every operation.
    pub(crate) pivots: Vec<V>,
    /// Right-hand sides of the fronts, for another solve with the same factors.
    pub(crate) right: Vec<f64>,
    /// Mobility of every row in the direction of its own gradient, before the elimination of the other rows of its closure; for a row eliminated at
    /// its body the mobility of the body.
    pub(crate) scales: Vec<f64>,
    /// How easily a push from the world moves every body, for the equations that go there [1/kg].
    pub(crate) weights: Vec<f64>,
    /// Contacts of which some may imply others, with the value of ε for them [1/kg]; and the same for every row of such contacts.
    pub(crate) dependent: Vec<(Dependent, f64)>,
    /// Such contacts with the rows in which friction holds them.
    pub(crate) held: Vec<Dependent>,
    pub(crate) even: Vec<Option<f64>>,
    /// The mobility of the bodies of tangents that friction holds beside friction that brakes [1/kg], times [`LOOSE`], and zero for other rows. Beside a
    /// contact that was eliminated before, a row has hardly any mobility left, and a tangent would bear a part of the weight that the other contact
    /// carries.
    pub(crate) adhering: Vec<f64>,
    /// The same as the scales; a row with hardly any mobility has the largest scale of its closure.
    pub(crate) references: Vec<f64>,
    /// The mobility that the other rows leave, over the reference.
    pub left_over: Vec<f64>,
}

impl<V: Lanes> Coupled<V> {
    /// The system of a step of the scheme, with forces.
    pub fn of_stages<G: Geometry<V>>(mechanism: &Mechanism, geometry: &G, tableau: &Tableau) -> Self {
        Self::new(mechanism, G::WIDTH, &geometry.rows(), Mixing::of_stages(tableau), true)
    }

    /// The system of a projection at one configuration.
    pub fn of_one<G: Geometry<V>>(mechanism: &Mechanism, geometry: &G) -> Self {
        Self::new(mechanism, G::WIDTH, &geometry.rows(), Mixing::of_one(), false)
    }

    fn new(mechanism: &Mechanism, width: usize, rows: &[usize], mixing: Mixing<V>, forces: bool) -> Self {
        let elimination = Elimination::new(mechanism, width, rows, forces);
        let mut unit = [V::zero(); MAX_LANES];
        for (lane, unit) in unit[..mixing.active].iter_mut().enumerate() {
            let mut array = V::zero_array();
            array.as_mut()[lane] = 1.0;
            *unit = V::from_array(array);
        }
        let mut kept_at = Vec::with_capacity(elimination.operations.len());
        let mut kept = 0;
        for operation in &elimination.operations {
            kept_at.push(kept);
            if let Operation::Freedom { columns, .. } | Operation::Multiplier { columns, .. } = operation {
                kept += (columns.len() + 1) * V::COUNT;
            }
        }
        let mut rows_of_loop = Vec::new();
        let mut count = 0;
        let mut next = |rows: usize| {
            count += rows;
            count - rows..count
        };
        rows_of_loop.extend(rows.iter().map(|&rows| next(rows)));
        let mimic_rows = next(mechanism.mimics.len());
        let mut ends: Vec<_> = mechanism.closing_ends().map(|[a, b]| [a.body, b.body]).collect();
        let loops = ends.len();
        let touches = loops - mechanism.touches.len()..;
        let ropes = touches.zip(&mechanism.touches).filter(|(_, joint)| joint.is_reeved());
        let mut reeved = Vec::new();
        for (closure, joint) in ropes {
            ends[closure] = [None; 2];
            reeved.extend(joint.reeved_bodies().into_iter().map(|body| (rows_of_loop[closure].start, body)));
        }
        let mut resistances = Vec::new();
        let mut in_joints = vec![Resistance::default(); mechanism.velocity_count];
        if forces {
            for spring in &mechanism.forces.point_springs {
                rows_of_loop.push(next(1));
                ends.push([spring.a.body, spring.b.body]);
                resistances.push(Resistance { stiffness: spring.stiffness, damping: spring.damping });
            }
            for joint in mechanism.braked() {
                rows_of_loop.push(next(1));
                ends.push([joint.a.body, joint.b.body]);
            }
            for damper in &mechanism.forces.joint_dampers {
                in_joints[damper.freedom].damping += damper.coefficient;
            }
            for spring in &mechanism.forces.joint_springs {
                in_joints[spring.coordinate.freedom].stiffness += spring.stiffness;
            }
        }
        let mut rotors = vec![0.0; mechanism.velocity_count];
        mechanism.rotors().for_each(|(freedom, armature)| rotors[freedom] = armature);
        let (bodies, rows, nothing) = (mechanism.bodies.len(), count, [V::zero(); TWIST]);
        let reeved = reeved.into_iter().enumerate();
        let reeved: Vec<ReevedEnd> =
            reeved.map(|(number, (row, body))| ReevedEnd { row, gradient: rows + number, body }).collect();
        let weights = weights(mechanism);
        let weight = |row: usize| -> f64 {
            ends[elimination.closure_of_row[row]].iter().flatten().map(|&body| weights[body]).sum()
        };
        let [dependent, held] = Dependent::all(mechanism, &rows_of_loop);
        let dependent = dependent.into_iter().map(|group| {
            let part = if group.is_of_two_trees() { PROXIMAL } else { SHARED };
            let largest = group.rows().map(weight).fold(0.0, f64::max);
            (group, part * largest)
        });
        let dependent: Vec<(Dependent, f64)> = dependent.collect();
        let mut adhering = vec![0.0; rows];
        let touches = rows_of_loop[mechanism.loops.len()..loops].iter().zip(&mechanism.touches);
        for (own, joint) in touches.filter(|(_, joint)| mechanism.holds_beside_rubbing(joint)) {
            // The tangents, between the normal and the turnings that are held.
            let ends = own.start + 1..own.end.saturating_sub(joint.moments.rows());
            ends.for_each(|row| adhering[row] = LOOSE * weight(row));
        }
        Coupled {
            fronts: Fronts::new(mixing.active, &elimination),
            mixing,
            unit,
            rows_of_loop,
            ends,
            mimic_rows,
            resistances,
            in_joints,
            rotors,
            loops,
            turning_friction: vec![V::zero(); if forces { mechanism.braked().count() } else { 0 }],
            rolling: vec![None; rows],
            efforts: vec![V::zero(); mechanism.velocity_count],
            step: 0.0,
            proximal: PROXIMAL,
            known: Known::default(),
            bias: vec![nothing; bodies],
            gradients: vec![[nothing; 2]; rows + reeved.len()],
            reeved,
            gaps: vec![V::zero(); rows],
            multipliers: vec![V::zero(); rows],
            multiplier_increments: vec![V::zero(); rows],
            twists: vec![nothing; bodies],
            screws: vec![nothing; mechanism.velocity_count],
            kept: vec![V::zero(); kept],
            pivots: vec![V::zero(); kept_at.len()],
            right: vec![0.0; elimination.levels * elimination.slots],
            kept_at,
            scales: vec![0.0; rows],
            weights,
            dependent,
            held,
            even: vec![None; rows],
            adhering,
            references: vec![1.0; rows],
            left_over: vec![0.0; rows],
            elimination,
        }
    }

    /// Factors the system and solves it: fills the increments of the freedoms. Not inlined anywhere: every operation is
    /// compiled for the vectors on its own, once for all geometries.
    pub fn solve<G: Geometry<V>>(
        &mut self,
        geometry: &G,
        plan: &G::Plan,
        start: &G::Start,
        displacement: &[V],
        increment: &mut [V],
    ) {
        let operations = std::mem::take(&mut self.elimination.operations);
        let mut level = 0;
        let mut opened = false;
        for (index, operation) in operations.iter().enumerate() {
            let eliminated = match operation {
                Operation::Open => {
                    level += usize::from(opened);
                    opened = true;
                    self.open(level);
                    None
                }
                Operation::Enter { slots, present, gaps } => {
                    self.enter(level, slots, present, gaps);
                    None
                }
                Operation::Own { body, ends } => {
                    let (mixing, fronts) = (&self.mixing, &mut self.fronts);
                    in_lanes!(V, geometry.own(start, *body, mixing, fronts, level));
                    self.own(level, *body, ends);
                    self.scale_given(geometry, start, *body, ends);
                    None
                }
                Operation::Freedom { body, freedom, columns, direct } => {
                    let screws = in_lanes!(V, geometry.screws(plan, start, displacement, *body, *freedom));
                    self.take_freedom(level, &screws, *freedom, columns, direct);
                    Some(columns)
                }
                Operation::Multiplier { row, slot, columns, measure } => {
                    self.take_multiplier(level, *row, *slot, columns, measure);
                    Some(columns)
                }
                Operation::Merge { slots, enter, present, twist } => {
                    self.merge(level, slots, enter, present, *twist);
                    level -= 1;
                    None
                }
            };
            if let Some(columns) = eliminated {
                self.eliminate(level, index, columns);
            }
        }
        self.substitute_back(&operations, G::tree(plan), increment);
        self.elimination.operations = operations;
    }

    /// All eliminated unknowns, the last first.
    pub(crate) fn substitute_back(&mut self, operations: &[Operation], tree: &Plan, increment: &mut [V]) {
        for (index, operation) in operations.iter().enumerate().rev() {
            if let Operation::Freedom { columns, .. } | Operation::Multiplier { columns, .. } = operation {
                self.back_substitute(tree, operation, self.kept_at[index], columns, increment);
            }
        }
    }
}

/// A number in lane 0.
#[inline(always)]
pub(crate) fn first_lane<V: Lanes>(value: f64) -> V {
    let mut array = V::zero_array();
    array.as_mut()[0] = value;
    V::from_array(array)
}
