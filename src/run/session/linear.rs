//! Linear equations of motion of a model: about its equilibrium, or about a state.
//!
//! ```text
//!     d/dt (ξ, η) = A (ξ, η) + B u         ξ (d): independent joint coordinates,  η (e) = their velocities
//! ```
//!
//! Contacts that roll leave fewer independent velocities than coordinates, e < d. Without them e = d.
//!
//! A slight change of q is along the entries of v, without a quaternion: ball and floating joints have a rotation vector φ in the frame of the joint on
//! the parent, `R ← exp(φ̂) R`, and floating joints the displacement of the origin of the child link. B takes efforts as `set_efforts` does, and the rows
//! of A and B for η are the derivatives of `forward_dynamics`. Of a joint that turns freely with ω, `φ̇ = δω + ω × φ`. See
//! [`crate::derivatives::linear`].

use crate::derivatives::linear::about::{About, LinearizeError, about_instant, about_rest};
use crate::mechanism::description::joint::FreeRotation;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;
use crate::session::error::Error;
use crate::session::held_start::mechanism_from;
use crate::session::model::Model;
use crate::session::tangents::Tangents;
use nalgebra::{Complex, DMatrix};
use std::borrow::Cow;

pub use crate::derivatives::linear::modes::Stability;

/// A mode of linear equations of motion. Modes that swing stand for both eigenvalues of their pair.
#[derive(Clone, Debug)]
pub struct Mode {
    /// λ [1/s], its imaginary part not negative.
    pub eigenvalue: Complex<f64>,
    /// Hz; zero for modes that do not swing.
    pub frequency: f64,
    /// −Re λ/|λ|; `None` for free motions.
    pub damping_ratio: Option<f64>,
    /// 1/|Re λ| (s); `None` where the mode neither decays nor grows.
    pub time_constant: Option<f64>,
    /// Whether it decays, grows, swings on or moves freely.
    pub stability: Stability,
    /// Its shape along [`Linear::freedoms`], of norm one; the largest entry is real and positive.
    pub shape: Vec<Complex<f64>>,
}

/// Linear equations of motion of a model.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Names of the independent coordinates ξ (d): joints, or `JOINT.x` for one of several freedoms.
    pub names: Vec<String>,
    /// Their units: `rad` or `m`.
    pub units: Vec<&'static str>,
    /// Names of the coordinates whose velocities are independent, η (e).
    pub velocities: Vec<String>,
    /// A ((d + e) × (d + e)).
    pub a: DMatrix<f64>,
    /// B for efforts along all freedoms that move ((d + e) × n).
    pub b: DMatrix<f64>,
    /// The names of all freedoms that move (n): inputs of B, and entries of the shapes.
    pub freedoms: Vec<String>,
    /// B for the targets of motors ((d + e) × the motors that move something).
    pub b_targets: DMatrix<f64>,
    /// The joints of these motors.
    pub targets: Vec<String>,
    /// Inertia H, damping C (e × e) and stiffness K (e × d): `H η̇ + C η + K ξ = B_u u` at rest.
    pub inertia: DMatrix<f64>,
    /// C.
    pub damping: DMatrix<f64>,
    /// K.
    pub stiffness: DMatrix<f64>,
    /// The modes, the slowest first.
    pub modes: Vec<Mode>,
    /// The state: time (s), q and v.
    pub time: f64,
    /// q.
    pub q: Vec<f64>,
    /// v.
    pub v: Vec<f64>,
    /// The largest acceleration in the state itself [rad/s² or m/s²]: zero at an equilibrium.
    pub largest_acceleration: f64,
    /// Iterations to the equilibrium; `None` at an instant.
    pub iterations: Option<usize>,
    /// Joints that do not move, with their reasons.
    pub stuck: Vec<(String, String)>,
    /// The joints of motors at their bounds.
    pub saturated: Vec<String>,
    /// Contacts that are closed and stick at a point.
    pub sticking_contacts: usize,
    /// Contacts that are closed and roll.
    pub rolling_contacts: usize,
    /// Contacts that are closed and slide.
    pub sliding_contacts: usize,
}

