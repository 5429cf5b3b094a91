//! Articulated inertias in world axes about an anchor, and how one free direction after another is taken out of them.
//!
//! The equations are the ones of [`crate::articulated_body`], leaf to root.

use catena_mechanism::ground::matrices::{
    Symmetric, cross, cross_matrix, cross_symmetric, dot, times, transpose_times, twice_symmetric_part_of_cross,
};
use nalgebra::{Matrix3, Vector3};

/// The articulated inertia and wrench of a subtree at an anchor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Articulated {
    pub angular: Symmetric,
    pub coupling: Matrix3<f64>,
    pub linear: Symmetric,
    pub torque: Vector3<f64>,
    pub force: Vector3<f64>,
}

/// One free direction after its elimination: `q̈ = free − (angular, linear) · δ`, with δ at the body's anchor before
/// the joint moves it, or for a revolute joint at the parent's anchor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Screw {
    pub axis: Vector3<f64>,
    pub angular: Vector3<f64>,
    pub linear: Vector3<f64>,
    pub free: f64,
    /// 1/d.
    pub inverse: f64,
}

impl Articulated {
    /// A single body with its `inertia`, the `moment` of its mass about the anchor, and what its motion needs.
    #[inline(always)]
    pub fn rigid(
        mass: f64,
        moment: &Vector3<f64>,
        inertia: Symmetric,
        torque: Vector3<f64>,
        force: Vector3<f64>,
    ) -> Self {
        let coupling = cross_matrix(moment);
        Articulated { angular: inertia, coupling, linear: Symmetric::scalar(mass), torque, force }
    }

    #[inline(always)]
    pub fn add(&mut self, other: &Articulated) {
        self.angular.add(&other.angular);
        self.coupling += other.coupling;
        self.linear.add(&other.linear);
        self.torque += other.torque;
        self.force += other.force;
    }

    /// Frees the rotation about `axis`, with the torque `applied` on it and a rotor of inertia `armature`.
    #[inline(always)]
    pub fn eliminate_rotation(&mut self, axis: &Vector3<f64>, applied: f64, armature: f64) -> Screw {
        let angular = self.angular.times(axis);
        let linear = transpose_times(&self.coupling, axis);
        self.eliminate(axis, &angular, &linear, dot(axis, &angular) + armature, applied - dot(axis, &self.torque))
    }

    /// Frees the translation along `axis`, with the force `applied` on it and a rotor of inertia `armature`.
    #[inline(always)]
    pub fn eliminate_translation(&mut self, axis: &Vector3<f64>, applied: f64, armature: f64) -> Screw {
        let angular = times(&self.coupling, axis);
        let linear = self.linear.times(axis);
        self.eliminate(axis, &angular, &linear, dot(axis, &linear) + armature, applied - dot(axis, &self.force))
    }

    /// The rank-one step: `U = (angular, linear)`, `d = inertia`, `y = unbalanced`.
    #[inline(always)]
    fn eliminate(
        &mut self,
        axis: &Vector3<f64>,
        angular: &Vector3<f64>,
        linear: &Vector3<f64>,
        inertia: f64,
        unbalanced: f64,
    ) -> Screw {
        let inverse = 1.0 / inertia;
        let scaled_angular = angular * inverse;
        let scaled_linear = linear * inverse;
        let free = unbalanced * inverse;
        self.angular.subtract_dyad(angular, &scaled_angular);
        self.linear.subtract_dyad(linear, &scaled_linear);
        for j in 0..3 {
            for i in 0..3 {
                self.coupling[(i, j)] -= angular[i] * scaled_linear[j];
            }
        }
        self.torque += angular * free;
        self.force += linear * free;
        Screw { axis: *axis, angular: scaled_angular, linear: scaled_linear, free, inverse }
    }

    /// The same subtree seen from a point that lies `−arm` away: the parent's anchor.
    #[inline(always)]
    pub fn shifted(&self, arm: &Vector3<f64>) -> Articulated {
        // A' = A − B'[r]× − (B[r]×)ᵀ with B' = B + [r]×M; the mean of B and B' makes that one symmetric part.
        let lever = cross_symmetric(arm, &self.linear);
        let mean = self.coupling + lever * 0.5;
        let turned = twice_symmetric_part_of_cross(&mean, arm);
        let mut angular = self.angular;
        angular.xx -= turned.xx;
        angular.xy -= turned.xy;
        angular.xz -= turned.xz;
        angular.yy -= turned.yy;
        angular.yz -= turned.yz;
        angular.zz -= turned.zz;
        Articulated {
            angular,
            coupling: self.coupling + lever,
            linear: self.linear,
            torque: self.torque + cross(arm, &self.force),
            force: self.force,
        }
    }
}

impl Screw {
    /// The joint acceleration that the rest of the parent's acceleration leaves.
    #[inline(always)]
    pub fn rate(&self, angular: &Vector3<f64>, linear: &Vector3<f64>) -> f64 {
        self.free - dot(&self.angular, angular) - dot(&self.linear, linear)
    }
}
