//! Contact: shapes that may touch, and a closed contact as one more joint between two bodies.
//!
//! A contact is a pair of features, one on either body. Each feature is given in the frame of its attachment, with origin P and axis z:
//!
//! | feature | what it is | core |
//! |---|---|---|
//! | point | a vertex (r = 0), a sphere, the end of a capsule | P |
//! | line | an edge (r = 0), the side of a cylinder or capsule | P + s z |
//! | plane | a face, a half space: z points out of the body | (P, z) |
//! | rim | the edge of the end of a cylinder, of radius ρ | the circle about z through P |
//! | hollow ball | a ball from inside, as a rope holds it, of radius L | the sphere about P |
//! | ellipsoid | its surface, with semi-axes along x, y, z | the ellipsoid about P |
//!
//! The unit normal n points from a to b, and the points of contact `p_a`, `p_b` are on the surfaces. The gap and its rate are
//!
//! ```text
//!     φ = n · (p_b − p_a)  [m]          φ̇ = n · (v_b(p) − v_a(p))  [m/s]
//! ```
//!
//! with the velocities of the bodies' material at p, whatever the features: the turning of n and the motion of p on the surfaces do not contribute.
//! So the gradient of every gap is the force n with its torque p × n on b, and its opposite on a. A closed contact is the equation φ = 0 with a
//! multiplier λ ≥ 0; its friction is a [`Grip`]. A surface that moves over its body, as a belt does, changes the slip and no gap:
//!
//! ```text
//!     u_T = (1 − n nᵀ)(v_b(p) + w_b − v_a(p) − w_a)  [m/s]          the drive of a belt does the work −f · (w_b − w_a)  [W]
//! ```
//!
//! with the surface velocities w and the force f of the contact on b. Rolling and spinning friction are moments of the contact on b, with the angular
//! velocity `ω = ω_b − ω_a`, its parts `ω_n` along n and `ω_T` across n, and two lengths ρ and σ (m):
//!
//! ```text
//!     −ρ λ ω_T/|ω_T|  [N m]  while it rolls,   at most ρ λ while it does not            rolling friction
//!     −σ λ sign(ω_n) n [N m] while it spins,   at most σ λ while it does not            spinning friction
//! ```
//!
//! Source: R. I. Leine, Ch. Glocker, A set-valued force law for spatial Coulomb–Contensou friction, European Journal of Mechanics A 22 (2003), for
//! moments as set-valued laws; here with two independent lengths.

use crate::description::body_state::BodyState;
use crate::description::closure::Attachment;
use crate::description::joint::Pose;
use nalgebra::Vector3;
use std::sync::Arc;

/// The shape of a body, in a frame of its own.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// All points with z ≤ 0.
    HalfSpace,
    /// About the origin.
    Sphere {
        /// m.
        radius: f64,
    },
    /// About the z axis from −half to half, with round ends beyond.
    Capsule {
        /// m.
        radius: f64,
        /// Half the length of its core (m).
        half: f64,
    },
    /// About the z axis from −half to half.
    Cylinder {
        /// m.
        radius: f64,
        /// Half its length (m).
        half: f64,
    },
    /// About the origin, with these half sizes (m).
    Box {
        /// m.
        half: Vector3<f64>,
    },
    /// About the origin.
    Ellipsoid {
        /// Its semi-axes along x, y and z (m).
        radii: Vector3<f64>,
    },
    /// A ball from inside, about the origin: a rope of this length holds in it all that it is tied to.
    Hollow {
        /// The length of the rope (m).
        radius: f64,
    },
    /// The origin alone, to which a rope is tied.
    Point,
    /// The convex hull of these points (m).
    Hull(Arc<Vec<Vector3<f64>>>),
    /// A surface of triangles, counterclockwise from outside (m).
    Mesh(Arc<Surface>),
}

/// A surface of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// m.
    pub vertices: Vec<Vector3<f64>>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

/// A shape that may touch others.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// Name of its link or obstacle.
    pub name: String,
    /// The body it is fixed in; `None` is the world.
    pub body: Option<usize>,
    /// Its frame in the body frame, or in the world.
    pub pose: Pose,
    /// Its shape.
    pub shape: Shape,
    /// Velocity of its surface over its body, as of a belt, in the axes of the body or of the world [m/s].
    pub surface_velocity: Vector3<f64>,
}

