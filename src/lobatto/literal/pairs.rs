//! Gap, normal and point of contact of two features for the literal scheme, from where their frames are.
//!
//! With the origins P, the axes z and the radii r of both ends, n from a to b, and `c_a`, `c_b` the points of the cores that are nearest to
//! each other:
//!
//! ```text
//!     φ = n · (c_b − c_a) − r_a − r_b  (m)          p = c_b − r_b n
//!
//!     points                c_a = P_a, c_b = P_b                                         n = (c_b − c_a)/|c_b − c_a|
//!     plane and point       c_a under c_b                                                n = z_a
//!     line and point        (c_b − c_a) · z_a = 0                                        n as of points
//!     lines                 (c_b − c_a) · z_a = (c_b − c_a) · z_b = 0                    n = side z_a × z_b/|z_a × z_b|
//!     plane and rim         c_b = P_b − ρ m,  m = (n − (n·z_b) z_b)/√(1 − (n·z_b)²)      n = z_a
//!     line f and rim        (c_b − c_a) · f = (c_b − c_a) · τ = 0                        n = side f × (m × k)/|f × (m × k)|
//! ```
//!
//! A point of a rim about k with the centre P is `P + ρ m`, its tangent `τ = k × m`. Both conditions of a line and a rim are solved by Newton's
//! method from the point where the line meets the plane of the rim, or leaves the cylinder above it. Source: the table of feature pairs in the
//! project's page on contact, section 2. Nothing here shares code with [`catena_mechanism::motion::contact_geometry`], which it is the oracle
//! for; the two agree where features touch, and with their gradients there.

use catena_mechanism::description::contact::{Feature, Touch};
use nalgebra::{Matrix2, Vector2, Vector3};

/// Iterations for the nearest points of a line and a rim, which are near at the start.
const ITERATIONS: usize = 12;

/// Where the frame of a feature is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// P (m).
    pub(crate) origin: Vector3<f64>,
    /// z.
    pub(crate) axis: Vector3<f64>,
}

/// How two features are to each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// φ (m).
    pub(crate) gap: f64,
    /// n.
    pub(crate) normal: Vector3<f64>,
    /// p (m).
    pub(crate) point: Vector3<f64>,
}

/// The contact of two features; `None` for a pair that the table does not have.
pub(crate) fn meet(touch: &Touch, a: Placed, b: Placed) -> Option<Meeting> {
    let side = touch.side;
    Some(match touch.features {
        [Feature::Point { radius: first }, Feature::Point { radius }] => {
            meeting([a.origin, b.origin], (b.origin - a.origin).normalize(), [first, radius])
        }
        [Feature::Plane, Feature::Point { radius }] => meeting([a.origin, b.origin], a.axis, [0.0, radius]),
        [Feature::Line { radius: first }, Feature::Point { radius }] => {
            let foot = a.origin + a.axis * ((b.origin - a.origin).dot(&a.axis) / a.axis.norm_squared());
            meeting([foot, b.origin], (b.origin - foot).normalize(), [first, radius])
        }
        [Feature::Line { radius: first }, Feature::Line { radius }] => {
            // d + t z_b − s z_a is square to both axes.
            let (apart, along) = (b.origin - a.origin, [a.axis, b.axis]);
            let [s, t] = across(&apart, &along)?;
            let normal = along[0].cross(&along[1]).normalize() * side;
            meeting([a.origin + along[0] * s, b.origin + along[1] * t], normal, [first, radius])
        }
        [Feature::Plane, Feature::Rim { radius: rim }] => {
            let cosine = a.axis.dot(&b.axis);
            let down = (a.axis - b.axis * cosine) / (1.0 - cosine * cosine).sqrt();
            meeting([a.origin, b.origin - down * rim], a.axis, [0.0; 2])
        }
        [Feature::Line { radius: 0.0 }, Feature::Rim { radius: rim }] => {
            let through = (b.origin - a.origin).dot(&b.axis) / a.axis.dot(&b.axis);
            let [on_line, on_rim, normal] = line_and_rim(a, b, rim, through, side)?;
            meeting([on_line, on_rim], normal, [0.0; 2])
        }
        [Feature::Rim { radius: rim }, Feature::Line { radius: 0.0 }] => {
            // |q + s f|² = ρ² of the parts in the plane of the rim, where the line goes outwards.
            let flat = |vector: Vector3<f64>| vector - a.axis * a.axis.dot(&vector);
            let (start, along) = (flat(b.origin - a.origin), flat(b.axis));
            let (square, half) = (along.norm_squared(), start.dot(&along));
            let out = (-half + (half * half - square * (start.norm_squared() - rim * rim)).sqrt()) / square;
            let [on_line, on_rim, normal] = line_and_rim(b, a, rim, out, side)?;
            meeting([on_rim, on_line], normal, [0.0; 2])
        }
        _ => return None,
    })
}

/// From the nearest points of the cores.
fn meeting([on_a, on_b]: [Vector3<f64>; 2], normal: Vector3<f64>, [first, second]: [f64; 2]) -> Meeting {
    Meeting { gap: normal.dot(&(on_b - on_a)) - first - second, normal, point: on_b - normal * second }
}

/// s and t with `d + t z_b − s z_a` square to both axes.
fn across(apart: &Vector3<f64>, [first, second]: &[Vector3<f64>; 2]) -> Option<[f64; 2]> {
    let matrix = Matrix2::new(-first.dot(first), first.dot(second), -first.dot(second), second.dot(second));
    let solution = matrix.lu().solve(&-Vector2::new(apart.dot(first), apart.dot(second)))?;
    Some([solution.x, solution.y])
}

/// The nearest points of a line and a rim, the first `start` along the line, and n.
fn line_and_rim(line: Placed, circle: Placed, rim: f64, start: f64, side: f64) -> Option<[Vector3<f64>; 3]> {
    let (f, k) = (line.axis, circle.axis);
    let arm = line.origin + f * start - circle.origin;
    let mut out = (arm - k * k.dot(&arm)).normalize();
    let mut along = start;
    for _ in 0..ITERATIONS {
        // The tangent of the rim where the iterate is; one step of Newton's method for s and the angle θ about k.
        let tangent = k.cross(&out);
        let apart = circle.origin + out * rim - line.origin - f * along;
        let square = apart.dot(&f);
        let round = apart.dot(&tangent);
        let matrix = Matrix2::new(
            -f.norm_squared(),
            rim * tangent.dot(&f),
            -f.dot(&tangent),
            rim * tangent.norm_squared() - apart.dot(&out),
        );
        let change = matrix.lu().solve(&-Vector2::new(square, round))?;
        along += change.x;
        out = out * change.y.cos() + tangent * change.y.sin();
    }
    let normal = f.cross(&out.cross(&k)).normalize() * side;
    Some([line.origin + f * along, circle.origin + out * rim, normal])
}
