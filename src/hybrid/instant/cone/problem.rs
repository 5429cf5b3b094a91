//! A contact problem at one instant and its answer.
//!
//! ```text
//!     u = D r + b,     for each block of rows its law between u and r
//! ```
//!
//! D (m × m) is the mobility (Delassus matrix), symmetric and positive semidefinite; it is singular where contacts are redundant. r (m) are forces
//! or impulses, u (m) rates or accelerations, b (m) the rates without r. Units follow the rows: N, N m, N s, with m/s, rad/s, m/s².
//!
//! Source: G. De Saxcé, Z.-Q. Feng, The bipotential method, Mathematical and Computer Modelling 28 (1998), for Coulomb's law as complementarity.

use nalgebra::DMatrix;

/// A run can go on with forces that leave a residual up to this: enough for steps of first order, and where no solver has done better.
pub(crate) const ROUGH: f64 = 1e-6;

/// The law of a block of rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// One row: `lower ≤ r ≤ upper` with u = 0 inside, u ≥ 0 at the lower bound and u ≤ 0 at the upper one. A limit has [0, ∞), friction of a joint
    /// [−τ, τ], a row that always holds (−∞, ∞).
    Interval {
        /// Least force.
        lower: f64,
        /// Largest force.
        upper: f64,
    },
    /// Three rows, the normal and two tangential ones: Signorini's and Coulomb's law, `K ∋ r ⊥ u + μ |u_T| e_N ∈ K*`, K = {|r_T| ≤ μ r_N}.
    Contact {
        /// μ ≥ 0.
        friction: f64,
    },
    /// Three rows of a contact that slides in a known direction: `r_T = −μ r_N t`, `0 ≤ r_N ⊥ u_N ≥ 0`.
    Sliding {
        /// μ ≥ 0.
        friction: f64,
        /// t, of length 1.
        direction: [f64; 2],
    },
}

impl Law {
    /// The law of a contact that sticks, or slides in this direction of its tangents; without friction only its normal has a row.
    pub fn of_contact(friction: f64, slides: Option<[f64; 2]>) -> Self {
        match slides {
            _ if friction == 0.0 => Law::Interval { lower: 0.0, upper: f64::INFINITY },
            Some(direction) => Law::Sliding { friction, direction },
            None => Law::Contact { friction },
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        match self {
            Law::Interval { .. } => 1,
            Law::Contact { .. } | Law::Sliding { .. } => 3,
        }
    }

    /// Whether its numbers mean anything.
    fn is_sound(&self) -> bool {
        match *self {
            Law::Interval { lower, upper } => lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY,
            Law::Contact { friction } => friction.is_finite() && friction >= 0.0,
            Law::Sliding { friction, direction: [x, y] } => {
                friction.is_finite() && friction >= 0.0 && (x.hypot(y) - 1.0).abs() < 1e-6
            }
        }
    }
}

/// How far a force [normal, and two tangential ones] is outside of Coulomb's cone: `|r_T| − μ r_N`, negative inside.
pub(crate) fn outside_cone(friction: f64, force: [f64; 3]) -> f64 {
    let [normal, first, second] = force;
    first.hypot(second) - friction * normal
}

/// A problem.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'p> {
    /// D (m × m).
    pub mobility: &'p DMatrix<f64>,
    /// b (m).
    pub free: &'p [f64],
    /// The laws of the blocks, in the order of the rows.
    pub laws: &'p [Law],
}

impl Problem<'_> {
    /// The first row of each block.
    pub fn starts(&self) -> Vec<usize> {
        let starts = self.laws.iter().scan(0, |next, law| {
            let start = *next;
            *next += law.rows();
            Some(start)
        });
        starts.collect()
    }

    /// Checks lengths and numbers.
    ///
    /// # Errors
    /// If lengths differ, a number is not finite, or a law is malformed.
    pub fn check(&self) -> Result<(), Unsolved> {
        let rows: usize = self.laws.iter().map(Law::rows).sum();
        let (height, width) = self.mobility.shape();
        if height != rows || width != rows || self.free.len() != rows {
            return Err(Unsolved::Shape { rows, height, width, free: self.free.len() });
        }
        for (block, (law, start)) in self.laws.iter().zip(self.starts()).enumerate() {
            let finite =
                |row: usize| self.free[row].is_finite() && self.mobility.row(row).iter().all(|v| v.is_finite());
            if !law.is_sound() || !(start..start + law.rows()).all(finite) {
                return Err(Unsolved::Numbers { block });
            }
        }
        Ok(())
    }

    /// `u = D r + b`.
    pub fn rates(&self, forces: &[f64]) -> Vec<f64> {
        let mut rates = self.free.to_vec();
        for (column, &force) in self.mobility.column_iter().zip(forces).filter(|(_, force)| **force != 0.0) {
            for (rate, mobility) in rates.iter_mut().zip(column.iter()) {
                *rate += mobility * force;
            }
        }
        rates
    }
}

/// The state of a block in an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockState {
    /// A contact without force; it may touch or leave.
    Open,
    /// A closed contact with u_N = 0 whose friction is at its bound.
    Slips,
    /// A closed contact with u = 0.
    Sticks,
    /// An interval with the force at its lower bound.
    AtLower,
    /// An interval with the force at its upper bound.
    AtUpper,
    /// An interval with u = 0.
    Inside,
}

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// r (m); exactly 0 or at its bound where the state says so.
    pub forces: Vec<f64>,
    /// u (m); exactly 0 where the state says so.
    pub rates: Vec<f64>,
    /// The state of each block.
    pub states: Vec<BlockState>,
    /// The residual of the law, max |r − P_K(r − û / w)| over the blocks, relative to the largest force: the larger of the residuals in forces and in
    /// forces times √w, which does not forgive light bodies beside heavy ones.
    pub residual: f64,
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unsolved {
    /// Lengths do not fit.
    #[error("a contact problem has laws for {rows} rows, but a {height} × {width} matrix and {free} free rates")]
    Shape {
        /// Rows of all laws.
        rows: usize,
        /// Rows of D.
        height: usize,
        /// Columns of D.
        width: usize,
        /// Length of b.
        free: usize,
    },
    /// A number has no meaning.
    #[error(
        "element {block} of a contact problem has a number that is not finite, a negative friction, or bounds that cross"
    )]
    Numbers {
        /// The block.
        block: usize,
    },
    /// A contact that slides has no acceleration that fits its law (Painlevé): an impulse must follow.
    #[error(
        "element {block} slides and no acceleration fits Coulomb's law there (mobility {mobility:.3e}); it needs an impulse"
    )]
    Inconsistent {
        /// The block.
        block: usize,
        /// n D (n − μ t) ≤ 0 of the block, with all others as they are.
        mobility: f64,
    },
    /// The solvers stopped early.
    #[error("a contact problem of {} elements is solved to {:.1e} only; take a shorter step", .best.states.len(), .best.residual)]
    Stopped {
        /// The best that was found.
        best: Box<Answer>,
    },
}
