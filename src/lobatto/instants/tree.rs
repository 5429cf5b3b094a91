//! The articulated-body algorithm for a tree, with the wrenches that its joints carry.
//!
//! In the axes of the world about the joint anchors, with the symbols, equations and source of `reduced::articulated_body`,
//! whose numbers it gives up to rounding; the frames by quaternions
//!
//! ```text
//!     q = q_p ∘ mount ∘ (cos θ/2, 0, 0, sin θ/2)        q_link = q ∘ link        p_link = a + Q(q) t_link
//! ```
//!
//! and from the accelerations (α₀ + δα, a₀ + δa) the wrench of each joint, at its anchor [N m, N]:
//!
//! ```text
//!     n = n₀ + I δα + h × δa + Σ (n_c + r_c × f_c)        f = f₀ + m δa + δα × h + Σ f_c        over the children c
//! ```

use crate::instants::constants::{Constants, FixedFrame};
use crate::instants::joints::{Joints, lanes_of};
use crate::instants::quaternion::{Quaternion, constant_product, frame_of, of_unit_length};
use crate::instants::snapshot::{INSTANTS, Instants, LinkPlace, Row, Snapshots};
use crate::numbers::algebra::{Matrix, Symmetric, Vector};
use crate::numbers::lanes::{Lanes, in_lanes};
use crate::numbers::rotations::compose;
use crate::stages::articulated::{Articulated, Eliminated, Push};
use catena_mechanism::description::joint::{FreeRotation, JointKind};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::joint_efforts;
use nalgebra::Vector3;

/// Trees without forces on bodies, in lanes.
#[derive(Clone)]
pub struct LaneInstants<V> {
    mechanism: Mechanism,
    links: Vec<FixedFrame>,
    bodies: Vec<Constants>,
    motion: Vec<Motion<V>>,
    eliminated: Vec<Eliminated<V>>,
    gathered: Vec<Articulated<V>>,
    /// The efforts of forces in joints, freedom by freedom; empty without forces.
    efforts: Vec<Row>,
    scratch: Vec<f64>,
}

/// A body's frame and motion without joint accelerations, and the wrench which that motion needs; later the wrench of its joint.
#[derive(Clone, Copy)]
struct Motion<V> {
    turn: Quaternion<V>,
    frame: Matrix<V>,
    anchor: Vector<V>,
    arm: Vector<V>,
    angular_velocity: Vector<V>,
    angular: Vector<V>,
    linear: Vector<V>,
    inertia: Symmetric<V>,
    moment: Vector<V>,
    torque: Vector<V>,
    force: Vector<V>,
    /// The rest of the accelerations.
    rest: [Vector<V>; 2],
}

impl<V: Lanes> LaneInstants<V> {
    /// For a tree without closures, without forces on bodies, and without efforts that change in time.
    pub fn new(mechanism: &Mechanism, links: &[LinkPlace]) -> Self {
        let bodies = &mechanism.bodies;
        let link = |(body, in_body): &LinkPlace| match body {
            None => FixedFrame::new(0, in_body),
            Some(body) => FixedFrame::new(body + 1, &(bodies[*body].joint.on_child.inverse() * in_body)),
        };
        let count = mechanism.velocity_count;
        let has_efforts = !mechanism.is_unforced();
        LaneInstants {
            links: links.iter().map(link).collect(),
            bodies: (0..bodies.len()).map(|body| Constants::new(bodies, body)).collect(),
            motion: vec![Motion::world(&mechanism.gravity); bodies.len() + 1],
            eliminated: vec![Eliminated::zero(); count],
            gathered: vec![Articulated::zero(); bodies.len() + 1],
            efforts: if has_efforts { vec![[0.0; INSTANTS]; count] } else { Vec::new() },
            scratch: vec![0.0; if has_efforts { count } else { 0 }],
            mechanism: mechanism.clone(),
        }
    }