impl Collider {
    /// A collider whose surface does not move over its body.
    pub fn still(name: impl Into<String>, body: Option<usize>, pose: Pose, shape: Shape) -> Collider {
        Collider { name: name.into(), body, pose, shape, surface_velocity: Vector3::zeros() }
    }
}

/// Two colliders that may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPair {
    /// Its number in the whole mechanism, by which events name it.
    pub number: usize,
    /// One collider, by number.
    pub a: usize,
    /// The other.
    pub b: usize,
    /// μ, not negative.
    pub friction: f64,
    /// e, from 0 to 1.
    pub restitution: f64,
    /// ρ and σ.
    pub moments: MomentLengths,
}

impl ContactPair {
    /// A pair without rolling and spinning friction, of two colliders by number.
    pub fn without_moments(number: usize, [a, b]: [usize; 2], friction: f64, restitution: f64) -> ContactPair {
        ContactPair { number, a, b, friction, restitution, moments: MomentLengths::default() }
    }
}

/// The lengths of rolling and spinning friction: a moment is at most the length times the normal force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MomentLengths {
    /// ρ (m), not negative.
    pub rolling: f64,
    /// σ (m), not negative.
    pub spinning: f64,
}

impl MomentLengths {
    /// Whether both are zero.
    pub fn are_zero(&self) -> bool {
        self.rolling == 0.0 && self.spinning == 0.0
    }
}

/// The touching feature of a body; see the table of the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feature {
    /// A point with a radius (m), which may be zero.
    Point {
        /// r (m).
        radius: f64,
    },
    /// A line along z with a radius (m), which may be zero.
    Line {
        /// r (m).
        radius: f64,
    },
    /// A plane with the normal z out of the body.
    Plane,
    /// A circle about z.
    Rim {
        /// ρ (m).
        radius: f64,
    },
    /// A ball from inside, about the origin of its frame.
    Hollow {
        /// Its radius (m).
        radius: f64,
    },
    /// An ellipsoid about the origin of its frame.
    Ellipsoid {
        /// Its semi-axes along x, y and z (m).
        radii: [f64; 3],
    },
}

/// The tangential force of a closed contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grip {
    /// It brakes the slip: `f = λ (n − μ t)` with `t = u_T/|u_T|` of the slip velocity `u_T` of the same instant.
    Slides {
        /// μ; zero for no friction.
        friction: f64,
        /// For a motion that begins without slip, the direction in which it starts to slide, a unit vector in the world; zero if it does slip.
        direction: Vector3<f64>,
    },
    /// It holds: `u_T = 0`, two equations of velocities more. The body rolls, or its point stays where it is.
    Rolls,
}

/// A moment of friction of a closed contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Moment {
    /// There is none.
    #[default]
    Free,
    /// It brakes: the length times λ, against the turning.
    Brakes {
        /// ρ or σ (m).
        length: f64,
        /// For a motion that begins without turning, the direction in which it starts to turn, a unit vector in the world.
        direction: Vector3<f64>,
    },
    /// It holds: this part of ω is zero, by equations of velocities.
    Holds,
}

/// The moments of rolling and of spinning friction of a closed contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Of `ω_T`; two equations if it holds.
    pub rolling: Moment,
    /// Of `ω_n`; one equation if it holds.
    pub spinning: Moment,
}

impl Moments {
    /// Number of their equations.
    pub fn rows(&self) -> usize {
        let of = |moment: Moment, rows: usize| if moment == Moment::Holds { rows } else { 0 };
        of(self.rolling, 2) + of(self.spinning, 1)
    }

    /// Whether rolling friction brakes.
    pub fn brakes_rolling(&self) -> bool {
        matches!(self.rolling, Moment::Brakes { .. })
    }

    /// Whether one of them brakes.
    pub fn brake(&self) -> bool {
        [self.rolling, self.spinning].iter().any(|moment| matches!(moment, Moment::Brakes { .. }))
    }
}

/// The size of [`Touch::side`] of two rims that lie nearly in one plane.
pub const LEVEL: f64 = 2.0;

