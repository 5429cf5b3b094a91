//! What motors, dry friction and limits exert on the joints in one state.
//!
//! ```text
//!     τ_i = τ_motor,i − τ_f,i sign(q̇_i)        a joint that moves, with friction τ_f
//!     τ_i = τ_motor,i + λ_i                    a joint at rest (q̇_i = 0) that has friction or is on a limit
//!
//!     a = b + D λ,   b = W a_free,  D = W Y Wᵀ                  W: rows of the joints at rest, Y: their response
//!     λ_i ∈ [lo_i, hi_i]:   a_i = 0 inside,  a_i ≥ 0 at lo_i,  a_i ≤ 0 at hi_i
//! ```
//!
//! [N m or N]; a_free are the accelerations without λ, with all forces and closures. The set is `[−τ_f, τ_f]` where friction alone holds, without
//! bound into the allowed range on a limit. Where closures leave several λ, the one that the active-set method finds is taken.
//!
//! Source: Ch. Glocker, Set-Valued Force Laws, Springer 2001, chapter 9.

use crate::instant::bounded::minimise;
use crate::instant::elements::Elements;
use crate::instant::response::Response;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::state::State;

/// Works out the efforts of one state after another.
pub(crate) struct Exerted {
    elements: Elements,
    response: Response,
    state: State,
    /// One entry a degree of freedom, for the state above and these efforts of motors.
    efforts: Vec<f64>,
    motors: Vec<f64>,
    /// Whether any state has been asked for.
    known: bool,
    free: Vec<f64>,
    /// Joints at rest that something can hold: degree of freedom, and the efforts that can.
    at_rest: Vec<(usize, (f64, f64))>,
}

impl Exerted {
    /// For a mechanism; none if it has neither motors nor friction nor limits.
    pub fn new(mechanism: &Mechanism) -> Option<Self> {
        (!mechanism.nonsmooth.is_empty()).then(|| {
            let elements = Elements::new(mechanism);
            Exerted {
                response: Response::new(mechanism),
                state: State::zero(mechanism),
                efforts: vec![0.0; mechanism.velocity_count],
                motors: Vec::with_capacity(elements.motors.len()),
                known: false,
                free: vec![0.0; mechanism.velocity_count],
                at_rest: Vec::with_capacity(elements.joints.len()),
                elements,
            }
        })
    }

    /// The efforts at these positions and velocities, with those of the motors: one entry a motor, or none if no motor drives. Does not
    /// allocate while no joint is held.
    pub fn at(&mut self, position: &[f64], velocity: &[f64], motors: &[f64]) -> &[f64] {
        let Exerted { elements, response, state, efforts, motors: before, known, free, at_rest } = self;
        // What is held stays where it is.
        let same = state.position == position && state.velocity == velocity && before == motors;
        if std::mem::replace(known, true) && same {
            return efforts;
        }
        before.clear();
        before.extend_from_slice(motors);
        state.position.copy_from_slice(position);
        state.velocity.copy_from_slice(velocity);
        efforts.fill(0.0);
        for (motor, effort) in elements.motors.iter().zip(motors) {
            efforts[motor.coordinate.freedom] += effort;
        }
        at_rest.clear();
        for joint in &elements.joints {
            let (freedom, rate) = (joint.coordinate.freedom, joint.rate(state));
            let side = joint.side(joint.position(state));
            if rate != 0.0 {
                efforts[freedom] -= joint.friction * rate.signum();
            } else if joint.friction > 0.0 || side.is_some() {
                at_rest.push((freedom, joint.holding(side)));
            }
        }
        if !at_rest.is_empty() {
            response.accelerations(state, efforts, free);
            let freedoms: Vec<usize> = at_rest.iter().map(|(freedom, _)| *freedom).collect();
            let bounds: Vec<(f64, f64)> = at_rest.iter().map(|(_, bounds)| *bounds).collect();
            let offset: Vec<f64> = freedoms.iter().map(|&freedom| free[freedom]).collect();
            let (_, square) = response.matrix(state, &freedoms);
            for (&freedom, effort) in freedoms.iter().zip(minimise(&square, &offset, &bounds).efforts) {
                efforts[freedom] += effort;
            }
        }
        efforts
    }
}
