//! A box that slides over the edge of a table at the origin, in the plane of its length and height: the equations of its tipping, solved by Runge and
//! Kutta's method.
//!
//! ```text
//!     n · (a + ω̇ × r − ω² r) + 2 ω t · v = 0,     m (a − g) = N (n − μ t),     I ω̇ = r × N (n − μ t)
//! ```
//!
//! n and t are the normal and the direction of the lower face (t along the slip), r goes from the centre to the edge (m), v and a are of the centre, and N
//! is the pressure (N).

use crate::runge_kutta::after;

/// Acceleration of gravity (m/s²).
const GRAVITY: f64 = 9.81;
/// Steps while it tips.
const STEPS: usize = 4000;

/// The place of the centre (m) and the angle (rad), and their rates: (x, z, θ, ẋ, ż, θ̇).
type Tipping = [f64; 6];

/// The box: its length, depth and height (m), the friction, its speed (m/s), and where its centre begins (m), behind the edge.
pub struct OverEdge {
    pub size: [f64; 3],
    pub friction: f64,
    pub speed: f64,
    pub from: f64,
}

impl OverEdge {
    /// When it begins to tip (s): its weight and the friction have no moment about the edge at x = −μ h/2.
    pub fn tips(&self) -> f64 {
        let (braking, way) = (self.friction * GRAVITY, -0.5 * self.friction * self.size[2] - self.from);
        (self.speed - (self.speed * self.speed - 2.0 * braking * way).sqrt()) / braking
    }

    /// A time after that at which it still slides over the edge (s).
    pub fn rest(&self) -> f64 {
        0.3 * self.size[0] / self.speed
    }

    /// The place of the centre [x, z] at that time (m).
    pub fn place(&self) -> [f64; 2] {
        let braked = self.speed - self.friction * GRAVITY * self.tips();
        let begins = [-0.5 * self.friction * self.size[2], 0.5 * self.size[2], 0.0, braked, 0.0, 0.0];
        let [x, z, ..] = after(|y| self.slope(y), begins, self.rest(), STEPS);
        [x, z]
    }

    fn slope(&self, y: &Tipping) -> Tipping {
        let [x, z, angle, vx, vz, rate] = *y;
        let ([sin, cos], [length, _, height]) = ([angle.sin(), angle.cos()], self.size);
        // Of one kilogram.
        let inertia = (length * length + height * height) / 12.0;
        let (normal, along, arm) = ([sin, cos], [cos, -sin], [-x, -z]);
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let force = [normal[0] - self.friction * along[0], normal[1] - self.friction * along[1]];
        let turning = (arm[1] * force[0] - arm[0] * force[1]) / inertia;
        let carried = -GRAVITY * normal[1] + 2.0 * rate * dot(along, [vx, vz]) + rate * rate * dot(normal, arm);
        let pressure = -carried / (dot(normal, force) - turning * dot(along, arm));
        [vx, vz, rate, pressure * force[0], pressure * force[1] - GRAVITY, pressure * turning]
    }
}
