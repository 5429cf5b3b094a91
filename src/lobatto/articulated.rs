//! The residual of the stage equations and its articulated solve: the backward and the forward sweep.
//!
//! With `Δx_i`, `N_i` the displacements of a body at stage i (world axes) and start values `v, ω, Σ, com` the residual
//! of row k is (method page, sections 3 and 4, in the world axes of the start)
//!
//! ```text
//!     f_k = m ( Σ_i B_ki (Δx_i − h c_i v) − h² g )                    [kg m]      force part, h² included
//!     W_k = Σ_i B_ki (N_i − h c_i ω̂),   C_k = Σ (1 + N_k)ᵀ
//!     e_k = vee(W_k C_k − (W_k C_k)ᵀ)                                 [kg m²]     torque about the centre of mass
//!     Σ_k = (1 + N_k) C_k,   J_k = ½ tr J − Σ_k                       [kg m²]     inertia at stage k
//! ```
//!
//! and the Newton step is the articulated-body recursion (Featherstone 2008, chapter 7), lane by lane, each row with
//! the geometry of its own stage: `H(q_k) α_k = −ρ_k` (newton.md, section 4a). Leaf to root, for every free axis `s`,
//!
//! ```text
//!     d = sᵀ A s,   α₀ = −sᵀ p / d,   p ← p + A s α₀,   A ← A − A s sᵀ A / d
//! ```
//!
//! then both are moved by the arm to the parent's anchor; root to leaf, `α = α₀ − (A s)ᵀ η / d`, `η ← η + s α`. The
//! axes of a joint of several degrees of freedom are eliminated one after the other, which is the exact block
//! elimination. The unknowns' increment is `δ_i = Σ_k Â_ik α_k`.
//!
//! The projection of the momentum at the end of the step (2.5.11h) is the same recursion at the last stage with the
//! momenta `p̄ = p₀ + h Σ b_k F_k` in place of the residual; its solution is the new joint velocity:
//!
//! ```text
//!     P = m ( v + h⁻¹ Σ_i w_i (Δx_i − h c_i v) + h b_s g ),   π = vee(Z − Zᵀ),  Z = (ω̂ + h⁻¹ Σ_i w_i (N_i − h c_i ω̂)) C_s
//! ```

use super::algebra::{Matrix, Symmetric, Vector};
use super::lanes::Lanes;
use super::stage::{Articulated, Eliminated, MAX_LANES, StagePose, Stages, horner};
use super::start::{BodyPlan, BodyStart, Children};
use crate::model::FreeRotation;

/// The constants of one backward sweep.
struct Sweep<'s, V> {
    /// Mixing matrix of the sweep, by columns.
    columns: &'s [V; MAX_LANES],
    /// `h c_i`.
    times: V,
    /// One where a row has its stage's geometry.
    moved: V,
    /// What gravity adds to the mixed displacement of a centre of mass.
    gravity: [f64; 3],
}

impl<V: Lanes> Stages<V> {
    /// Residual and articulated factorisation of all rows, leaf to root.
    #[inline(always)]
    pub fn sweep_residual(&mut self, gravity: &[f64; 3]) {
        let columns = self.coefficients.residual;
        let square = -self.step * self.step;
        let sweep = Sweep {
            columns: &columns,
            times: self.coefficients.nodes * V::splat(self.step),
            moved: self.coefficients.moved,
            gravity: [square * gravity[0], square * gravity[1], square * gravity[2]],
        };
        self.backward::<false>(&sweep);
    }

    /// Momenta and articulated factorisation at the end of the step (in the last active lane), leaf to root.
    #[inline(always)]
    pub fn sweep_momentum(&mut self, gravity: &[f64; 3]) {
        let mut columns = self.coefficients.momentum;
        let inverse = V::splat(1.0 / self.step);
        for column in &mut columns {
            *column = *column * inverse;
        }
        let factor = self.step * self.coefficients.last_weight;
        let sweep = Sweep {
            columns: &columns,
            times: self.coefficients.nodes * V::splat(self.step),
            moved: V::splat(1.0),
            gravity: [factor * gravity[0], factor * gravity[1], factor * gravity[2]],
        };
        self.backward::<true>(&sweep);
    }

