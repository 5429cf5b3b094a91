//! Unit quaternions (w, x, y, z) in lanes.

use crate::lobatto::algebra::Matrix;
use crate::lobatto::lanes::Lanes;

/// The product of a quaternion with a constant one.
#[inline(always)]
pub(super) fn constant_product<V: Lanes>(a: &[V; 4], b: &[f64; 4]) -> [V; 4] {
    product(a, &b.map(V::splat))
}

/// The product of two quaternions.
#[inline(always)]
pub(super) fn product<V: Lanes>(a: &[V; 4], b: &[V; 4]) -> [V; 4] {
    let ([w, x, y, z], [bw, bx, by, bz]) = (*a, *b);
    [
        z.neg_mul_add(bz, y.neg_mul_add(by, x.neg_mul_add(bx, w * bw))),
        z.neg_mul_add(by, y.mul_add(bz, x.mul_add(bw, w * bx))),
        x.neg_mul_add(bz, z.mul_add(bx, y.mul_add(bw, w * by))),
        y.neg_mul_add(bx, x.mul_add(by, z.mul_add(bw, w * bz))),
    ]
}

/// A quaternion that is nearly of unit length, made so to rounding.
#[inline(always)]
pub(super) fn of_unit_length<V: Lanes>(q: &[V; 4]) -> [V; 4] {
    let [w, x, y, z] = *q;
    let square = z.mul_add(z, y.mul_add(y, x.mul_add(x, w * w)));
    let factor = square.neg_mul_add(V::splat(0.5), V::splat(1.5));
    [w * factor, x * factor, y * factor, z * factor]
}

/// The rotation of a unit quaternion.
#[inline(always)]
pub(super) fn frame_of<V: Lanes>(q: &[V; 4]) -> Matrix<V> {
    let [w, x, y, z] = *q;
    let (one, two) = (V::splat(1.0), V::splat(2.0));
    let (dx, dy, dz) = (x * two, y * two, z * two);
    let (wx, wy, wz) = (w * dx, w * dy, w * dz);
    let (xx, xy, xz) = (x * dx, x * dy, x * dz);
    let (yy, yz, zz) = (y * dy, y * dz, z * dz);
    Matrix([
        [one - (yy + zz), xy - wz, xz + wy],
        [xy + wz, one - (xx + zz), yz - wx],
        [xz - wy, yz + wx, one - (xx + yy)],
    ])
}
