//! The residual of the stage equations for one body: what `RᵀR = 1` leaves of (2.5.11), six numbers a row.
//!
//! With the displacements `Δx_i`, `N_i` of the body at stage i (world axes, since the start of the step), its velocity
//! `v`, spin `ω`, second moments `Σ` and arm `com` from the anchor at the start, row k reads
//!
//! ```text
//!     f_k = m ( Σ_i B_ki (Δx_i − h c_i v) − h² g )                    [kg m]      force part, h² included
//!     W_k = Σ_i B_ki (N_i − h c_i ω̂),   C_k = Σ (1 + N_k)ᵀ
//!     e_k = vee(W_k C_k − (W_k C_k)ᵀ)                                 [kg m²]     torque about the centre of mass
//!     Σ_k = (1 + N_k) C_k,   J_k = tr Σ_k − Σ_k                       [kg m²]     inertia at stage k
//! ```
//!
//! The multiplier of `RᵀR = 1` is symmetric and drops out of the skew part that `vee(A − Aᵀ)` takes. Of a spherical inertia,
//! `Σ = σ 1`, a number is left: `e_k = σ vee(W_k (1 + N_k)ᵀ − …)` and `J_k = 2σ 1`. At the end of the
//! step the same terms with the momentum weights `w_i = Σ_k b_k B_ki` make the end momentum `p̄ = p₀ + h Σ b_k F_k`:
//!
//! ```text
//!     P = m ( v + h⁻¹ Σ_i w_i (Δx_i − h c_i v) + h b_s g )                                        [kg m/s]
//!     π = vee(Z − Zᵀ),   Z = (ω̂ + h⁻¹ Σ_i w_i (N_i − h c_i ω̂)) C_s                              [kg m²/s]
//! ```

use super::algebra::{Matrix, Symmetric, Vector};
use super::articulated::Articulated;
use super::numbers::Numbers;
use super::stage::{Coefficients, MAX_LANES, StagePose};
use super::start::{BodyPlan, BodyStart};

/// What is common to all bodies of a sweep.
pub struct Sweep<'s, V> {
    /// Mixing matrix of the sweep, by columns.
    pub columns: &'s [V; MAX_LANES],
    /// What rounding has cut off `columns`.
    pub rest: &'s [V; MAX_LANES],
    /// `h c_i`.
    pub times: V,
    /// What rounding has cut off `times`.
    pub times_rest: V,
    /// One where a row has its stage's geometry.
    pub moved: V,
    /// What gravity adds to the mixed displacement of a centre of mass.
    pub gravity: Vector<V>,
    /// What multiplies applied forces: h², or the impulse's `h b_s`.
    pub forces: V,
}

impl<'s, V: Numbers> Sweep<'s, V> {
    /// What the residual has in common over all bodies of a step, with copies of its columns.
    #[inline(always)]
    pub fn of_residual(
        coefficients: &Coefficients<V>,
        columns: &'s [V; MAX_LANES],
        rest: &'s [V; MAX_LANES],
        step: f64,
        gravity: &[f64; 3],
    ) -> Self {
        let square = V::splat(-step) * V::splat(step);
        Sweep {
            columns,
            rest,
            times: coefficients.nodes * V::splat(step),
            times_rest: coefficients.times_rest(step),
            moved: coefficients.moved,
            gravity: Vector(gravity.map(V::splat)).times(square),
            forces: -square,
        }
    }
}

impl<V: Numbers> Sweep<'_, V> {
    /// How far a displacement is ahead of a steady motion at the `rate` of the start: `displaced − h c_i rate`.
    #[inline(always)]
    pub fn ahead<const REFINED: bool>(&self, rate: V, displaced: V) -> V {
        let ahead = rate.neg_mul_add(self.times, displaced);
        if REFINED { rate.neg_mul_add(self.times_rest, ahead) } else { ahead }
    }

    /// Several values mixed by the matrix of the sweep.
    #[inline(always)]
    pub fn mixed<const REFINED: bool, const N: usize>(&self, values: [V; N]) -> [V; N] {
        let mut mixed = V::mix_all(values, self.columns);
        if REFINED {
            let rest = V::mix_all(values, self.rest);
            let mut index = 0;
            while index < N {
                mixed[index] = mixed[index] + rest[index];
                index += 1;
            }
        }
        mixed
    }
}