    /// Root to leaf: frames, velocities, and the accelerations without the accelerations of the joints.
    #[inline(always)]
    fn find_motion(&mut self, joints: &Joints) {
        for (index, body) in self.bodies.iter().enumerate() {
            let (known, rest) = self.motion.split_at_mut(index + 1);
            let (parent, motion) = (&known[body.mount.on], &mut rest[0]);
            let mounted = constant_product(&parent.turn, &body.mount.turn);
            let translations = body.kind.translation_axes();
            let position = |offset: usize| joints.position::<V>(body.position_index + offset);
            let velocity = |offset: usize| joints.velocity::<V>(body.velocity_index + offset);
            let mut arm = parent.frame.apply(Vector::splat(&body.mount.translation));
            let mut linear = parent.linear;
            if !translations.is_empty() {
                let mount = frame_of(&mounted).columns();
                let mut slide = Vector::zero();
                for (offset, &axis) in translations.iter().enumerate() {
                    arm = mount[axis].times_plus(position(offset), arm);
                    slide = mount[axis].times_plus(velocity(offset), slide);
                }
                linear = parent.angular_velocity.cross(slide).times_plus(V::splat(2.0), linear);
            }
            let turn = match body.kind.rotation() {
                FreeRotation::None => mounted,
                FreeRotation::AboutZ => {
                    let [cosine, sine] = joints.half_angle::<V>(body.position_index + translations.len());
                    let (w, Vector([x, y, z])) = mounted;
                    let imaginary = Vector([
                        y.mul_add(sine, x * cosine),
                        x.neg_mul_add(sine, y * cosine),
                        w.mul_add(sine, z * cosine),
                    ]);
                    (z.neg_mul_add(sine, w * cosine), imaginary)
                }
                FreeRotation::Ball => {
                    let (real, imaginary) = joints.ball(body.position_index + translations.len());
                    compose(mounted.0, mounted.1, real, imaginary)
                }
            };
            motion.turn = of_unit_length(turn);
            motion.frame = frame_of(&motion.turn);
            let columns = motion.frame.columns();
            let turning = match body.kind.rotation() {
                FreeRotation::None => Vector::zero(),
                FreeRotation::AboutZ => columns[2].times(velocity(translations.len())),
                FreeRotation::Ball => {
                    let first = translations.len();
                    let rates = Vector([velocity(first), velocity(first + 1), velocity(first + 2)]);
                    motion.frame.apply(rates)
                }
            };
            let spin = parent.angular_velocity.plus(turning);
            let angular = parent.angular_velocity.cross_plus(turning, parent.angular);
            let whirl = parent.angular_velocity.cross(arm);
            let linear = parent.angular_velocity.cross_plus(whirl, parent.angular.cross_plus(arm, linear));
            let inertia = congruence(&motion.frame, &body.inertia);
            let moment = motion.frame.apply(Vector::splat(&body.moment));
            let momentum = inertia.apply(spin);
            motion.torque = moment.cross_plus(linear, spin.cross_plus(momentum, inertia.apply(angular)));
            let swirl = spin.cross(moment);
            let push = spin.cross_plus(swirl, angular.cross(moment));
            motion.force = linear.times_plus(V::splat(body.mass), push);
            motion.anchor = parent.anchor.plus(arm);
            motion.arm = arm;
            motion.angular_velocity = spin;
            motion.angular = angular;
            motion.linear = linear;
            motion.inertia = inertia;
            motion.moment = moment;
        }
    }

    /// Leaf to root: articulated inertias, and the elimination of every free direction.
    #[inline(always)]
    fn eliminate_joints(&mut self) {
        for (index, body) in self.bodies.iter().enumerate().rev() {
            let motion = &self.motion[index + 1];
            let mut subtree = rigid(motion, body.mass).plus(&self.gathered[index + 1]);
            self.gathered[index + 1] = Articulated::zero();
            let armature = self.mechanism.bodies[index].joint.armature;
            let push = |offset: usize| {
                let row = self.efforts.get(body.velocity_index + offset)?;
                Some(Push { effort: lanes_of(row), inertia: V::splat(armature) })
            };
            let translations = body.kind.translation_axes();
            let columns = motion.frame.columns();
            for offset in (translations.len()..body.kind.velocity_count()).rev() {
                let axis = match body.kind.rotation() {
                    FreeRotation::AboutZ => columns[2],
                    _ => columns[offset - translations.len()],
                };
                self.eliminated[body.velocity_index + offset] = subtree.eliminate_rotation(axis, push(offset));
            }
            if !translations.is_empty() {
                let mount = frame_of(&constant_product(&self.motion[body.mount.on].turn, &body.mount.turn)).columns();
                for (offset, &axis) in translations.iter().enumerate().rev() {
                    self.eliminated[body.velocity_index + offset] =
                        subtree.eliminate_translation(mount[axis], push(offset));
                }
            }
            if body.mount.on > 0 {
                let gathered = &mut self.gathered[body.mount.on];
                *gathered = gathered.plus(&subtree.shifted(motion.arm));
            }
        }
    }

    /// Root to leaf: the rest of the accelerations, and its part of the wrench that each body needs.
    #[inline(always)]
    fn resolve_accelerations(&mut self) {
        for (index, body) in self.bodies.iter().enumerate() {
            let (known, rest) = self.motion.split_at_mut(index + 1);
            let ([mut angular, linear], motion) = (known[body.mount.on].rest, &mut rest[0]);
            let mut linear = angular.cross_plus(motion.arm, linear);
            let translations = body.kind.translation_axes().len();
            for offset in 0..body.kind.velocity_count() {
                let screw = &self.eliminated[body.velocity_index + offset];
                let rate = screw.force_ratio.dot_from(linear, screw.torque_ratio.dot_from(angular, screw.bias));
                let moved = if offset < translations { &mut linear } else { &mut angular };
                *moved = screw.axis.times_plus(rate, *moved);
            }
            motion.rest = [angular, linear];
            let torque = motion.torque.plus(motion.inertia.apply(angular));
            motion.torque = motion.moment.cross_plus(linear, torque);
            let force = linear.times_plus(V::splat(body.mass), motion.force);
            motion.force = angular.cross_plus(motion.moment, force);
        }
    }