    #[inline(always)]
    fn backward<const MOMENTUM: bool>(&mut self, sweep: &Sweep<V>) {
        let mut carried = Articulated {
            mass: Symmetric::zero(),
            coupling: Matrix::zero(),
            inertia: Symmetric::zero(),
            force: Vector::zero(),
            torque: Vector::zero(),
        };
        for index in (0..self.plan.bodies.len()).rev() {
            let plan = &self.plan.bodies[index];
            let known = &self.start.bodies[index];
            let pose = self.poses[index];
            let (own, turn) = body_residual::<V, MOMENTUM>(sweep, plan, known, &pose);
            let mut total = match plan.children {
                Children::None => own,
                Children::Next => own.plus(&carried),
                Children::Slot(slot) => own.plus(&self.slots[slot]),
            };

            // Rotations first: they are the outermost axes of the joint.
            let rotations = plan.first_axis + plan.translations;
            match plan.rotation {
                FreeRotation::None => {}
                FreeRotation::AboutZ => {
                    let axis = Vector::splat(&self.start.axes[rotations]);
                    let axis = turn.apply_plus(axis, axis);
                    // Nobody asks for what is left of a root: its one axis needs no more than the solution.
                    self.eliminated[rotations] = if plan.parent.is_none() && plan.translations == 0 {
                        total.solve_rotation(axis)
                    } else {
                        total.eliminate_rotation(axis)
                    };
                }
                FreeRotation::Ball => {
                    let vector = self.rotation_vector(rotations).times(sweep.moved);
                    let (first, second) = tangent(vector.dot(vector));
                    for freedom in (rotations..rotations + 3).rev() {
                        let axis = Vector::splat(&self.start.axes[freedom]);
                        let tilted = if MOMENTUM {
                            axis
                        } else {
                            let once = vector.cross(axis);
                            vector.cross(once).times_plus(second, once.times_minus(first, axis))
                        };
                        let axis = turn.apply_plus(tilted, tilted);
                        self.eliminated[freedom] =
                            if plan.alone { total.eliminate_spin(axis) } else { total.eliminate_rotation(axis) };
                    }
                }
            }
            if plan.translations > 0 {
                for freedom in (plan.first_axis..rotations).rev() {
                    let axis = Vector::splat(&self.start.axes[freedom]);
                    let turned = match plan.parent {
                        Some(parent) => {
                            let parent = self.poses[parent];
                            super::stage::rotate_increment(parent.w, parent.u, axis).times_plus(sweep.moved, axis)
                        }
                        None => axis,
                    };
                    self.eliminated[freedom] =
                        if plan.alone { total.solve_translation(turned) } else { total.eliminate_translation(turned) };
                }
            }

            if let Some(parent) = plan.parent {
                let moved = pose.anchor.minus(self.poses[parent].anchor);
                let arm = moved.times_plus(sweep.moved, Vector::splat(&known.arm));
                self.arms[index] = arm;
                let shifted = total.shifted(arm);
                match plan.parent_collects {
                    Children::Slot(slot) if !plan.first_collected => {
                        self.slots[slot] = self.slots[slot].plus(&shifted);
                    }
                    Children::Slot(slot) => self.slots[slot] = shifted,
                    _ => carried = shifted,
                }
            }
        }
    }

    /// Root to leaf: `α` of every degree of freedom, mixed into the increments; the largest increment in each lane.
    #[inline(always)]
    pub fn sweep_increments(&mut self) -> V {
        let mut largest = V::zero();
        self.forward(|stages, freedom, alpha| {
            let increment = alpha.mix(&stages.coefficients.solve);
            stages.increment[freedom] = increment;
            largest = increment.max_abs(largest);
        });
        largest
    }

    /// Root to leaf after [`Stages::sweep_momentum`]: the new velocities, from the last active lane.
    #[inline(always)]
    pub fn sweep_velocities(&mut self, velocity: &mut [f64]) {
        let last = self.coefficients.active - 1;
        self.forward(|_, freedom, rate| velocity[freedom] = rate.to_array().as_ref()[last]);
    }

    #[inline(always)]
    fn forward(&mut self, mut take: impl FnMut(&mut Self, usize, V)) {
        let mut twist = (Vector::zero(), Vector::zero());
        for index in 0..self.plan.bodies.len() {
            let plan = &self.plan.bodies[index];
            let (first_axis, translations, children) = (plan.first_axis, plan.translations, plan.children);
            let rotations = match plan.rotation {
                FreeRotation::None => 0,
                FreeRotation::AboutZ => 1,
                FreeRotation::Ball => 3,
            };
            match plan.parent_collects {
                Children::None => twist = (Vector::zero(), Vector::zero()),
                Children::Next => twist.0 = twist.1.cross_plus(self.arms[index], twist.0),
                Children::Slot(slot) => {
                    twist = self.twists[slot];
                    twist.0 = twist.1.cross_plus(self.arms[index], twist.0);
                }
            }
            let turning = first_axis + translations;
            for freedom in first_axis..turning + rotations {
                let joint = self.eliminated[freedom];
                // Two chains of three, because each body waits for its parent's.
                let alpha = joint.force_ratio.dot_from(twist.0, joint.bias) - joint.torque_ratio.dot(twist.1);
                if freedom < turning {
                    twist.0 = joint.axis.times_plus(alpha, twist.0);
                } else {
                    twist.1 = joint.axis.times_plus(alpha, twist.1);
                }
                take(self, freedom, alpha);
            }
            if let Children::Slot(slot) = children {
                self.twists[slot] = twist;
            }
        }
    }
}

