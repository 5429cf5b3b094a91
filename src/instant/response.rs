//! How a mechanism answers to efforts and impulses at one instant, with its closures.
//!
//! ```text
//!     a = a_free + Y τ          accelerations under efforts τ            a_free: without them
//!     v⁺ = v⁻ + Y P             velocities after impulses P
//!     Y = H⁻¹ − H⁻¹ Jᵀ (J H⁻¹ Jᵀ)⁺ J H⁻¹      (n × n)  symmetric, positive semidefinite
//! ```
//!
//! H (n × n) is the mass matrix, J the gradient of the closures. A column of Y is one solve of the articulated-body algorithm, made to fit the
//! closures by the least motion in the metric of H ([`Closing`]); H is never formed.

use crate::instant::closing::Closing;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::kinematics::{BodyAcceleration, place_bodies};
use crate::mechanism::motion::state::State;
use crate::reduced::ReducedOde;
use nalgebra::{DMatrix, Vector3};

/// The workspace of one mechanism.
pub(crate) struct Response {
    mechanism: Mechanism,
    /// With all forces, and efforts from outside.
    ode: ReducedOde,
    /// The masses alone: without gravity and forces.
    bare: ReducedOde,
    bodies: Vec<BodyState>,
    accelerations: Vec<BodyAcceleration>,
    closing: Option<Closing>,
    zero: Vec<f64>,
    free: Vec<f64>,
    unit: Vec<f64>,
}

impl Response {
    /// For a mechanism with its forces.
    pub fn new(mechanism: &Mechanism) -> Self {
        let mut driven = mechanism.clone();
        driven.forces.driven = true;
        let mut bare = mechanism.clone();
        bare.gravity = Vector3::zeros();
        bare.forces = Default::default();
        Response {
            ode: ReducedOde::new(&driven),
            bare: ReducedOde::new(&bare),
            bodies: vec![WORLD; mechanism.bodies.len()],
            accelerations: vec![BodyAcceleration::default(); mechanism.bodies.len()],
            closing: Closing::new(mechanism),
            zero: vec![0.0; mechanism.velocity_count],
            free: vec![0.0; mechanism.velocity_count],
            unit: vec![0.0; mechanism.velocity_count],
            mechanism: driven,
        }
    }

    /// The accelerations of a state under its forces and these efforts, one entry a degree of freedom.
    pub fn accelerations(&mut self, state: &State, efforts: &[f64], out: &mut [f64]) {
        let Response { mechanism, ode, bodies, accelerations, closing, .. } = self;
        place_bodies(mechanism, state, bodies);
        ode.drive(Inputs::constant(efforts));
        ode.accelerations_of_placed(&state.position, &state.velocity, bodies, out);
        if let Some(closing) = closing {
            closing.place(mechanism, state);
            closing.accelerations(mechanism, &state.velocity, bodies, out, accelerations);
        }
    }

    /// Takes a state at which columns of Y are asked for.
    fn place(&mut self, state: &State) {
        let Response { mechanism, bare, closing, zero, free, .. } = self;
        bare.accelerations(&state.position, zero, free);
        if let Some(closing) = closing {
            closing.place(mechanism, state);
        }
    }

    /// The column of Y for one degree of freedom at the state that was taken last.
    fn column(&mut self, freedom: usize, out: &mut [f64]) {
        let mut unit = std::mem::take(&mut self.unit);
        unit[freedom] = 1.0;
        self.answer(&unit, out);
        unit[freedom] = 0.0;
        self.unit = unit;
    }

    /// Y τ for efforts τ at the state that was taken last.
    fn answer(&mut self, efforts: &[f64], out: &mut [f64]) {
        let Response { mechanism, bare, closing, .. } = self;
        bare.respond(efforts, out);
        if let Some(closing) = closing {
            closing.velocities(mechanism, out);
        }
    }

    /// Y Wᵀ (n × m) for rows W of efforts, at a state.
    pub fn answers(&mut self, state: &State, rows: &[Vec<f64>]) -> DMatrix<f64> {
        self.place(state);
        let mut columns = DMatrix::zeros(self.mechanism.velocity_count, rows.len());
        let mut column = vec![0.0; self.mechanism.velocity_count];
        for (index, row) in rows.iter().enumerate() {
            self.answer(row, &mut column);
            columns.column_mut(index).copy_from_slice(&column);
        }
        columns
    }

    /// The entries on the diagonal of Y of some degrees of freedom at a state.
    pub fn diagonal(&mut self, state: &State, freedoms: impl Iterator<Item = usize>) -> Vec<f64> {
        self.place(state);
        let mut column = vec![0.0; self.mechanism.velocity_count];
        let entries = freedoms.map(|freedom| {
            self.column(freedom, &mut column);
            column[freedom]
        });
        entries.collect()
    }

    /// Y for some degrees of freedom: their columns (n × m), and `D = W Y Wᵀ` (m × m), the rows of which they are.
    pub fn matrix(&mut self, state: &State, freedoms: &[usize]) -> (DMatrix<f64>, DMatrix<f64>) {
        self.place(state);
        let mut columns = DMatrix::zeros(self.mechanism.velocity_count, freedoms.len());
        let mut column = vec![0.0; self.mechanism.velocity_count];
        for (index, &freedom) in freedoms.iter().enumerate() {
            self.column(freedom, &mut column);
            columns.column_mut(index).copy_from_slice(&column);
        }
        let half = |row: usize, other: usize| columns[(freedoms[row], other)];
        let square = DMatrix::from_fn(freedoms.len(), freedoms.len(), |row, column| {
            // Symmetric to the last bit.
            0.5 * (half(row, column) + half(column, row))
        });
        (columns, square)
    }

    /// Brings velocities on the closures, with the least change in the metric of H.
    pub fn close_velocities(&mut self, state: &mut State) {
        if let Some(closing) = &mut self.closing {
            closing.place(&self.mechanism, state);
            closing.velocities(&self.mechanism, &mut state.velocity);
        }
    }
}