impl Linear {
    /// The discrete system with a step (s) over which inputs are held: A_d, and B_d of efforts and of targets.
    ///
    /// ```text
    ///     exp(h [A B; 0 0]) = [A_d B_d; 0 1]
    /// ```
    pub fn discrete(&self, step: f64) -> (DMatrix<f64>, [DMatrix<f64>; 2]) {
        discrete(&self.a, [&self.b, &self.b_targets], step)
    }
}

/// The discrete system of A and of two kinds of inputs that are held over a step (s), as [`Linear::discrete`] has it.
pub fn discrete(a: &DMatrix<f64>, [b, b_targets]: [&DMatrix<f64>; 2], step: f64) -> (DMatrix<f64>, [DMatrix<f64>; 2]) {
    let (states, efforts, targets) = (a.nrows(), b.ncols(), b_targets.ncols());
    let mut whole = DMatrix::zeros(states + efforts + targets, states + efforts + targets);
    whole.view_mut((0, 0), (states, states)).copy_from(a);
    whole.view_mut((0, states), (states, efforts)).copy_from(b);
    whole.view_mut((0, states + efforts), (states, targets)).copy_from(b_targets);
    let whole = (whole * step).exp();
    let columns = |first: usize, count: usize| whole.view((0, first), (states, count)).into_owned();
    (columns(0, states), [columns(states, efforts), columns(states + efforts, targets)])
}

impl Model {
    /// The linear equations of motion about the equilibrium near q, or near the start of the file, with its motors, springs and closed loops.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use catena::prelude::*;
    ///
    /// let model = Model::load("robots/double_pendulum.urdf")?;
    /// let linear = model.linearize_at_rest(None)?;
    /// assert_eq!(linear.modes.len(), 2);
    /// assert!(linear.modes.iter().all(|mode| mode.frequency > 0.1), "it hangs, and swings");
    /// # Ok::<(), catena::session::Error>(())
    /// ```
    ///
    /// # Errors
    /// A start that cannot be, states whose motion has no linear equations, and if no equilibrium is found.
    pub fn linearize_at_rest(&self, q: Option<&[f64]>) -> Result<Linear, Error> {
        let state = match q {
            Some(q) => self.state_at(q, None)?,
            None => self.loaded().assembled(&[], &[], None)?.state,
        };
        self.linear_of_state(&state, &[], true)
    }

    /// The linear equations of motion about q and v, under efforts (n); an empty list stands for zero efforts.
    ///
    /// # Errors
    /// Wrong lengths, numbers that are not finite, and states whose motion has no linear equations.
    pub fn linearize(&self, q: &[f64], v: &[f64], efforts: &[f64]) -> Result<Linear, Error> {
        let state = self.state_at(q, Some(v))?;
        let mut of_state = Vec::new();
        if !efforts.is_empty() {
            self.coordinates().check("efforts", efforts, v.len(), |joint| &joint.v)?;
            of_state = vec![0.0; efforts.len()];
            self.coordinates().efforts_of_state(self.description(), &state.position, efforts, &mut of_state);
        }
        self.linear_of_state(&state, &of_state, false)
    }

    /// About a state, or about the equilibrium near it, under efforts along the velocities of the state.
    #[doc(hidden)]
    pub fn linear_of_state(&self, state: &State, efforts: &[f64], settled: bool) -> Result<Linear, Error> {
        self.linear_of_run(state, state, efforts, settled)
    }

    /// The same of a state of a run that began elsewhere, from where motors may have their targets.
    ///
    /// # Errors
    /// As of [`Model::linear_of_state`].
    pub fn linear_of_run(&self, start: &State, state: &State, efforts: &[f64], settled: bool) -> Result<Linear, Error> {
        let mechanism = &*mechanism_from(self.description(), start);
        let about =
            if settled { about_rest(mechanism, state, efforts)? } else { about_instant(mechanism, state, efforts)? };
        Ok(self.told(&about, efforts)?)
    }

