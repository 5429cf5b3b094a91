//! A box that lies flat over the straight edge of a table at x = 0, slides and turns, integrated on its own by Runge and Kutta's method.
//!
//! ```text
//!     patch:   corners of the box with x < 0, and the crossings of its sides with the edge
//!     N_i = α + β X_i + γ Y_i ≥ 0,   f_i = −μ N_i u_i/|u_i|,   u_i = v + ω z × r_i      pressures of equal springs, as stiff as one likes; they do not pull
//!     Σ N_i = m g,   Σ r_i × (f_i + N_i z) = (0, 0, J dω/dt)                              r_i = (X_i, Y_i, −h/2) from the centre (m)
//! ```
//!
//! Steps end where a corner passes the edge, or a point begins or ends to press. The mass is 1 kg.

// Every program of tests compiles its own copy of this module and uses some of it.
#![allow(dead_code)]

use crate::runge_kutta::runge_kutta;
use nalgebra::{Matrix3, Vector3};

/// Acceleration of gravity (m/s²).
const GRAVITY: f64 = 9.81;
/// The longest step, and how near steps end to a change of the patch (s).
const STEP: f64 = 1e-4;
const NEAR: f64 = 1e-12;

/// Place of the centre (m), angle (rad), and their rates: (x, y, θ, ẋ, ẏ, ω).
pub type Turning = [f64; 6];

/// A box of these sides (m) on the table, and its friction.
pub struct OnTable {
    pub size: [f64; 3],
    pub friction: f64,
}

/// The points of the patch from the centre (m), the friction of a unit of pressure there, and the pressures (N); a name for each point.
struct Patch {
    points: Vec<(u8, [f64; 2])>,
    drags: Vec<[f64; 2]>,
    pressures: Vec<f64>,
}

impl OnTable {
    /// The motion after a time (s).
    pub fn after(&self, mut y: Turning, time: f64) -> Turning {
        let mut now = 0.0;
        while now < time {
            let h = STEP.min(time - now);
            let next = runge_kutta(&|y| self.slope(y), &y, h);
            let own = self.patch(&y).names();
            if self.patch(&next).names() == own {
                (y, now) = (next, now + h);
                continue;
            }
            let (mut before, mut beyond) = (0.0, h);
            while beyond - before > NEAR {
                let middle = 0.5 * (before + beyond);
                let same = self.patch(&runge_kutta(&|y| self.slope(y), &y, middle)).names() == own;
                *(if same { &mut before } else { &mut beyond }) = middle;
            }
            // Across the change in a step of its own: stages beyond it have other forces.
            y = runge_kutta(&|y| self.slope(y), &y, before);
            y = runge_kutta(&|y| self.slope(y), &y, beyond - before + NEAR);
            now += beyond + NEAR;
        }
        y
    }

    /// How many points the patch has.
    pub fn points(&self, y: &Turning) -> usize {
        self.patch(y).points.len()
    }

    fn slope(&self, y: &Turning) -> Turning {
        let [_, _, _, vx, vy, spin] = *y;
        let [length, width, _] = self.size;
        let Patch { points, drags, pressures } = self.patch(y);
        let mut sum = [0.0; 3];
        for ((&(_, [x, y]), &[dx, dy]), pressure) in points.iter().zip(&drags).zip(pressures) {
            sum[0] += pressure * dx;
            sum[1] += pressure * dy;
            sum[2] += pressure * (x * dy - y * dx);
        }
        [vx, vy, spin, sum[0], sum[1], 12.0 * sum[2] / (length * length + width * width)]
    }

    fn patch(&self, &[x, _, angle, vx, vy, spin]: &Turning) -> Patch {
        let ([length, width, height], (sine, cosine)) = (self.size, angle.sin_cos());
        let corner = |[along, across]: [f64; 2]| {
            let (u, v) = (0.5 * along * length, 0.5 * across * width);
            [cosine * u - sine * v, sine * u + cosine * v]
        };
        let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(corner);
        let inside = |place: &[f64; 2]| place[0] + x < 0.0;
        let mut points = Vec::new();
        for (number, from) in corners.iter().enumerate() {
            let to = &corners[(number + 1) % 4];
            if inside(from) {
                points.push((number as u8, *from));
            }
            if inside(from) != inside(to) {
                let part = (-x - from[0]) / (to[0] - from[0]);
                points.push((4 + number as u8, [-x, from[1] + part * (to[1] - from[1])]));
            }
        }
        let drag = |&(_, [px, py]): &(u8, [f64; 2])| {
            let (ux, uy) = (vx - spin * py, vy + spin * px);
            [ux, uy].map(|rate| -self.friction * rate / ux.hypot(uy))
        };
        let drags: Vec<[f64; 2]> = points.iter().map(drag).collect();
        let mut presses = vec![true; points.len()];
        let mut pressures = vec![0.0; points.len()];
        for _ in 0..points.len() {
            let mut matrix = Matrix3::zeros();
            for ((&(_, [px, py]), &[dx, dy]), _) in points.iter().zip(&drags).zip(&presses).filter(|(_, own)| **own) {
                let of_a_unit = Vector3::new(1.0, py + 0.5 * height * dy, -0.5 * height * dx - px);
                matrix += of_a_unit * Vector3::new(1.0, px, py).transpose();
            }
            let plane = matrix.lu().solve(&Vector3::new(GRAVITY, 0.0, 0.0)).expect("three points press");
            pressures = points.iter().map(|(_, [px, py])| plane.dot(&Vector3::new(1.0, *px, *py))).collect();
            let next: Vec<bool> = pressures.iter().map(|pressure| *pressure > 0.0).collect();
            if next == presses {
                break;
            }
            presses = next;
        }
        pressures.iter_mut().for_each(|pressure: &mut f64| *pressure = pressure.max(0.0));
        Patch { points, drags, pressures }
    }
}

impl Patch {
    /// The points, and which of them press.
    fn names(&self) -> Vec<(u8, bool)> {
        self.points.iter().zip(&self.pressures).map(|((name, _), pressure)| (*name, *pressure > 0.0)).collect()
    }
}