/// Inertia and residual of one body about its anchor, and `N` at the rows' stages.
#[inline(always)]
fn body_residual<V: Lanes, const MOMENTUM: bool>(
    sweep: &Sweep<V>,
    plan: &BodyPlan,
    known: &BodyStart,
    pose: &StagePose<V>,
) -> (Articulated<V>, Matrix<V>) {
    let [x, y, z] = pose.u.0;
    let (x2, y2, z2) = (x + x, y + y, z + z);
    // N = sym + hat(antisymmetric part): the products of the quaternion, which is what gets mixed.
    let (xx, xy, xz) = (x2 * x, x2 * y, x2 * z);
    let (yy, yz, zz) = (y2 * y, y2 * z, z2 * z);
    let (wx, wy, wz) = (pose.w * x2, pose.w * y2, pose.w * z2);
    let turn = increment_matrix([xx, xy, xz, yy, yz, zz], [wx, wy, wz]);

    let com = Vector::splat(&known.com);
    let swing = turn.apply(com);
    let displaced = swing.plus(pose.anchor);
    let columns = sweep.columns;
    let start_velocity = Vector::<V>::splat(&known.velocity);
    let start_spin = Vector::<V>::splat(&known.spin);
    let ahead = start_velocity.times_minus(sweep.times, displaced);
    let ahead_turn = start_spin.times_minus(sweep.times, Vector([wx, wy, wz]));
    let mut path = Vector([ahead.0[0].mix(columns), ahead.0[1].mix(columns), ahead.0[2].mix(columns)]);
    let mut spin = Vector([ahead_turn.0[0].mix(columns), ahead_turn.0[1].mix(columns), ahead_turn.0[2].mix(columns)]);
    if MOMENTUM {
        path = path.plus(start_velocity);
        spin = spin.plus(start_spin);
    }
    let mixed = increment_matrix(
        [xx.mix(columns), xy.mix(columns), xz.mix(columns), yy.mix(columns), yz.mix(columns), zz.mix(columns)],
        spin.0,
    );

    // From here on: the geometry of the rows.
    let turn = if MOMENTUM { turn } else { turn.times(sweep.moved) };
    let com = swing.times_plus(sweep.moved, com);
    let [sxx, sxy, sxz, syy, syz, szz] = known.sigma;
    let sigma_rows =
        [Vector::splat(&[sxx, sxy, sxz]), Vector::splat(&[sxy, syy, syz]), Vector::splat(&[sxz, syz, szz])];
    // C = Σ (1 + N)ᵀ: row i of C is Σ_i + N Σ_i.
    let c = Matrix([
        turn.apply_plus(sigma_rows[0], sigma_rows[0]).0,
        turn.apply_plus(sigma_rows[1], sigma_rows[1]).0,
        turn.apply_plus(sigma_rows[2], sigma_rows[2]).0,
    ]);
    let c_columns = c.columns();
    let turn_rows = turn.rows();
    let mixed_rows = mixed.rows();
    let entry = |row: usize, column: usize| turn_rows[row].dot_plus(c_columns[column], c.0[row][column]);
    let half_trace = V::splat(plan.half_trace);
    let own = Symmetric([
        half_trace - entry(0, 0),
        -entry(0, 1),
        -entry(0, 2),
        half_trace - entry(1, 1),
        -entry(1, 2),
        half_trace - entry(2, 2),
    ]);
    let torque = Vector([
        mixed_rows[1].dot_from(c_columns[2], mixed_rows[2].dot(c_columns[1])),
        mixed_rows[2].dot_from(c_columns[0], mixed_rows[0].dot(c_columns[2])),
        mixed_rows[0].dot_from(c_columns[1], mixed_rows[1].dot(c_columns[0])),
    ]);
    let mass = V::splat(plan.mass);
    let gravity = Vector::splat(&sweep.gravity);
    let force = path.plus(gravity).times(mass);
    let torque = com.cross_plus(force, torque);
    let (force, torque) =
        if MOMENTUM { (force.times(V::splat(-1.0)), torque.times(V::splat(-1.0))) } else { (force, torque) };

    // Parallel axes: I + m (|c|² − c cᵀ), and the coupling −m ĉ.
    let heavy = com.times(mass);
    let ([cx, cy, cz], [mx, my, mz]) = (com.0, heavy.0);
    let [ixx, ixy, ixz, iyy, iyz, izz] = own.0;
    let (mxx, myy, mzz) = (mx * cx, my * cy, mz * cz);
    let inertia = Symmetric([
        ixx + (myy + mzz),
        mx.neg_mul_add(cy, ixy),
        mx.neg_mul_add(cz, ixz),
        iyy + (mxx + mzz),
        my.neg_mul_add(cz, iyz),
        izz + (mxx + myy),
    ]);
    let zero = V::zero();
    let coupling = Matrix([[zero, mz, -my], [-mz, zero, mx], [my, -mx, zero]]);
    let articulated =
        Articulated { mass: Symmetric([mass, zero, zero, mass, zero, mass]), coupling, inertia, force, torque };
    (articulated, turn)
}