impl<V: Numbers> Coefficients<V> {
    /// What the residual has in common over all bodies of a step.
    #[inline(always)]
    pub fn residual_sweep(&self, step: f64, gravity: &[f64; 3]) -> Sweep<'_, V> {
        Sweep::of_residual(self, &self.residual, &self.residual_rest, step, gravity)
    }

    /// The momentum weights over the length of a step, by columns, and what rounding has cut off them.
    #[inline(always)]
    pub fn momentum_columns(&self, step: f64) -> ([V; MAX_LANES], [V; MAX_LANES]) {
        let (mut columns, mut rest) = (self.momentum, self.momentum_rest);
        // Neither 1/h nor the product with it may be rounded.
        let whole = V::splat(step);
        let inverse = whole.reciprocal();
        let inverse_rest = -(inverse.lost(whole, V::splat(1.0)) * inverse);
        for (column, rest) in columns.iter_mut().zip(&mut rest) {
            let rounded = *column * inverse;
            let lost = column.mul_add(inverse_rest, column.lost(inverse, rounded));
            *rest = rest.mul_add(inverse, lost);
            *column = rounded;
        }
        (columns, rest)
    }

    /// What the momenta at the end of a step have in common, with these columns.
    #[inline(always)]
    pub fn momentum_sweep<'s>(
        &self,
        columns: &'s [V; MAX_LANES],
        rest: &'s [V; MAX_LANES],
        step: f64,
        gravity: &[f64; 3],
    ) -> Sweep<'s, V> {
        let factor = V::splat(step) * self.last_weight;
        Sweep {
            columns,
            rest,
            times: self.nodes * V::splat(step),
            times_rest: self.times_rest(step),
            moved: V::splat(1.0),
            gravity: Vector(gravity.map(V::splat)).times(factor),
            forces: factor,
        }
    }

    /// What rounding has cut off `h c_i`.
    #[inline(always)]
    fn times_rest(&self, step: f64) -> V {
        let step = V::splat(step);
        let rounded = self.nodes * step;
        self.nodes_rest.mul_add(step, self.nodes.lost(step, rounded))
    }
}

/// Mass and force part of the residual of a body that never turns.
#[inline(always)]
pub fn sliding_residual<V: Numbers, const MOMENTUM: bool, const REFINED: bool>(
    sweep: &Sweep<V>,
    known: &BodyStart<V::Real>,
    pose: &StagePose<V>,
) -> (Symmetric<V>, Vector<V>) {
    let force = force_residual::<V, MOMENTUM, REFINED>(sweep, known, pose.anchor);
    let (mass, zero) = (V::whole(known.mass), V::zero());
    let force = if MOMENTUM { force.times(V::splat(-1.0)) } else { force };
    (Symmetric([mass, zero, zero, mass, zero, mass]), force)
}

/// `f` of a centre of mass `displaced` since the start.
#[inline(always)]
pub fn force_residual<V: Numbers, const MOMENTUM: bool, const REFINED: bool>(
    sweep: &Sweep<V>,
    known: &BodyStart<V::Real>,
    displaced: Vector<V>,
) -> Vector<V> {
    let start_velocity = Vector::<V>::splat(&known.velocity);
    let ([u, v, w], [x, y, z]) = (start_velocity.0, displaced.0);
    let ahead = [sweep.ahead::<REFINED>(u, x), sweep.ahead::<REFINED>(v, y), sweep.ahead::<REFINED>(w, z)];
    let mut path = Vector(sweep.mixed::<REFINED, 3>(ahead));
    if MOMENTUM {
        path = path.plus(start_velocity);
    }
    path.plus(sweep.gravity).times(V::whole(known.mass))
}

/// The residual of one body about its anchor, and what its inertia is made of; all with the geometry of the rows.
pub struct BodyResidual<V> {
    /// `f`.
    pub force: Vector<V>,
    /// `e` about the anchor.
    pub torque: Vector<V>,
    /// `N`.
    pub turn: Matrix<V>,
    /// From the anchor to the centre of mass (m).
    com: Vector<V>,
    /// `J` about the centre of mass [kg m²].
    own: Symmetric<V>,
    mass: V,
}

/// The residual of one body; where nobody asks for its inertia the compiler leaves that out.
#[inline(always)]
pub fn body_residual<V: Numbers, const MOMENTUM: bool, const REFINED: bool>(
    sweep: &Sweep<V>,
    plan: &BodyPlan,
    known: &BodyStart<V::Real>,
    pose: &StagePose<V>,
) -> BodyResidual<V> {
    let [x, y, z] = pose.u.0;
    let (x2, y2, z2) = (x + x, y + y, z + z);
    // N = sym + hat(antisymmetric part): the products of the quaternion, which is what gets mixed.
    let products = [x2 * x, x2 * y, x2 * z, y2 * y, y2 * z, z2 * z];
    let turned = Vector([pose.w * x2, pose.w * y2, pose.w * z2]);
    let turn = increment_matrix(products, turned.0);

    let com = Vector::splat(&known.com);
    let swing = turn.apply(com);
    let force = force_residual::<V, MOMENTUM, REFINED>(sweep, known, swing.plus(pose.anchor));
    // From here on: the geometry of the rows.
    let turn = if MOMENTUM { turn } else { turn.times(sweep.moved) };
    let com = swing.times_plus(sweep.moved, com);
    let (own, torque) = if plan.point {
        (Symmetric::zero(), Vector::zero())
    } else {
        rotational_residual::<V, MOMENTUM, REFINED>(sweep, plan.spherical, known, products, turned, &turn)
    };
    let torque = com.cross_plus(force, torque);
    let (force, torque) =
        if MOMENTUM { (force.times(V::splat(-1.0)), torque.times(V::splat(-1.0))) } else { (force, torque) };
    BodyResidual { force, torque, turn, com, own, mass: V::whole(known.mass) }
}

