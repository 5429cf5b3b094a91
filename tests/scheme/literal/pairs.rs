//! Gap, normal and point of contact of two features for the literal scheme, from where their frames are.
//!
//! Both ends have the origins P, the axes z and the radii r; n points from a to b, and `c_a`, `c_b` are the points of the cores that are nearest to
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
//!     rim and point         (c_b − c_a) · τ = 0                                          n as of points
//!     rim and round line    (c_b − c_a) · f = (c_b − c_a) · τ = 0                        n as of points
//!     rims                  (c_b − c_a) · τ_a = (c_b − c_a) · τ_b = 0                    n = side τ_a × τ_b/|τ_a × τ_b|
//! ```
//!
//! A point of a rim about k with the centre P is `P + ρ m`, its tangent `τ = k × m`. Both conditions of a line and a rim are solved by Newton's
//! method from the point where the line meets the plane of the rim, or leaves the cylinder above it. The conditions of a round line and of two rims
//! have several solutions. There Newton's method starts at the least distance of points at equal angles on a rim from the other core, among the
//! points on the side of [`Touch::side`]: m · f > 0 for a line that goes outwards, `τ_b · k_a < 0` for a rim that goes down through the plane of
//! another, and the left of the way from centre to centre for two rims nearly in one plane.
//!
//! Source: the conditions of nearest points, as above. This file shares no code with [`catena::mechanism::motion::contact_geometry`], for which it is
//! the oracle. Both agree at places where features touch, as do their gradients.

use catena::mechanism::description::contact::{Feature, LEVEL, Touch};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use std::f64::consts::TAU;

/// Iterations for the nearest points of a rim and another core, which are near at the start.
const ITERATIONS: usize = 12;
/// Points of a rim at which the least distance is looked for.
const LOOKED_AT: u32 = 72;

/// The frame of a feature.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// P (m).
    pub(crate) origin: Vector3<f64>,
    /// z.
    pub(crate) axis: Vector3<f64>,
    /// x, y and z as columns.
    pub(crate) axes: Matrix3<f64>,
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
        [Feature::Hollow { radius }, Feature::Point { .. }] => {
            let apart = b.origin - a.origin;
            Meeting { gap: radius - apart.norm(), normal: -apart.normalize(), point: b.origin }
        }
        [Feature::Plane, Feature::Ellipsoid { radii }] => {
            // The lowest point is the image of that of the unit ball under the map x → A x, whose tangent planes turn by A⁻¹.
            let stretch = b.axes * Matrix3::from_diagonal(&Vector3::from(radii)) * b.axes.transpose();
            let lowest = stretch * -(stretch * a.axis).normalize();
            meeting([a.origin, b.origin + lowest], a.axis, [0.0; 2])
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
        [Feature::Rim { radius: rim }, Feature::Point { radius }] if radius > 0.0 => {
            let on_rim = Circle::new(a, rim).nearest(&b.origin);
            meeting([on_rim, b.origin], (b.origin - on_rim).normalize(), [0.0, radius])
        }
        [Feature::Rim { radius: rim }, Feature::Line { radius }] => {
            let [on_rim, on_line] = rim_and_round_line(Circle::new(a, rim), b, side > 0.0)?;
            meeting([on_rim, on_line], (on_line - on_rim).normalize(), [0.0, radius])
        }
        [Feature::Rim { radius: rim }, Feature::Rim { radius: other }] => {
            let [on_a, on_b, normal] = rim_and_rim([Circle::new(a, rim), Circle::new(b, other)], side)?;
            meeting([on_a, on_b], normal, [0.0; 2])
        }
        _ => return None,
    })
}

/// A rim, by angles about its axis.
#[derive(Clone, Copy, Debug)]
struct Circle {
    centre: Vector3<f64>,
    axes: [Vector3<f64>; 3],
    radius: f64,
}

impl Circle {
    fn new(placed: Placed, radius: f64) -> Self {
        let k = placed.axis;
        let x = k.cross(&Vector3::ith(k.iamin(), 1.0)).normalize();
        Circle { centre: placed.origin, axes: [x, k.cross(&x), k], radius }
    }