/// `N = 2 (w û + u uᵀ − |u|²)` from the products `2 u uᵀ` (xx, xy, xz, yy, yz, zz) and `2 w u`; linear in both.
#[inline(always)]
fn increment_matrix<V: Lanes>([xx, xy, xz, yy, yz, zz]: [V; 6], [wx, wy, wz]: [V; 3]) -> Matrix<V> {
    Matrix([[-(yy + zz), xy - wz, xz + wy], [xy + wz, -(xx + zz), yz - wx], [xz - wy, yz + wx, -(xx + yy)]])
}

/// `(1 − cos φ)/φ²` and `(φ − sin φ)/φ³` from `φ²`: the coefficients of the tangent of the exponential map. They only
/// span the projection and steer the Newton step, so their series may be shorter than the poses'.
#[inline(always)]
fn tangent<V: Lanes>(square: V) -> (V, V) {
    const FIRST: [f64; 10] = tangent_series(2);
    const SECOND: [f64; 10] = tangent_series(3);
    (horner(&FIRST, square), horner(&SECOND, square))
}

/// `(−1)ⁿ / (2n + first)!`.
const fn tangent_series(first: usize) -> [f64; 10] {
    let mut terms = [if first == 2 { 0.5 } else { 1.0 / 6.0 }; 10];
    let mut n = 1;
    while n < 10 {
        terms[n] = -terms[n - 1] / (((2 * n + first) * (2 * n + first - 1)) as f64);
        n += 1;
    }
    terms
}