    fn told(&self, about: &About, efforts: &[f64]) -> Result<Linear, LinearizeError> {
        let About { moving, state, linearised, iterations } = about;
        let whole = &self.description().mechanism;
        let of_whole = moving.freedoms_of_whole();
        let tangents = Tangents::at(self.description(), state);
        let linearised = match tangents.elsewhere(&of_whole, &linearised.accelerations, efforts) {
            None => Cow::Borrowed(linearised),
            Some(elsewhere) => Cow::Owned(elsewhere.told(linearised)?),
        };
        let modes = linearised.modes()?;
        let name = |own: &usize| freedom_name(whole, of_whole[*own]);
        let unit = |own: &usize| {
            let freedom = of_whole[*own];
            let body = whole.body_of_freedom(freedom).map(|body| &whole.bodies[body].joint);
            body.map_or("", |joint| joint.kind.unit(freedom - joint.velocity_index))
        };
        let motor_joint = |motor: usize| freedom_name(whole, whole.nonsmooth.motors[motor].coordinate.freedom);
        let driving: Vec<_> = moving
            .motors
            .iter()
            .filter_map(|motor| Some((motor, motor.freedom.filter(|_| !motor.saturated)?)))
            .collect();
        let columns: Vec<_> =
            driving.iter().map(|&(motor, freedom)| linearised.input.column(freedom) * motor.by_target).collect();
        let b_targets = DMatrix::from_fn(linearised.input.nrows(), columns.len(), |row, column| columns[column][row]);
        let (q, v) = self.flat(state);
        let [rolling, sliding] = moving.rolling_and_sliding();
        Ok(Linear {
            names: linearised.independent.iter().map(name).collect(),
            units: linearised.independent.iter().map(unit).collect(),
            velocities: linearised.rates.iter().map(name).collect(),
            a: linearised.state.clone(),
            b: linearised.input.clone(),
            freedoms: (0..of_whole.len()).map(|own| name(&own)).collect(),
            b_targets,
            targets: driving.iter().map(|(motor, _)| motor_joint(motor.motor)).collect(),
            inertia: linearised.inertia.clone(),
            damping: linearised.damping.clone(),
            stiffness: linearised.stiffness.clone(),
            modes: modes
                .iter()
                .map(|mode| Mode {
                    eigenvalue: mode.eigenvalue,
                    frequency: mode.frequency(),
                    damping_ratio: mode.damping_ratio(),
                    time_constant: mode.time_constant(),
                    stability: mode.stability,
                    shape: mode.shape.iter().copied().collect(),
                })
                .collect(),
            time: state.time,
            q,
            v,
            largest_acceleration: linearised.accelerations.iter().fold(0.0, |largest: f64, one| largest.max(one.abs())),
            iterations: *iterations,
            stuck: moving.stuck.iter().map(|stuck| (stuck.joint.clone(), stuck.reason().to_string())).collect(),
            saturated: (moving.motors.iter().filter(|motor| motor.saturated))
                .map(|motor| motor_joint(motor.motor))
                .collect(),
            sticking_contacts: moving.sticking,
            rolling_contacts: rolling,
            sliding_contacts: sliding,
        })
    }
}

/// The name of a degree of freedom: its joint, with an axis if the joint has several.
pub(crate) fn freedom_name(mechanism: &Mechanism, freedom: usize) -> String {
    let Some(body) = mechanism.body_of_freedom(freedom) else { return String::new() };
    let joint = &mechanism.bodies[body].joint;
    if joint.kind.velocity_count() == 1 {
        return joint.name.clone();
    }
    let offset = freedom - joint.velocity_index;
    let slides = joint.kind.translation_axes();
    let axis = match slides.get(offset) {
        Some(&axis) => ["x", "y", "z"][axis],
        None if joint.kind.rotation() == FreeRotation::AboutZ => "angle",
        None => ["rx", "ry", "rz"][offset - slides.len()],
    };
    format!("{}.{axis}", joint.name)
}
