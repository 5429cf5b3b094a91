//! The surfaces of boxes, spheres, cylinders and capsules as triangles, with a normal at each corner.
//!
//! ```text
//!     sphere:   p = r (cos φ cos θ, sin φ cos θ, sin θ)      φ in 40 parts, θ in 24
//!     quarter:  dark where x y > 0                            the seam of a ball: its rolling is seen about every axis
//! ```
//!
//! Shapes of revolution have the axis z. The page draws the same shapes (`page/assets/surfaces.js`).

use nalgebra::Vector3;
use std::f64::consts::PI;

/// Parts of a whole turn, and of half of one from pole to pole.
const AROUND: usize = 40;
const ALONG: usize = 24;

/// A corner (m) and its unit normal.
pub(super) type Corner = (Vector3<f64>, Vector3<f64>);

/// Triangles, three corners each.
pub(super) type Triangles = Vec<[Corner; 3]>;

/// A box with these edges (m).
pub(super) fn cuboid([x, y, z]: [f64; 3]) -> Triangles {
    let half = 0.5 * Vector3::new(x, y, z);
    let mut triangles = Vec::with_capacity(12);
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = side;
            let corner = |u: f64, v: f64| {
                let mut unit = normal;
                // Seen from outside, corners of the other side go round the other way.
                unit[(axis + 1) % 3] = side * u;
                unit[(axis + 2) % 3] = v;
                (unit.component_mul(&half), normal)
            };
            let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// A sphere of this radius (m).
pub(super) fn sphere(radius: f64) -> Triangles {
    revolved(&(0..=ALONG).map(|k| at_pole(radius, 0.0, k)).collect::<Vec<_>>())
}

/// A cylinder of this radius and length (m).
pub(super) fn cylinder(radius: f64, length: f64) -> Triangles {
    let half = 0.5 * length;
    let ring = |radius: f64, z: f64, normal: [f64; 2]| ([radius, z], normal);
    // An edge has a ring for each of its two faces, because their normals differ.
    let profile = [
        [ring(0.0, -half, [0.0, -1.0]), ring(radius, -half, [0.0, -1.0])],
        [ring(radius, -half, [1.0, 0.0]), ring(radius, half, [1.0, 0.0])],
        [ring(radius, half, [0.0, 1.0]), ring(0.0, half, [0.0, 1.0])],
    ];
    profile.iter().flat_map(|face| revolved(face)).collect()
}

/// A capsule of this radius and length between the centres of its caps (m).
pub(super) fn capsule(radius: f64, length: f64) -> Triangles {
    let lower = (0..=ALONG / 2).map(|k| at_pole(radius, -0.5 * length, k));
    let upper = (ALONG / 2..=ALONG).map(|k| at_pole(radius, 0.5 * length, k));
    revolved(&lower.chain(upper).collect::<Vec<_>>())
}

/// A ring of a surface of revolution: distance from the axis and height (m), and the normal in these two directions.
type Ring = ([f64; 2], [f64; 2]);

/// The k-th ring of a sphere about the height `middle` (m), from the lower pole up.
fn at_pole(radius: f64, middle: f64, k: usize) -> Ring {
    let angle = PI * (k as f64 / ALONG as f64 - 0.5);
    let (sine, cosine) = angle.sin_cos();
    let outwards = if k == 0 || k == ALONG { 0.0 } else { cosine };
    ([radius * outwards, middle + radius * sine], [outwards, sine])
}

/// The surface that a profile sweeps about z.
fn revolved(profile: &[Ring]) -> Triangles {
    let mut triangles = Vec::with_capacity(2 * AROUND * profile.len());
    let corner = |([distance, height], [outwards, upwards]): Ring, k: usize| {
        let (sine, cosine) = (2.0 * PI * (k % AROUND) as f64 / AROUND as f64).sin_cos();
        let place = Vector3::new(distance * cosine, distance * sine, height);
        (place, Vector3::new(outwards * cosine, outwards * sine, upwards))
    };
    for rings in profile.windows(2) {
        let (below, above) = (rings[0], rings[1]);
        for k in 0..AROUND {
            let [a, b, c, d] = [corner(below, k), corner(below, k + 1), corner(above, k + 1), corner(above, k)];
            if below.0[0] > 0.0 {
                triangles.push([a, b, c]);
            }
            if above.0[0] > 0.0 {
                triangles.push([a, c, d]);
            }
        }
    }
    triangles
}

/// The quarters of a shape of revolution that have the colour of the shape, and the others.
pub(super) fn quarters(triangles: Triangles) -> [Triangles; 2] {
    let is_light = |corners: &[Corner; 3]| {
        let sum = corners.iter().fold(Vector3::zeros(), |sum, (place, _)| sum + place);
        sum.x * sum.y <= 0.0
    };
    let (light, dark) = triangles.into_iter().partition(is_light);
    [light, dark]
}

#[cfg(test)]
mod tests {
    use super::{Triangles, capsule, cuboid, cylinder, quarters, sphere};
    use std::f64::consts::PI;

    /// The volume inside of a closed surface, by the theorem of Gauss: a sixth of the determinants of its triangles (m³).
    fn volume(triangles: &Triangles) -> f64 {
        triangles.iter().map(|[a, b, c]| a.0.dot(&b.0.cross(&c.0)) / 6.0).sum()
    }

    #[test]
    fn surfaces_are_closed_and_turned_outwards() {
        assert!((volume(&cuboid([1.0, 2.0, 3.0])) - 6.0).abs() < 1e-12);
        // Forty parts of a turn leave out 1 − sin(2π/40)/(2π/40) = 0.4 % of a circle, 24 parts from pole to pole about as much of a sphere.
        let cases = [
            (sphere(0.5), 4.0 / 3.0 * PI * 0.125),
            (cylinder(0.5, 2.0), PI * 0.5),
            (capsule(0.5, 2.0), PI * 0.5 + 4.0 / 3.0 * PI * 0.125),
        ];
        for (triangles, exact) in cases {
            let part = volume(&triangles) / exact;
            assert!(part > 0.985 && part < 1.0, "{part}");
        }
    }

    #[test]
    fn both_colours_of_a_ball_have_the_same_area() {
        let [light, dark] = quarters(sphere(1.0));
        assert_eq!(light.len(), dark.len());
    }
}