    /// Leaf to root: a joint carries the wrench of its own body and the wrenches of the joints of the body's children.
    #[inline(always)]
    fn gather_wrenches(&mut self, out: &mut Snapshots) {
        for (index, body) in self.bodies.iter().enumerate().rev() {
            let (known, rest) = self.motion.split_at_mut(index + 1);
            let (parent, motion) = (&mut known[body.mount.on], &rest[0]);
            let axis = motion.frame.columns()[2];
            let along = if body.kind == JointKind::Prismatic { motion.force } else { motion.torque };
            store(along.dot(axis), &mut out.efforts[index]);
            for axis in 0..3 {
                store(motion.force.0[axis], &mut out.wrenches[index][axis]);
                store(motion.torque.0[axis], &mut out.wrenches[index][3 + axis]);
            }
            if body.mount.on > 0 {
                parent.force = parent.force.plus(motion.force);
                parent.torque = motion.arm.cross_plus(motion.force, parent.torque.plus(motion.torque));
            }
        }
    }

    #[inline(always)]
    fn place_links(&self, out: &mut Snapshots) {
        for (link, pose) in self.links.iter().zip(&mut out.poses) {
            let on = &self.motion[link.on];
            let position = on.frame.apply_plus(Vector::splat(&link.translation), on.anchor);
            let (real, imaginary) = constant_product(&on.turn, &link.turn);
            let (translation, rotation) = pose.split_at_mut(3);
            store(real, &mut rotation[0]);
            for axis in 0..3 {
                store(position.0[axis], &mut translation[axis]);
                store(imaginary.0[axis], &mut rotation[1 + axis]);
            }
            let sign = rotation[0].map(|w| if w < 0.0 { -1.0 } else { 1.0 });
            for row in rotation {
                for (entry, sign) in row.iter_mut().zip(sign) {
                    *entry *= sign;
                }
            }
        }
    }
}

impl<V: Lanes> Instants for LaneInstants<V> {
    fn look(&mut self, positions: &[f64], velocities: &[f64], count: usize, out: &mut Snapshots) {
        let (position_count, velocity_count) = (self.mechanism.position_count, self.mechanism.velocity_count);
        if !self.efforts.is_empty() {
            for instant in 0..count {
                let position = &positions[instant * position_count..][..position_count];
                let velocity = &velocities[instant * velocity_count..][..velocity_count];
                joint_efforts(&self.mechanism, 0.0, (position, velocity), &[], &mut self.scratch);
                self.efforts.iter_mut().zip(&self.scratch).for_each(|(row, &effort)| row[instant] = effort);
            }
        }
        let joints = Joints { positions, velocities, count, position_count, velocity_count };
        in_lanes!(V, self.find_motion(&joints));
        in_lanes!(V, self.place_links(out));
        in_lanes!(V, self.eliminate_joints());
        in_lanes!(V, self.resolve_accelerations());
        in_lanes!(V, self.gather_wrenches(out));
    }
}

impl<V: Lanes> Motion<V> {
    /// The world, where gravity enters as an acceleration.
    fn world(gravity: &Vector3<f64>) -> Self {
        let (zero, one) = (V::zero(), V::splat(1.0));
        Motion {
            turn: (one, Vector::zero()),
            frame: Matrix([[one, zero, zero], [zero, one, zero], [zero, zero, one]]),
            anchor: Vector::zero(),
            arm: Vector::zero(),
            angular_velocity: Vector::zero(),
            angular: Vector::zero(),
            linear: Vector::splat(&(-gravity).into()),
            inertia: Symmetric::zero(),
            moment: Vector::zero(),
            torque: Vector::zero(),
            force: Vector::zero(),
            rest: [Vector::zero(); 2],
        }
    }
}

/// The inertia of a single body and the wrench that its motion needs.
#[inline(always)]
fn rigid<V: Lanes>(motion: &Motion<V>, mass: f64) -> Articulated<V> {
    let ([x, y, z], zero, mass) = (motion.moment.0, V::zero(), V::splat(mass));
    Articulated {
        mass: Symmetric([mass, zero, zero, mass, zero, mass]),
        coupling: Matrix([[zero, z, -y], [-z, zero, x], [y, -x, zero]]),
        inertia: motion.inertia,
        force: motion.force,
        torque: motion.torque,
    }
}

#[inline(always)]
fn store<V: Lanes>(lanes: V, row: &mut Row) {
    row.copy_from_slice(lanes.to_array().as_ref());
}

/// `R S Rᵀ` for a constant symmetric S.
#[inline(always)]
fn congruence<V: Lanes>(r: &Matrix<V>, s: &[f64; 6]) -> Symmetric<V> {
    // Written out, because the compiler does not compile code called through a closure for the vectors.
    let [xx, xy, xz, yy, yz, zz] = *s;
    let s = [V::splat(xx), V::splat(xy), V::splat(xz), V::splat(yy), V::splat(yz), V::splat(zz)];
    let (s, [i, j, k]) = (Symmetric(s), r.rows());
    let (x, y, z) = (s.apply(i), s.apply(j), s.apply(k));
    Symmetric([x.dot(i), x.dot(j), x.dot(k), y.dot(j), y.dot(k), z.dot(k)])
}