/// The features of a contact, on the first and on the second body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// On a, then on b: point–point, plane–point, line–point, line–line, plane–rim, plane–ellipsoid, hollow–point, rim–point and rim–line, both with a radius, rim–rim; line–rim for
    /// an edge, without a radius, that goes through the plane of the rim, and rim–line for one that goes out of the rim along it.
    pub features: [Feature; 2],
    /// The sign of n: of two lines `n = side · (z_a × z_b)/|z_a × z_b|`, of two rims, and of an edge and a rim, as
    /// [`crate::motion::contact_geometry`] says; [`LEVEL`] times it of two rims nearly in one plane. A rim and a line with a radius have 0 for the
    /// place of least distance, 1 for the place at which the line goes out of the rim.
    pub side: f64,
    /// Its friction.
    pub grip: Grip,
}

/// How the gap of two features is measured: between their cores, less their radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pairing {
    /// The cores.
    pub cores: Cores,
    /// The sum of the radii (m).
    pub reach: f64,
    /// The radius of the second feature (m), by which the point of contact is nearer than its core.
    pub radius: f64,
}

/// The cores of two features, the first on a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cores {
    /// Two points.
    Points,
    /// A plane and a point.
    PlanePoint,
    /// A line and a point.
    LinePoint,
    /// Two lines.
    Lines,
    /// A plane and a circle of this radius (m).
    PlaneRim(f64),
    /// A sphere from inside and a point.
    Hollow,
    /// A plane and an ellipsoid of these semi-axes (m).
    PlaneEllipsoid([f64; 3]),
    /// A line and a circle of this radius (m), whose plane the line goes through.
    LineRim(f64),
    /// A circle of this radius (m) and a line, which goes through the cylinder above it, outwards.
    RimLine(f64),
    /// A circle of this radius (m) and a point apart from it.
    RimPoint(f64),
    /// A circle of this radius (m) and a line apart from it.
    RimBesideLine(f64),
    /// Two circles of these radii (m), of which the second goes through the plane of the first, downwards.
    Rims(f64, f64),
    /// Two circles of these radii (m) nearly in one plane, whose axes point to one side.
    LevelRims(f64, f64),
}

impl Touch {
    /// How its gap is measured; `None` for features that make no pair of the list at [`Touch::features`]: such a touch has no equation.
    pub fn pairing(&self) -> Option<Pairing> {
        let (cores, reach, radius) = match self.features {
            [Feature::Point { radius: a }, Feature::Point { radius }] => (Cores::Points, a + radius, radius),
            [Feature::Plane, Feature::Point { radius }] => (Cores::PlanePoint, radius, radius),
            [Feature::Line { radius: a }, Feature::Point { radius }] => (Cores::LinePoint, a + radius, radius),
            [Feature::Line { radius: a }, Feature::Line { radius }] => (Cores::Lines, a + radius, radius),
            [Feature::Plane, Feature::Rim { radius }] => (Cores::PlaneRim(radius), 0.0, 0.0),
            [Feature::Hollow { radius }, Feature::Point { radius: 0.0 }] => (Cores::Hollow, radius, 0.0),
            [Feature::Plane, Feature::Ellipsoid { radii }] => (Cores::PlaneEllipsoid(radii), 0.0, 0.0),
            [Feature::Line { radius: 0.0 }, Feature::Rim { radius }] => (Cores::LineRim(radius), 0.0, 0.0),
            [Feature::Rim { radius }, Feature::Line { radius: 0.0 }] => (Cores::RimLine(radius), 0.0, 0.0),
            [Feature::Rim { radius: rim }, Feature::Line { radius }] => (Cores::RimBesideLine(rim), radius, radius),
            [Feature::Rim { radius: rim }, Feature::Point { radius }] if radius > 0.0 => {
                (Cores::RimPoint(rim), radius, radius)
            }
            [Feature::Rim { radius: a }, Feature::Rim { radius }] if self.side.abs() == LEVEL => {
                (Cores::LevelRims(a, radius), 0.0, 0.0)
            }
            [Feature::Rim { radius: a }, Feature::Rim { radius }] => (Cores::Rims(a, radius), 0.0, 0.0),
            _ => return None,
        };
        Some(Pairing { cores, reach, radius })
    }

    /// μ; zero if it does not slide, or has no equation.
    pub fn friction(&self) -> f64 {
        match (self.pairing(), self.grip) {
            (Some(_), Grip::Slides { friction, .. }) => friction,
            _ => 0.0,
        }
    }

    /// Number of its equations: the gap, and two of velocities if it rolls.
    pub fn rows(&self) -> usize {
        match (self.pairing(), self.grip) {
            (None, _) => 0,
            (Some(_), Grip::Slides { .. }) => 1,
            (Some(_), Grip::Rolls) => 3,
        }
    }
}