impl<V: Lanes> Articulated<V> {
    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        Articulated {
            mass: self.mass.plus(&other.mass),
            coupling: self.coupling.plus(&other.coupling),
            inertia: self.inertia.plus(&other.inertia),
            force: self.force.plus(other.force),
            torque: self.torque.plus(other.torque),
        }
    }

    /// Eliminates a rotation about `axis` through the anchor.
    #[inline(always)]
    fn eliminate_rotation(&mut self, axis: Vector<V>) -> Eliminated<V> {
        let force = self.coupling.apply(axis);
        let torque = self.inertia.apply(axis);
        let inverse = axis.dot(torque).reciprocal();
        let bias = -(axis.dot(self.torque) * inverse);
        self.eliminate(axis, force, torque, inverse, bias)
    }

    /// The solution for a rotation about `axis` of a body that hangs on the world.
    #[inline(always)]
    fn solve_rotation(&self, axis: Vector<V>) -> Eliminated<V> {
        let inverse = axis.dot(self.inertia.apply(axis)).reciprocal();
        let bias = -(axis.dot(self.torque) * inverse);
        Eliminated { axis, force_ratio: Vector::zero(), torque_ratio: Vector::zero(), bias }
    }

    /// Eliminates a rotation about `axis` where nothing couples it to translations.
    #[inline(always)]
    fn eliminate_spin(&mut self, axis: Vector<V>) -> Eliminated<V> {
        let torque = self.inertia.apply(axis);
        let inverse = axis.dot(torque).reciprocal();
        let bias = -(axis.dot(self.torque) * inverse);
        let torque_ratio = torque.times(inverse);
        self.inertia = self.inertia.minus_outer(torque, torque_ratio);
        self.torque = torque.times_plus(bias, self.torque);
        Eliminated { axis, force_ratio: Vector::zero(), torque_ratio, bias }
    }

    /// The solution for a translation along `axis` of a body that floats alone: the axes do not couple either.
    #[inline(always)]
    fn solve_translation(&self, axis: Vector<V>) -> Eliminated<V> {
        let bias = -(axis.dot(self.force) * axis.dot(self.mass.apply(axis)).reciprocal());
        Eliminated { axis, force_ratio: Vector::zero(), torque_ratio: Vector::zero(), bias }
    }

    /// Eliminates a translation along `axis`.
    #[inline(always)]
    fn eliminate_translation(&mut self, axis: Vector<V>) -> Eliminated<V> {
        let force = self.mass.apply(axis);
        let torque = self.coupling.apply_transposed(axis);
        let inverse = axis.dot(force).reciprocal();
        let bias = -(axis.dot(self.force) * inverse);
        self.eliminate(axis, force, torque, inverse, bias)
    }

    #[inline(always)]
    fn eliminate(
        &mut self,
        axis: Vector<V>,
        force: Vector<V>,
        torque: Vector<V>,
        inverse: V,
        bias: V,
    ) -> Eliminated<V> {
        let (force_ratio, torque_ratio) = (force.times(inverse), torque.times(inverse));
        self.mass = self.mass.minus_outer(force, force_ratio);
        self.coupling = self.coupling.minus_outer(force, torque_ratio);
        self.inertia = self.inertia.minus_outer(torque, torque_ratio);
        self.force = force.times_plus(bias, self.force);
        self.torque = torque.times_plus(bias, self.torque);
        Eliminated { axis, force_ratio, torque_ratio, bias }
    }

    /// The same about a point `arm` back: `v_here = v_there + φ × arm`.
    #[inline(always)]
    fn shifted(&self, arm: Vector<V>) -> Self {
        // G = H − M r̂: row i of M r̂ is M_i × r.
        let [mxx, mxy, mxz, myy, myz, mzz] = self.mass.0;
        let [h0, h1, h2] = self.coupling.rows();
        let g0 = cross_from(Vector([mxx, mxy, mxz]), arm, h0);
        let g1 = cross_from(Vector([mxy, myy, myz]), arm, h1);
        let g2 = cross_from(Vector([mxz, myz, mzz]), arm, h2);
        // I' = I + r̂ G − Hᵀ r̂, and row i of Hᵀ r̂ is (column i of H) × r.
        let [rx, ry, rz] = arm.0;
        let [k0, k1, k2] = self.coupling.columns();
        let [ixx, ixy, ixz, iyy, iyz, izz] = self.inertia.0;
        let (g0, g1, g2) = (g0.0, g1.0, g2.0);
        // (r̂ G)_0 = ry g2 − rz g1, (r̂ G)_1 = rz g0 − rx g2, (r̂ G)_2 = rx g1 − ry g0.
        let difference = |a: V, p: V, b: V, q: V, start: V| b.neg_mul_add(q, a.mul_add(p, start));
        // (k × r)_0 = ky rz − kz ry, and so on; subtracted.
        let ([a0, b0, c0], [a1, b1, c1], [a2, b2, _]) = (k0.0, k1.0, k2.0);
        let inertia = Symmetric([
            difference(c0, ry, b0, rz, difference(ry, g2[0], rz, g1[0], ixx)),
            difference(a0, rz, c0, rx, difference(ry, g2[1], rz, g1[1], ixy)),
            difference(b0, rx, a0, ry, difference(ry, g2[2], rz, g1[2], ixz)),
            difference(a1, rz, c1, rx, difference(rz, g0[1], rx, g2[1], iyy)),
            difference(b1, rx, a1, ry, difference(rz, g0[2], rx, g2[2], iyz)),
            difference(b2, rx, a2, ry, difference(rx, g1[2], ry, g0[2], izz)),
        ]);
        Articulated {
            mass: self.mass,
            coupling: Matrix([g0, g1, g2]),
            inertia,
            force: self.force,
            torque: arm.cross_plus(self.force, self.torque),
        }
    }
}

/// `start − a × b`.
#[inline(always)]
fn cross_from<V: Lanes>(a: Vector<V>, b: Vector<V>, start: Vector<V>) -> Vector<V> {
    let ([ax, ay, az], [bx, by, bz]) = (a.0, b.0);
    Vector([
        az.mul_add(by, ay.neg_mul_add(bz, start.0[0])),
        ax.mul_add(bz, az.neg_mul_add(bx, start.0[1])),
        ay.mul_add(bx, ax.neg_mul_add(by, start.0[2])),
    ])
}
