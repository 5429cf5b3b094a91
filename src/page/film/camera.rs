//! The camera of a film: a perspective view of the robot from a chosen side.
//!
//! ```text
//!     d = 1.02 r / (sin(φ/2) · min(1, w/h))           distance of the eye from the middle of the box (m)
//!     (x, y) = (w/2 + f R·p / F·p,  h/2 − f U·p / F·p)  pixels of a point p relative to the eye (m), f = h / (2 tan(φ/2))
//! ```
//!
//! with the half diagonal r of the box that is seen (m), the vertical angle of view φ, the width and height of the picture w and h (pixels), and the
//! unit vectors R to the right, U up and F forward. The page has the same camera (`page/assets/view.js`).

use nalgebra::Vector3;
use std::str::FromStr;

/// The vertical angle of view (rad), as on the page.
const ANGLE: f64 = 35.0 * std::f64::consts::PI / 180.0;

/// The side from which a film is seen: the direction from the robot to the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View(Vector3<f64>);

impl View {
    /// The name, the direction, and the side in words; `corner` is the view of the page.
    const NAMED: [(&'static str, [f64; 3]); 6] = [
        ("corner", [1.5, -1.5, 0.85]),
        ("front", [1.0, 0.0, 0.0]),
        ("back", [-1.0, 0.0, 0.0]),
        ("left", [0.0, 1.0, 0.0]),
        ("right", [0.0, -1.0, 0.0]),
        ("top", [0.0, 0.0, 1.0]),
    ];

    /// The unit vector from the robot to the camera.
    pub(super) fn direction(self) -> Vector3<f64> {
        self.0
    }

    /// The view as words of an address of a page.
    pub(super) fn address(self) -> String {
        format!("{},{},{}", self.0.x, self.0.y, self.0.z)
    }
}

impl Default for View {
    fn default() -> Self {
        let [x, y, z] = Self::NAMED[0].1;
        View(Vector3::new(x, y, z).normalize())
    }
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((_, [x, y, z])) = Self::NAMED.iter().find(|(name, _)| *name == text) {
            return Ok(View(Vector3::new(*x, *y, *z).normalize()));
        }
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse::<f64>()).collect();
        let direction = match numbers.as_deref() {
            Ok([x, y, z]) => Vector3::new(*x, *y, *z).try_normalize(f64::MIN_POSITIVE),
            _ => None,
        };
        let finite = direction.filter(|direction| direction.iter().all(|number| number.is_finite()));
        let names = Self::NAMED.map(|(name, _)| name).join(", ");
        finite.map(View).ok_or_else(|| {
            format!("{text:?} is no view: give one of {names}, or the direction to the camera as three numbers x,y,z")
        })
    }
}

/// An axis-aligned box that grows with the points that are added.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// The corner with the least coordinates (m).
    pub low: Vector3<f64>,
    /// The corner with the largest coordinates (m).
    pub high: Vector3<f64>,
}

impl Bounds {
    /// Contains no point yet.
    pub(super) const NONE: Bounds = Bounds {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Adds a point.
    pub(super) fn add(&mut self, point: &Vector3<f64>) {
        self.low = self.low.inf(point);
        self.high = self.high.sup(point);
    }

    /// The box around both.
    pub(super) fn joined(&self, other: &Bounds) -> Bounds {
        Bounds { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// The middle (m).
    pub(super) fn middle(&self) -> Vector3<f64> {
        0.5 * (self.low + self.high)
    }

    /// The diagonal (m); zero of a box without points.
    pub(super) fn diagonal(&self) -> f64 {
        let diagonal = (self.high - self.low).norm();
        if diagonal.is_finite() { diagonal } else { 0.0 }
    }

    /// The eight corners (m).
    pub(super) fn corners(&self) -> [Vector3<f64>; 8] {
        std::array::from_fn(|k| {
            let pick = |axis: usize| if k >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
            Vector3::new(pick(0), pick(1), pick(2))
        })
    }
}

/// A camera.
#[derive(Clone, Debug)]
pub(super) struct Camera {
    /// Its place (m).
    pub eye: Vector3<f64>,
    /// Unit vectors to the right, up and forward.
    pub axes: [Vector3<f64>; 3],
    /// The focal length f (pixels).
    pub focal: f64,
    /// The middle of the picture (pixels).
    pub middle: [f64; 2],
    /// Nearer than this along the camera's axis nothing is drawn (m).
    pub near: f64,
}

impl Camera {
    /// A camera that sees all of a box in a picture of this width and height (pixels).
    pub(super) fn on(seen: &Bounds, view: View, [width, height]: [usize; 2]) -> Self {
        let (width, height) = (width as f64, height as f64);
        let forward = -view.direction();
        let up = Vector3::z();
        // A camera that looks along z has y upwards.
        let right = forward.cross(&up).try_normalize(1e-9).unwrap_or_else(Vector3::x);
        let axes = [right, right.cross(&forward), forward];
        // A box without a size is seen as one of 1 mm.
        let radius = (0.5 * seen.diagonal()).max(1e-3);
        let distance = 1.02 * radius / ((0.5 * ANGLE).sin() * (width / height).min(1.0));
        let eye = seen.middle() - distance * forward;
        Camera {
            eye,
            axes,
            focal: 0.5 * height / (0.5 * ANGLE).tan(),
            middle: [0.5 * width, 0.5 * height],
            near: distance / 500.0,
        }
    }

    /// The direction of the ray through a place of the picture, with the component 1 along the camera's axis.
    pub(super) fn ray(&self, x: f64, y: f64) -> Vector3<f64> {
        let [right, up, forward] = self.axes;
        forward + ((x - self.middle[0]) / self.focal) * right - ((y - self.middle[1]) / self.focal) * up
    }
}

#[cfg(test)]
mod tests {
    use super::{Bounds, Camera, View};
    use nalgebra::Vector3;

    #[test]
    fn a_camera_sees_the_corners_of_its_box_from_every_side() {
        let mut seen = Bounds::NONE;
        seen.add(&Vector3::new(-1.0, 2.0, 0.5));
        seen.add(&Vector3::new(3.0, 2.5, 4.0));
        for name in ["corner", "front", "back", "left", "right", "top", "-1,0.2,-3"] {
            let view: View = name.parse().expect("a view");
            for [width, height] in [[640, 360], [300, 700]] {
                let camera = Camera::on(&seen, view, [width, height]);
                for corner in seen.corners() {
                    let [right, up, forward] = camera.axes.map(|axis| axis.dot(&(corner - camera.eye)));
                    assert!(forward > 0.0, "{name}");
                    let place = [camera.focal * right / forward, camera.focal * up / forward];
                    assert!(
                        place[0].abs() <= 0.5 * width as f64 && place[1].abs() <= 0.5 * height as f64,
                        "{name} {place:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_view_that_is_none_is_refused_with_the_names_there_are() {
        for text in ["side", "1,2", "0,0,0", "nan,0,1", "inf,0,1", ""] {
            let refused = text.parse::<View>().expect_err(text);
            assert!(refused.contains("corner, front, back, left, right, top"), "{refused}");
        }
    }
}
