//! Joint accelerations of a tree of bodies in O(n): the articulated-body algorithm.
//!
//! Every quantity has the axes of the world and is referred to the body's own joint anchor `a` (the origin of the
//! joint frame on the child), so a wrench goes from a child to its parent by one lever arm and no 6×6 rotation.
//! For each body, with the joint frame `Q = R F_c.R` [-] on the child and the arm `r = a − a_parent` (m):
//!
//! ```text
//! root to leaf: the motion if every joint acceleration were zero (gravity enters as an acceleration −g of the world)
//!     ω  = ω_p + Q w                                     angular velocity [rad/s]
//!     α₀ = α₀_p + ω_p × Q w                              angular acceleration [rad/s²]
//!     a₀ = a₀_p + K_p r + 2 ω_p × u                      acceleration of the anchor [m/s²], u the sliding velocity [m/s]
//!     K  = [α₀]× + ω ωᵀ − |ω|² 1                         the field of accelerations: a point at ρ has a₀ + K ρ
//!     n  = I α₀ + ω × I ω + h × a₀,   f = m a₀ + K h     torque [N m] at the anchor and force [N] this motion needs
//!
//! leaf to root: the wrench a subtree needs for the rest (δα, δa) of its anchor's acceleration is
//!     [ n ]   [ A   B ] [ δα ]   [ n ]                   A [kg m²], B [kg m], M [kg]; a rigid body has A = I, B = [h]×,
//!     [ f ] = [ Bᵀ  M ] [ δa ] + [ f ]                   M = m 1, and the children add theirs, shifted by their arms
//!     U = 𝓜 s,  d = sᵀU + J,  y = τ − sᵀ(n, f)           J: the rotor of the joint [kg m² or kg]; for each free screw s = (e, 0) or (0, e), one after another:
//!     𝓜 ← 𝓜 − U Uᵀ/d,   (n, f) ← (n, f) + U y/d
//!
//! root to leaf:    q̈ = (y − Uᵀδ)/d,   δ ← δ + s q̈       in the reverse order of the screws
//! ```
//!
//! `I` [kg m²] is the inertia about the anchor and `h` [kg m] the mass times the arm from anchor to centre of mass.
//! Taking out one screw after another is the block elimination of a joint with several degrees of freedom, exactly.
//! Splitting off the motion at q̈ = 0 first spares the product of 𝓜 with the velocity terms in every joint.
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 7 (the recursion) and section
//! 5.3 (the bias force).

use crate::articulated_inertia::{Articulated, Screw};
use crate::link::{Link, rotate_about_z, rotation_axis, split_position, split_velocity};
use catena_mechanism::description::joint::JointKind;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::ground::matrices::{Symmetric, column, cross, product, times};
use nalgebra::{Matrix3, Vector3};

/// Forward dynamics of one mechanism: its constants and the workspace of an evaluation.
#[derive(Clone, Debug)]
pub struct ArticulatedBody {
    pub(crate) links: Vec<Link>,
    /// The motion of the world (entry 0) and of every body (entry body + 1).
    pub(crate) motion: Vec<Motion>,
    /// The sums that children of a body, other than the next in the numbering, have handed to it; zero between evaluations.
    gathered: Vec<Articulated>,
    /// One for each degree of freedom.
    pub(crate) screws: Vec<Screw>,
    /// The rest of the accelerations, laid out as `motion`.
    rest: Vec<Acceleration>,
    /// The torque and force that a subtree needs, of [`ArticulatedBody::respond`], laid out as `motion`.
    pub(crate) wrenches: Vec<(Vector3<f64>, Vector3<f64>)>,
    position_count: usize,
    velocity_count: usize,
}

/// A body's pose and motion at zero joint acceleration, and what that motion needs; all in the axes of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    frame: Matrix3<f64>,
    pub(crate) arm: Vector3<f64>,
    angular_velocity: Vector3<f64>,
    angular_acceleration: Vector3<f64>,
    acceleration: Vector3<f64>,
    field: Matrix3<f64>,
    inertia: Symmetric,
    moment: Vector3<f64>,
    torque: Vector3<f64>,
    force: Vector3<f64>,
}

/// Angular acceleration, and linear acceleration of the anchor.
#[derive(Clone, Copy, Debug, Default)]
struct Acceleration {
    angular: Vector3<f64>,
    linear: Vector3<f64>,
}

impl ArticulatedBody {
    /// Gravity, as it was when the algorithm was set up [m/s²].
    pub fn gravity(&self) -> Vector3<f64> {
        -self.motion[0].acceleration
    }

