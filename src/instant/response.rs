//! How a mechanism answers to efforts and impulses at one instant, with its closures.
//!
//! ```text
//!     a = a_free + Y τ          accelerations under efforts τ            a_free: without them
//!     v⁺ = v⁻ + Y P             velocities after impulses P
//!     Y = H⁻¹ − H⁻¹ Jᵀ (J H⁻¹ Jᵀ)⁺ J H⁻¹      (n × n)  symmetric, positive semidefinite
//! ```
//!
//! H (n × n) is the mass matrix, J the gradient of the closures. A column of Y is one solve of the articulated-body algorithm, made to fit the
//! closures by the least motion in the metric of H ([`Projection`]); H is never formed.

use crate::lobatto::coupled::counted::Counted;
use crate::lobatto::coupled::deciding::known;
use crate::lobatto::coupled::projection::Projection;
use crate::lobatto::stages::start::Start;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::gaps::gap_accelerations;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::kinematics::{BodyAcceleration, body_accelerations, place_bodies};
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
    unit: Vec<f64>,
}

struct Closing {
    projection: Projection,
    start: Start,
    multipliers: Vec<f64>,
    decided: bool,
}

impl Response {
    /// For a mechanism with its forces.
    pub fn new(mechanism: &Mechanism) -> Self {
        let mut driven = mechanism.clone();
        driven.forces.driven = true;
        let mut bare = driven.clone();
        bare.gravity = Vector3::zeros();
        bare.forces = Default::default();
        bare.forces.driven = true;
        let closing = mechanism.has_closures().then(|| {
            let projection = Projection::new(mechanism);
            let multipliers = vec![0.0; projection.row_count()];
            Closing { projection, start: Start::new(mechanism), multipliers, decided: false }
        });
        Response {
            ode: ReducedOde::new(&driven),
            bare: ReducedOde::new(&bare),
            bodies: vec![WORLD; mechanism.bodies.len()],
            accelerations: vec![BodyAcceleration::default(); mechanism.bodies.len()],
            closing,
            zero: vec![0.0; mechanism.velocity_count],
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
            let Closing { projection, start, multipliers, .. } = closing;
            projection.accelerations(start, out, multipliers, |joints, gaps| {
                body_accelerations(mechanism, bodies, &state.velocity, joints, accelerations);
                gap_accelerations(mechanism, bodies, joints, accelerations, gaps);
            });
        }
    }

    /// The column of Y for one degree of freedom at a state.
    pub fn column(&mut self, state: &State, freedom: usize, out: &mut [f64]) {
        let Response { mechanism, bare, bodies, closing, zero, unit, .. } = self;
        place_bodies(mechanism, state, bodies);
        for body in bodies.iter_mut() {
            (body.velocity, body.angular_velocity) = (Vector3::zeros(), Vector3::zeros());
        }
        unit[freedom] = 1.0;
        bare.drive(Inputs::constant(unit));
        bare.accelerations_of_placed(&state.position, zero, bodies, out);
        unit[freedom] = 0.0;
        if let Some(closing) = closing {
            closing.place(mechanism, state);
            closing.projection.velocities(mechanism, &closing.start, out);
        }
    }

    /// Y for some degrees of freedom: their columns (n × m), and `D = W Y Wᵀ` (m × m), the rows of which they are.
    pub fn matrix(&mut self, state: &State, freedoms: &[usize]) -> (DMatrix<f64>, DMatrix<f64>) {
        let mut columns = DMatrix::zeros(self.mechanism.velocity_count, freedoms.len());
        let mut column = vec![0.0; self.mechanism.velocity_count];
        for (index, &freedom) in freedoms.iter().enumerate() {
            self.column(state, freedom, &mut column);
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
            closing.projection.velocities(&self.mechanism, &closing.start, &mut state.velocity);
        }
    }
}

impl Closing {
    fn place(&mut self, mechanism: &Mechanism, state: &State) {
        self.start.set(mechanism, state);
        if !std::mem::replace(&mut self.decided, true) {
            self.projection.heed(known(&Counted::at(mechanism, state), mechanism));
        }
    }
}
