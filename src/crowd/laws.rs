//! The laws of one row or one contact, as equations of Alart and Curnier and as projections.
//!
//! ```text
//!     cone of friction μ:  F = r − Π_{C(y_N)}(y),   y = r − ρ u,    C: r_N ≥ 0, |r_T| ≤ μ max(0, y_N)
//!     interval:            F = r − clamp(y, lower, upper)
//!     F + A du + (B + εA/ρ) dr = 0                 one step of Newton's method, ε: a proximal part
//! ```
//!
//! `u` are rates with their bias [m/s], `r` impulses (N s), both along normal and two tangents; `ρ` is the mass at the row (kg). An interval
//! has the first component alone. The exact law has De Saxcé's shift: `K ∋ r ⊥ u + μ|u_T| n ∈ K*`; its natural map is what a residual is made of.
//!
//! Source: P. Alart, A. Curnier, A mixed formulation for frictional contact problems prone to Newton like solution methods, Computer Methods in
//! Applied Mechanics and Engineering 92 (1991); G. De Saxcé, Z.-Q. Feng, The bipotential method (1998).

use nalgebra::Vector3;

/// The law of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Coulomb's cone with this friction, which is positive.
    Cone(f64),
    /// Impulses from … to …; a contact without friction, a limit, a joint with friction, a motor.
    Interval(f64, f64),
}

/// The change of an impulse with the change of its rate: `dr = −shift − slope du`.
#[derive(Clone, Copy)]
pub struct Response {
    /// (B + εA/ρ)⁻¹ F (N s).
    pub shift: Vector3<f64>,
    /// (B + εA/ρ)⁻¹ A [N s/(m/s)], by rows; `None` where it is zero.
    pub slope: Option<[[f64; 3]; 3]>,
}

impl Law {
    /// Number of rows.
    pub fn rows(self) -> usize {
        match self {
            Law::Cone(_) => 3,
            Law::Interval(..) => 1,
        }
    }

    /// Whether an impulse is beyond the bounds, or pulls at a contact.
    pub fn pulls(self, impulse: &Vector3<f64>) -> bool {
        match self {
            Law::Cone(_) => impulse.x < 0.0,
            Law::Interval(lower, upper) => impulse.x < lower || impulse.x > upper,
        }
    }

    /// De Saxcé's shift of the normal rate.
    pub fn shift(self, rate: &Vector3<f64>) -> f64 {
        match self {
            Law::Cone(friction) => friction * norm(rate.y, rate.z),
            Law::Interval(..) => 0.0,
        }
    }

    /// The nearest impulse that the law allows.
    pub fn project(self, y: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Law::Interval(lower, upper) => Vector3::new(y.x.max(lower).min(upper), 0.0, 0.0),
            Law::Cone(friction) => {
                let across = norm(y.y, y.z);
                if y.x >= 0.0 && across <= friction * y.x {
                    *y
                } else if friction * across <= -y.x {
                    Vector3::zeros()
                } else {
                    let normal = (y.x + friction * across) / (1.0 + friction * friction);
                    let part = friction * normal / across;
                    Vector3::new(normal, part * y.y, part * y.z)
                }
            }
        }
    }

    /// The derivative of the projection, by rows; `None` where it is zero.
    pub fn projection_slope(self, y: &Vector3<f64>) -> Option<[[f64; 3]; 3]> {
        match self {
            Law::Interval(lower, upper) => {
                (lower < y.x && y.x < upper).then_some([[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]])
            }
            Law::Cone(friction) => {
                let across = norm(y.y, y.z);
                if y.x >= 0.0 && across <= friction * y.x {
                    return Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
                }
                if friction * across <= -y.x {
                    return None;
                }
                let part = 1.0 / (1.0 + friction * friction);
                let t = [y.y / across, y.z / across];
                let normal = (y.x + friction * across) * part;
                let outward = [1.0, friction * t[0], friction * t[1]];
                let mut slope = outward.map(|row| outward.map(|column| part * row * column));
                let turning = friction * normal / across;
                for row in 0..2 {
                    for column in 0..2 {
                        let same = if row == column { 1.0 } else { 0.0 };
                        slope[1 + row][1 + column] += turning * (same - t[row] * t[column]);
                    }
                }
                Some(slope)
            }
        }
    }

    /// How far an impulse is from the one that the law makes of it with this rate: the natural map.
    pub fn defect(self, impulse: &Vector3<f64>, rate: &Vector3<f64>, rho: f64) -> Vector3<f64> {
        let mut rate = *rate;
        rate.x += self.shift(&rate);
        impulse - self.project(&(impulse - rate * rho))
    }

    /// The step of Newton's method of a block with rates u, mass ρ, compliance c [m/s/(N s)] and a proximal part ε, in closed form.
    ///
    /// ```text
    ///     open:    F = r,   A = 0                stick:  F = ρ u,   A = ρ 1,   B = 0
    ///     slip:    F = (ρ u_N, r_T − μ y_N t),   A = ρ ((1, 0), (μ t, k P)),   B = ((0, 0), (−μ t, 1 − k P))
    ///              t = y_T/|y_T|,   P = 1 − t tᵀ,   k = μ y_N/|y_T| < 1
    /// ```
    pub fn respond(self, r: &Vector3<f64>, u: &Vector3<f64>, [rho, compliance, proximal]: [f64; 3]) -> Response {
        let y = r - u * rho;
        let stiff = rho / proximal;
        match self {
            Law::Interval(lower, upper) if lower < y.x && y.x < upper => {
                let stiff = rho / (proximal + rho * compliance);
                let slope = [[stiff, 0.0, 0.0], [0.0; 3], [0.0; 3]];
                Response { shift: Vector3::new(stiff * u.x, 0.0, 0.0), slope: Some(slope) }
            }
            Law::Interval(lower, upper) => {
                Response { shift: Vector3::new(r.x - y.x.max(lower).min(upper), 0.0, 0.0), slope: None }
            }
            Law::Cone(_) if y.x <= 0.0 => Response { shift: *r, slope: None },
            Law::Cone(friction) => {
                let across = norm(y.y, y.z);
                let most = friction * y.x;
                if across <= most {
                    let slope = [[stiff, 0.0, 0.0], [0.0, stiff, 0.0], [0.0, 0.0, stiff]];
                    return Response { shift: u * stiff, slope: Some(slope) };
                }
                let (t, part) = ([y.y / across, y.z / across], most / across);
                // (1 − (1 − ε) k P)⁻¹ = t tᵀ + turned P
                let turned = 1.0 / (1.0 - (1.0 - proximal) * part);
                let off = [r.y - most * t[0], r.z - most * t[1]];
                let along = t[0] * off[0] + t[1] * off[1];
                let normal = stiff * u.x;
                let pushed = along + (1.0 - proximal) * friction * normal;
                let shift = |row: usize| turned * (off[row] - along * t[row]) + pushed * t[row];
                let turning = rho * part * turned;
                let slope = [
                    [stiff, 0.0, 0.0],
                    [friction * t[0] * stiff, turning * (1.0 - t[0] * t[0]), -turning * t[0] * t[1]],
                    [friction * t[1] * stiff, -turning * t[0] * t[1], turning * (1.0 - t[1] * t[1])],
                ];
                Response { shift: Vector3::new(normal, shift(0), shift(1)), slope: Some(slope) }
            }
        }
    }
}

fn norm(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