    /// Sets up the constants and the workspace.
    pub fn new(mechanism: &Mechanism) -> Self {
        let bodies = &mechanism.bodies;
        let mut links: Vec<Link> = (0..bodies.len()).map(|index| Link::new(bodies, index)).collect();
        for (index, body) in bodies.iter().enumerate() {
            match body.parent {
                Some(parent) if parent + 1 == index => links[parent].next_is_child = true,
                Some(parent) => links[parent].branches = true,
                None => {}
            }
        }
        let mut motion = vec![Motion::default(); links.len() + 1];
        motion[0].acceleration = -mechanism.gravity;
        ArticulatedBody {
            motion,
            gathered: vec![Articulated::default(); links.len() + 1],
            screws: vec![Screw::default(); mechanism.velocity_count],
            rest: vec![Acceleration::default(); links.len() + 1],
            wrenches: vec![(Vector3::zeros(), Vector3::zeros()); links.len() + 1],
            links,
            position_count: mechanism.position_count,
            velocity_count: mechanism.velocity_count,
        }
    }

    /// The time derivatives of the joint velocities, written into `acceleration`. Does not allocate.
    ///
    /// `joint_force` are generalised forces [N or N m] that act along the joint velocities; `None` stands for zero forces. The slices have the
    /// lengths of the mechanism's position and velocity vectors. Quaternions need not be of unit length. A mechanism whose acceleration is not
    /// determined (a massless leaf) gives values that are not finite.
    pub fn accelerations(
        &mut self,
        position: &[f64],
        velocity: &[f64],
        joint_force: Option<&[f64]>,
        acceleration: &mut [f64],
    ) {
        assert_eq!(position.len(), self.position_count, "length of the position vector");
        assert_eq!(velocity.len(), self.velocity_count, "length of the velocity vector");
        assert_eq!(acceleration.len(), self.velocity_count, "length of the acceleration vector");
        self.find_motion(position, velocity);
        self.eliminate_joints(joint_force);
        self.resolve_accelerations(acceleration);
    }

    /// The same with joint forces, and with wrenches on the bodies: force (N) and torque about the joint anchor [N m], in
    /// the axes of the world, one a body. Does not allocate.
    pub fn accelerations_with_forces(
        &mut self,
        position: &[f64],
        velocity: &[f64],
        joint_force: &[f64],
        wrenches: &[(Vector3<f64>, Vector3<f64>)],
        acceleration: &mut [f64],
    ) {
        self.find_motion(position, velocity);
        for (motion, (force, torque)) in self.motion[1..].iter_mut().zip(wrenches) {
            motion.force -= force;
            motion.torque -= torque;
        }
        self.eliminate_joints(Some(joint_force));
        self.resolve_accelerations(acceleration);
    }

    /// First pass, root to leaf: poses, velocities, and the accelerations at zero joint acceleration.
    #[inline(never)] // In one body with the other passes the registers do not suffice.
    fn find_motion(&mut self, position: &[f64], velocity: &[f64]) {
        for (index, link) in self.links.iter().enumerate() {
            let (known, rest) = self.motion.split_at_mut(index + 1);
            let (parent, motion) = (&known[link.parent], &mut rest[0]);
            let mounted = product(&parent.frame, &link.mount);
            let mut arm = times(&parent.frame, &link.arm);
            let mut sliding = Vector3::zeros();
            let (frame, turning) = if link.kind == JointKind::Revolute {
                let frame = rotate_about_z(&mounted, position[link.position_index]);
                (frame, column(&frame, 2) * velocity[link.velocity_index])
            } else {
                let (translation, rotation) = split_position(link.kind, &position[link.position_index..]);
                let (slide, turn) = split_velocity(link.kind, &velocity[link.velocity_index..]);
                arm += times(&mounted, &translation);
                sliding = 2.0 * cross(&parent.angular_velocity, &times(&mounted, &slide));
                let frame = product(&mounted, &rotation);
                (frame, times(&frame, &turn))
            };
            let acceleration = parent.acceleration + times(&parent.field, &arm) + sliding;
            let angular_velocity = parent.angular_velocity + turning;
            let angular_acceleration = parent.angular_acceleration + cross(&parent.angular_velocity, &turning);
            let field = acceleration_field(&angular_velocity, &angular_acceleration);
            let inertia = link.inertia.congruence(&frame);
            let moment = times(&frame, &link.moment);
            let torque = inertia.times(&angular_acceleration)
                + cross(&angular_velocity, &inertia.times(&angular_velocity))
                + cross(&moment, &acceleration);
            let force = acceleration * link.mass + times(&field, &moment);
            motion.frame = frame;
            motion.arm = arm;
            motion.angular_velocity = angular_velocity;
            motion.angular_acceleration = angular_acceleration;
            motion.acceleration = acceleration;
            motion.field = field;
            motion.inertia = inertia;
            motion.moment = moment;
            motion.torque = torque;
            motion.force = force;
        }
    }