impl<V: Numbers> BodyResidual<V> {
    /// With the inertia about the anchor: `J + m (|c|² − c cᵀ)`, and the coupling `−m ĉ`.
    #[inline(always)]
    pub fn with_inertia(&self) -> Articulated<V> {
        let heavy = self.com.times(self.mass);
        let ([cx, cy, cz], [mx, my, mz]) = (self.com.0, heavy.0);
        let [ixx, ixy, ixz, iyy, iyz, izz] = self.own.0;
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
        Articulated {
            mass: Symmetric([self.mass, zero, zero, self.mass, zero, self.mass]),
            coupling: Matrix([[zero, mz, -my], [-mz, zero, mx], [my, -mx, zero]]),
            inertia,
            force: self.force,
            torque: self.torque,
        }
    }
}

/// `J` and `e` about the centre of mass, from the `products` and `turned` of [`increment_matrix`] and N at the rows' stages.
#[inline(always)]
fn rotational_residual<V: Numbers, const MOMENTUM: bool, const REFINED: bool>(
    sweep: &Sweep<V>,
    spherical: bool,
    known: &BodyStart<V::Real>,
    products: [V; 6],
    turned: Vector<V>,
    turn: &Matrix<V>,
) -> (Symmetric<V>, Vector<V>) {
    let start_spin = Vector::<V>::splat(&known.spin);
    let ([u, v, w], [x, y, z]) = (start_spin.0, turned.0);
    let [x, y, z] = [sweep.ahead::<REFINED>(u, x), sweep.ahead::<REFINED>(v, y), sweep.ahead::<REFINED>(w, z)];
    let [xx, xy, xz, yy, yz, zz] = products;
    let [x, y, z, mixed @ ..] = sweep.mixed::<REFINED, 9>([x, y, z, xx, xy, xz, yy, yz, zz]);
    let mut spin = Vector([x, y, z]);
    if MOMENTUM {
        spin = spin.plus(start_spin);
    }
    let mixed = increment_matrix(mixed, spin.0);
    let (turn_rows, mixed_rows) = (turn.rows(), mixed.rows());
    if spherical {
        // Σ = σ 1, so that C = σ (1 + N)ᵀ and Σ_k = Σ: the columns of C are σ times the rows of 1 + N.
        let (sigma, zero) = (V::whole(known.sigma[0]), V::zero());
        let moment = sigma + sigma;
        // Of W (1 + N)ᵀ = W Nᵀ + W.
        let entry = |row: usize, column: usize| mixed_rows[row].dot_plus(turn_rows[column], mixed.0[row][column]);
        let torque = Vector([entry(2, 1) - entry(1, 2), entry(0, 2) - entry(2, 0), entry(1, 0) - entry(0, 1)]);
        return (Symmetric([moment, zero, zero, moment, zero, moment]), torque.times(sigma));
    }
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
    let entry = |row: usize, column: usize| turn_rows[row].dot_plus(c_columns[column], c.0[row][column]);
    // The trace as the sum of the entries themselves: half the trace of J, known exactly, would round differently from
    // the momentum below, and always to the same side.
    let (first, second, third) = (entry(0, 0), entry(1, 1), entry(2, 2));
    let own = Symmetric([second + third, -entry(0, 1), -entry(0, 2), first + third, -entry(1, 2), first + second]);
    let torque = Vector([
        mixed_rows[1].dot_from(c_columns[2], mixed_rows[2].dot(c_columns[1])),
        mixed_rows[2].dot_from(c_columns[0], mixed_rows[0].dot(c_columns[2])),
        mixed_rows[0].dot_from(c_columns[1], mixed_rows[1].dot(c_columns[0])),
    ]);
    (own, torque)
}

/// `N = 2 (w û + u uᵀ − |u|²)` from the products `2 u uᵀ` (xx, xy, xz, yy, yz, zz) and `2 w u`; linear in both.
#[inline(always)]
pub fn increment_matrix<V: Numbers>([xx, xy, xz, yy, yz, zz]: [V; 6], [wx, wy, wz]: [V; 3]) -> Matrix<V> {
    Matrix([[-(yy + zz), xy - wz, xz + wy], [xy + wz, -(xx + zz), yz - wx], [xz - wy, yz + wx, -(xx + yy)]])
}
