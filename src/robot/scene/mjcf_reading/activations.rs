//! Actuators of MJCF with dynamics of their own, as targets over time.
//!
//! The control u is constant in a file, so that the activation a of an actuator is known in closed form:
//!
//! ```text
//!     filter, τ ȧ = u − a:   a = u + (a₀ − u) e^{−t/τ}              integrator, ȧ = u:   a = a₀ + u min(t, t_c),   t_c where a leaves its range
//! ```
//!
//! A motor with kp and kd follows the target r with kp r + kd ṙ = D(t) = C + G a, s = kd/kp:
//!
//! ```text
//!     D = A + B e^{−t/τ}:        r = A/kp + B/(kp − kd/τ) e^{−t/τ},   or A/kp + (B/kd) t e^{−t/τ} where kp = kd/τ
//!     D = A + B t:               r = (A − B s)/kp + (B/kp) t
//! ```
//!
//! One without kp has the target D/kd, one without both D. Where D has a kink, at the bound of an integrator, a table is its target; ṙ would jump there
//! with kp and kd, so that G a is a load in the joint then, and r is C/kp. Units are those of the target: rad or m, rad/s or m/s, N m or N.

/// Relative difference of kp and kd/τ below which they are one: both formulas are as wrong there.
const RESONANT: f64 = 1e-8;

/// How an activation follows its control.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Follows {
    /// With a time constant (s).
    Filter(f64),
    Integrator,
}

/// The activation of an actuator.
#[derive(Clone, Debug)]
pub(crate) struct Activation {
    /// Its place in `act` of a keyframe.
    pub number: usize,
    pub follows: Follows,
    pub start: f64,
    pub range: Option<(f64, f64)>,
}

/// A motor's drive: its stiffness, its damping, and its effort at rest at zero, without activation and with an activation of one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drive {
    pub kp: f64,
    pub kd: f64,
    pub constant: f64,
    pub gain: f64,
}

impl Drive {
    /// The target at a constant activation.
    pub fn at_rest(&self, activation: f64) -> f64 {
        (self.constant + self.gain * activation) / self.unit()
    }

    fn unit(&self) -> f64 {
        if self.kp > 0.0 {
            self.kp
        } else if self.kd > 0.0 {
            self.kd
        } else {
            1.0
        }
    }
}

/// How a motor is driven, as values of a scene file.
pub(crate) struct Driving {
    pub target: String,
    /// The effort of a load beside the motor, and its factor over time.
    pub load: Option<(f64, String)>,
}

impl Activation {
    /// How a motor is driven under a control.
    pub fn driving(&self, drive: &Drive, control: f64) -> Driving {
        let bounded =
            |activation: f64| self.range.map_or(activation, |(lower, upper)| activation.max(lower).min(upper));
        let start = bounded(self.start);
        let damped = if drive.kp > 0.0 { drive.kd } else { 0.0 };
        let target = match self.follows {
            Follows::Filter(time) if control != start => {
                let (a, b) = (drive.at_rest(control), drive.gain * (start - control));
                let stiff = drive.unit() - damped / time;
                if stiff.abs() > RESONANT * drive.unit() {
                    let b = b / stiff;
                    format!("{{ formula = \"a + b*exp(-t/c)\", a = {a:?}, b = {b:?}, c = {time:?} }}")
                } else {
                    let b = b / damped;
                    format!("{{ formula = \"a + b*t*exp(-t/c)\", a = {a:?}, b = {b:?}, c = {time:?} }}")
                }
            }
            Follows::Integrator if control != 0.0 && bounded(start + control) != start => {
                let bound = self.range.map(|(lower, upper)| if control > 0.0 { upper } else { lower });
                if let Some(bound) = bound.filter(|bound| bound.is_finite()) {
                    let end = (bound - start) / control;
                    let table = |from: f64, to: f64| format!("[[0, {from:?}], [{end:?}, {to:?}]]");
                    if damped > 0.0 {
                        let load = Some((drive.gain, table(start, bound)));
                        return Driving { target: format!("{:?}", drive.at_rest(0.0)), load };
                    }
                    table(drive.at_rest(start), drive.at_rest(bound))
                } else {
                    let rate = drive.gain * control / drive.unit();
                    let a = drive.at_rest(start) - rate * damped / drive.unit();
                    format!("{{ formula = \"a + b*t\", a = {a:?}, b = {rate:?} }}")
                }
            }
            Follows::Filter(_) | Follows::Integrator => format!("{:?}", drive.at_rest(start)),
        };
        Driving { target, load: None }
    }
}