/// Two of the points of a rope that are on different bodies, the first of them in the world if one is; `None` if there are none.
pub fn apart(points: &[Attachment]) -> Option<[Attachment; 2]> {
    let first = points.iter().find(|point| point.body.is_none()).or(points.first())?;
    let other = points.iter().find(|point| point.body != first.body)?;
    Some([*first, *other])
}

/// A touch with the frames of its features.
#[derive(Clone, Debug, PartialEq)]
pub struct TouchJoint {
    /// The features that touch, and their friction.
    pub touch: Touch,
    /// The frame of the first feature.
    pub a: Attachment,
    /// The frame of the second.
    pub b: Attachment,
    /// The velocities of both surfaces over their bodies, in the axes of the frames [m/s].
    pub surfaces: [Vector3<f64>; 2],
    /// Its moments of friction.
    pub moments: Moments,
    /// The points of a rope that goes through more than two, in their order ([`crate::motion::reeved`]); empty for everything else. Two of them on
    /// different bodies are `a` and `b`.
    pub reeved: Vec<Attachment>,
}

impl TouchJoint {
    /// Whether one of its bodies is one of another's.
    pub fn shares_a_body(&self, other: &TouchJoint) -> bool {
        let bodies = |joint: &TouchJoint| [joint.a.body, joint.b.body];
        bodies(self).into_iter().flatten().any(|body| bodies(other).contains(&Some(body)))
    }

    /// Whether it is a rope through more than two points.
    pub fn is_reeved(&self) -> bool {
        !self.reeved.is_empty()
    }

    /// The points of a rope through more than two of them, or its two ends.
    pub fn points(&self) -> impl Iterator<Item = &Attachment> {
        let ends = if self.is_reeved() { [None; 2] } else { [Some(&self.a), Some(&self.b)] };
        ends.into_iter().flatten().chain(&self.reeved)
    }

    /// The bodies that a rope through more than two points pulls, in the order of its points; empty for everything else.
    pub fn reeved_bodies(&self) -> Vec<usize> {
        let mut bodies: Vec<usize> = Vec::new();
        for body in self.reeved.iter().filter_map(|point| point.body) {
            if !bodies.contains(&body) {
                bodies.push(body);
            }
        }
        bodies
    }

    /// Gives every point a new place; whether two of them are still on different bodies.
    pub fn move_to(&mut self, place: impl Fn(&Attachment) -> Attachment) -> bool {
        (self.a, self.b) = (place(&self.a), place(&self.b));
        self.reeved.iter_mut().for_each(|point| *point = place(point));
        if let Some([a, b]) = apart(&self.reeved) {
            (self.a, self.b) = (a, b);
        }
        self.a.body != self.b.body
    }

    /// Number of its equations: those of [`Touch::rows`], then of rolling friction that holds, then of spinning friction that holds.
    pub fn rows(&self) -> usize {
        match self.touch.rows() {
            0 => 0,
            rows => rows + self.moments.rows(),
        }
    }

    /// The directions of ω in which its moments hold, for a normal and its tangents.
    pub fn held_turns(
        &self,
        normal: &Vector3<f64>,
        tangents: &[Vector3<f64>; 2],
    ) -> impl Iterator<Item = Vector3<f64>> + use<> {
        let is = |moment: Moment| self.touch.rows() > 0 && moment == Moment::Holds;
        let (rolling, spinning) = (is(self.moments.rolling), is(self.moments.spinning));
        let all = [(rolling, tangents[0]), (rolling, tangents[1]), (spinning, *normal)];
        all.into_iter().filter(|(is, _)| *is).map(|(_, along)| along)
    }

    /// `ω_b − ω_a` [rad/s].
    pub fn turning(&self, bodies: &[BodyState]) -> Vector3<f64> {
        self.b.on(bodies).angular_velocity - self.a.on(bodies).angular_velocity
    }

    /// Whether a surface moves over its body.
    pub fn is_belt(&self) -> bool {
        self.surfaces != [Vector3::zeros(); 2]
    }

    /// `w_b − w_a`: the velocity of the second surface over its body less that of the first, in the world [m/s].
    pub fn surface_velocity(&self, bodies: &[BodyState]) -> Vector3<f64> {
        self.b.axes(bodies) * self.surfaces[1] - self.a.axes(bodies) * self.surfaces[0]
    }
}