    /// Second pass, leaf to root: articulated inertias, and the elimination of every free direction.
    #[inline(never)] // In one body with the other passes the registers do not suffice.
    fn eliminate_joints(&mut self, joint_force: Option<&[f64]>) {
        // A first child follows its parent in the numbering, so its share is carried over and never stored.
        let mut carried = Articulated::default();
        for (index, link) in self.links.iter().enumerate().rev() {
            let motion = &self.motion[index + 1];
            let mut subtree =
                Articulated::rigid(link.mass, &motion.moment, motion.inertia, motion.torque, motion.force);
            if link.next_is_child {
                subtree.add(&carried);
            }
            if link.branches {
                subtree.add(&self.gathered[index + 1]);
                self.gathered[index + 1] = Articulated::default();
            }
            let applied = |offset: usize| joint_force.map_or(0.0, |force| force[link.velocity_index + offset]);
            if link.kind == JointKind::Revolute {
                let mut screw = subtree.eliminate_rotation(&column(&motion.frame, 2), applied(0), link.armature);
                // Referred to the parent's anchor already here, which shortens the chain of the third pass.
                screw.angular += cross(&motion.arm, &screw.linear);
                self.screws[link.velocity_index] = screw;
            } else {
                let translations = link.kind.translation_axes();
                let count = link.kind.velocity_count();
                let screws = &mut self.screws[link.velocity_index..link.velocity_index + count];
                for offset in (translations.len()..count).rev() {
                    let axis = rotation_axis(link.kind, offset - translations.len());
                    screws[offset] = subtree.eliminate_rotation(&column(&motion.frame, axis), applied(offset), 0.0);
                }
                let parent = &self.motion[link.parent];
                for (offset, &axis) in translations.iter().enumerate().rev() {
                    let direction = times(&parent.frame, &column(&link.mount, axis));
                    screws[offset] = subtree.eliminate_translation(&direction, applied(offset), link.armature);
                }
            }
            if link.parent == index {
                carried = subtree.shifted(&motion.arm);
            } else if link.parent > 0 {
                self.gathered[link.parent].add(&subtree.shifted(&motion.arm));
            }
        }
    }

    /// Third pass, root to leaf: the joint accelerations, and their contribution to each body's acceleration.
    #[inline(never)] // In one body with the other passes the registers do not suffice.
    pub(crate) fn resolve_accelerations(&mut self, acceleration: &mut [f64]) {
        for (index, link) in self.links.iter().enumerate() {
            let parent = &self.rest[link.parent];
            let mut angular = parent.angular;
            let mut linear = parent.linear + cross(&parent.angular, &self.motion[index + 1].arm);
            if link.kind == JointKind::Revolute {
                let screw = &self.screws[link.velocity_index];
                let rate = screw.rate(&parent.angular, &parent.linear);
                acceleration[link.velocity_index] = rate;
                angular += screw.axis * rate;
            } else {
                let translations = link.kind.translation_axes().len();
                for offset in 0..link.kind.velocity_count() {
                    let screw = &self.screws[link.velocity_index + offset];
                    let rate = screw.rate(&angular, &linear);
                    acceleration[link.velocity_index + offset] = rate;
                    let moved = if offset < translations { &mut linear } else { &mut angular };
                    *moved += screw.axis * rate;
                }
            }
            self.rest[index + 1] = Acceleration { angular, linear };
        }
    }
}

impl Default for Motion {
    /// The world at rest.
    fn default() -> Self {
        Motion {
            frame: Matrix3::identity(),
            arm: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            angular_acceleration: Vector3::zeros(),
            acceleration: Vector3::zeros(),
            field: Matrix3::zeros(),
            inertia: Symmetric::default(),
            moment: Vector3::zeros(),
            torque: Vector3::zeros(),
            force: Vector3::zeros(),
        }
    }
}

/// `[α]× + ω ωᵀ − |ω|² 1`.
#[inline(always)]
fn acceleration_field(omega: &Vector3<f64>, alpha: &Vector3<f64>) -> Matrix3<f64> {
    let (xx, yy, zz) = (omega.x * omega.x, omega.y * omega.y, omega.z * omega.z);
    let (xy, xz, yz) = (omega.x * omega.y, omega.x * omega.z, omega.y * omega.z);
    Matrix3::new(
        -(yy + zz),
        xy - alpha.z,
        xz + alpha.y,
        xy + alpha.z,
        -(xx + zz),
        yz - alpha.x,
        xz - alpha.y,
        yz + alpha.x,
        -(xx + yy),
    )
}