    /// m and τ at an angle (rad).
    fn frame(&self, angle: f64) -> [Vector3<f64>; 2] {
        let [x, y, _] = self.axes;
        [x * angle.cos() + y * angle.sin(), y * angle.cos() - x * angle.sin()]
    }

    /// `P + ρ m` (m).
    fn point(&self, angle: f64) -> Vector3<f64> {
        self.centre + self.frame(angle)[0] * self.radius
    }

    /// The angle of its point that is nearest to another point (rad).
    fn angle_of(&self, point: &Vector3<f64>) -> f64 {
        let arm = point - self.centre;
        self.axes[1].dot(&arm).atan2(self.axes[0].dot(&arm))
    }

    /// Its point that is nearest to another one (m).
    fn nearest(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.point(self.angle_of(point))
    }

    /// Among equally spaced allowed angles, the one whose point has the least distance (m).
    fn least(&self, allowed: impl Fn(f64) -> bool, distance: impl Fn(&Vector3<f64>) -> f64) -> Option<f64> {
        let angles = (0..LOOKED_AT).map(|number| TAU * f64::from(number) / f64::from(LOOKED_AT));
        let of = |angle: &f64| distance(&self.point(*angle));
        angles.filter(|angle| allowed(*angle)).min_by(|one, other| of(one).total_cmp(&of(other)))
    }
}

/// The nearest points of a rim and a line; if `outwards` where the line goes out of the rim.
fn rim_and_round_line(rim: Circle, line: Placed, outwards: bool) -> Option<[Vector3<f64>; 2]> {
    let f = line.axis.normalize();
    let foot = |point: &Vector3<f64>| line.origin + f * f.dot(&(point - line.origin));
    let allowed = |angle: f64| !outwards || rim.frame(angle)[0].dot(&f) > 0.0;
    let mut angle = rim.least(allowed, |point| (foot(point) - point).norm())?;
    let mut along = f.dot(&(rim.point(angle) - line.origin));
    for _ in 0..ITERATIONS {
        // d = c_b − c_a, with ∂d/∂s = f and ∂d/∂θ = −ρ τ.
        let [out, tangent] = rim.frame(angle);
        let d = line.origin + f * along - rim.point(angle);
        let slope = -rim.radius * f.dot(&tangent);
        let matrix = Matrix2::new(1.0, slope, f.dot(&tangent), -rim.radius - d.dot(&out));
        let change = matrix.lu().solve(&-Vector2::new(d.dot(&f), d.dot(&tangent)))?;
        along += change.x;
        angle += change.y;
    }
    Some([rim.point(angle), line.origin + f * along])
}

/// The nearest points of two rims, at the place that the side says, and n.
fn rim_and_rim(rims: [Circle; 2], side: f64) -> Option<[Vector3<f64>; 3]> {
    let [a, b] = rims;
    let (k, l) = (a.axes[2], b.axes[2]);
    let left = (k + l).cross(&(b.centre - a.centre));
    let allowed = |angle: f64| {
        let [out, tangent] = b.frame(angle);
        if side.abs() == LEVEL {
            (b.centre + out * b.radius - a.centre).dot(&left) > 0.0
        } else {
            tangent.dot(&k) < 0.0
        }
    };
    let second = b.least(allowed, |point| (a.nearest(point) - point).norm())?;
    let mut angles = Vector2::new(a.angle_of(&b.point(second)), second);
    let frames = |angles: &Vector2<f64>| [a.frame(angles.x), b.frame(angles.y)];
    for _ in 0..ITERATIONS {
        // d = c_b − c_a, with ∂d/∂α = −ρ_a τ_a and ∂d/∂β = ρ_b τ_b.
        let [[m, along], [u, across]] = frames(&angles);
        let d = b.point(angles.y) - a.point(angles.x);
        let mixed = along.dot(&across);
        let matrix = Matrix2::new(-a.radius - d.dot(&m), b.radius * mixed, -a.radius * mixed, b.radius - d.dot(&u));
        angles += matrix.lu().solve(&-Vector2::new(d.dot(&along), d.dot(&across)))?;
    }
    let [[_, along], [_, across]] = frames(&angles);
    let normal = along.cross(&across).normalize() * side.signum();
    Some([a.point(angles.x), b.point(angles.y), normal])
}

/// The meeting of features from the nearest points of their cores.
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
