//! The residual of the stage equations for one body: (2.5.11) after the elimination of `RᵀR = 1`, six numbers a row.
//!
//! The displacements of the body at stage i are `Δx_i`, `N_i` (world axes, since the start of the step), its velocity `v`, spin `ω`, second moments
//! `Σ`, and arm `com` from the anchor at the start. Row k reads
//!
//! ```text
//!     f_k = m ( Σ_i B_ki (Δx_i − h c_i v) − h² g )                    [kg m]      force part, h² included
//!     W_k = Σ_i B_ki (N_i − h c_i ω̂),   C_k = Σ (1 + N_k)ᵀ
//!     e_k = vee(W_k C_k − (W_k C_k)ᵀ)                                 [kg m²]     torque about the centre of mass
//!     Σ_k = (1 + N_k) C_k,   J_k = tr Σ_k − Σ_k                       [kg m²]     inertia at stage k
//! ```
//!
//! The multiplier of `RᵀR = 1` is symmetric and drops out of the skew part that `vee(A − Aᵀ)` takes. A spherical inertia, `Σ = σ 1`, leaves one
//! number: `e_k = σ vee(W_k (1 + N_k)ᵀ − …)` and `J_k = 2σ 1`. At the end of the step the same terms with the momentum weights `w_i = Σ_k b_k B_ki`
//! make the end momentum `p̄ = p₀ + h Σ b_k F_k`:
//!
//! ```text
//!     P = m ( v + h⁻¹ Σ_i w_i (Δx_i − h c_i v) + h b_s g )                                        [kg m/s]
//!     π = vee(Z − Zᵀ),   Z = (ω̂ + h⁻¹ Σ_i w_i (N_i − h c_i ω̂)) C_s                              [kg m²/s]
//! ```

use crate::numbers::algebra::{Matrix, Symmetric, Vector};
use crate::numbers::arithmetic::Arithmetic;
use crate::plan::tree::BodyPlan;
use crate::stages::articulated::Articulated;
use crate::stages::row_geometry::{LookAhead, RowGeometry};
use crate::stages::rows::Rows;
use crate::stages::start::BodyStart;

/// `f` of a centre of mass that has been `displaced` since the start.
#[inline(always)]
pub fn force_residual<V: Arithmetic, R: Rows<V>>(
    rows: &R,
    body: usize,
    known: &BodyStart<V::Real>,
    displaced: Vector<V>,
) -> Vector<V> {
    force_along(rows, known, rows.path(body, known, displaced))
}

/// `f` of a centre of mass with this mixed path.
#[inline(always)]
fn force_along<V: Arithmetic, R: Rows<V>>(rows: &R, known: &BodyStart<V::Real>, path: Vector<V>) -> Vector<V> {
    let force = path.plus(rows.gravity()).times(V::whole(known.mass));
    if R::MOMENTA { force.times(V::splat(-1.0)) } else { force }
}

/// The residual of one body about its anchor, and the terms of its inertia; all with the geometry of the rows.
#[derive(Clone)]
pub struct BodyResidual<V> {
    /// `f`.
    pub force: Vector<V>,
    /// `e` about the anchor.
    pub torque: Vector<V>,
    /// `N`.
    pub turn: Matrix<V>,
    /// Vector from the anchor to the centre of mass (m).
    com: Vector<V>,
    /// `J` about the centre of mass [kg m²].
    own: Symmetric<V>,
    mass: V,
}

/// The residual of one body; the compiler leaves out its inertia where that is not used.
#[inline(always)]
pub fn body_residual<V: Arithmetic, R: Rows<V>>(
    rows: &R,
    body: usize,
    plan: &BodyPlan,
    known: &BodyStart<V::Real>,
    early: &LookAhead<V, R::Ahead>,
) -> BodyResidual<V> {
    let now;
    let geometry = if R::EARLY {
        early.at(body)
    } else {
        now = RowGeometry::new(rows, body, known);
        &now
    };
    residual_of(rows, body, plan, known, geometry)
}

/// The same of a body that has moved so.
#[inline(always)]
pub fn residual_of<V: Arithmetic, R: Rows<V>>(
    rows: &R,
    body: usize,
    plan: &BodyPlan,
    known: &BodyStart<V::Real>,
    geometry: &RowGeometry<V, R::Ahead>,
) -> BodyResidual<V> {
    let &RowGeometry { ref ahead, com } = geometry;
    let pose = rows.pose(body);
    let turned = pose.increment();
    let turn = if R::MOMENTA { turned } else { turned.times(rows.moved()) };
    let (force, (own, torque)) = if plan.point {
        let displaced = turned.apply(Vector::splat(&known.com)).plus(pose.anchor);
        (force_residual(rows, body, known, displaced), (Symmetric::zero(), Vector::zero()))
    } else {
        let (path, mixed) = rows.motion(body, known, ahead);
        (force_along(rows, known, path), rotational_residual(plan.spherical, known, &turn, &mixed.matrix()))
    };
    let torque = if R::MOMENTA { torque.times(V::splat(-1.0)) } else { torque };
    let torque = com.cross_plus(force, torque);
    BodyResidual { force, torque, turn, com, own, mass: V::whole(known.mass) }
}

/// `N` of a body with the geometry of the rows, its `J`, and `e` about its centre of mass, where its path is not needed; for momenta `π`.
#[inline(always)]
pub fn spin_residual<V: Arithmetic, R: Rows<V>>(
    rows: &R,
    body: usize,
    plan: &BodyPlan,
    known: &BodyStart<V::Real>,
) -> (Matrix<V>, (Symmetric<V>, Vector<V>)) {
    let turned = rows.pose(body).turned();
    let turn = if R::MOMENTA { turned.matrix() } else { turned.matrix().times(rows.moved()) };
    let mixed = rows.spin(body, known, turned).matrix();
    (turn, rotational_residual(plan.spherical, known, &turn, &mixed))
}

impl<V: Arithmetic> BodyResidual<V> {
    /// Adds the inertia about the anchor: `J + m (|c|² − c cᵀ)`, and the coupling `−m ĉ`.
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

/// `J` and `e` about the centre of mass, from N at the rows' stages and the mixed turn W.
#[inline(always)]
fn rotational_residual<V: Arithmetic>(
    spherical: bool,
    known: &BodyStart<V::Real>,
    turn: &Matrix<V>,
    mixed: &Matrix<V>,
) -> (Symmetric<V>, Vector<V>) {
    let (turn_rows, mixed_rows) = (turn.rows(), mixed.rows());
    if spherical {
        // Σ = σ 1, so that C = σ (1 + N)ᵀ and Σ_k = Σ: the columns of C are σ times the rows of 1 + N.
        let (sigma, zero) = (V::whole(known.sigma[0]), V::zero());
        let moment = sigma + sigma;
        // An entry of W (1 + N)ᵀ = W Nᵀ + W.
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
