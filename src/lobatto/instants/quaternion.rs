//! Unit quaternions in lanes, as a real and an imaginary part.

use crate::numbers::algebra::{Matrix, Vector};
use crate::numbers::lanes::Lanes;
use crate::numbers::rotations::compose;

/// A quaternion: real part, imaginary parts.
pub(crate) type Quaternion<V> = (V, Vector<V>);

/// The product with a constant quaternion (w, x, y, z).
#[inline(always)]
pub(crate) fn constant_product<V: Lanes>(
    &(real, imaginary): &Quaternion<V>,
    &[w, x, y, z]: &[f64; 4],
) -> Quaternion<V> {
    compose(real, imaginary, V::splat(w), Vector::splat(&[x, y, z]))
}

/// A quaternion that is nearly of unit length, made so to rounding.
#[inline(always)]
pub(crate) fn of_unit_length<V: Lanes>((real, imaginary): Quaternion<V>) -> Quaternion<V> {
    let square = imaginary.dot_plus(imaginary, real * real);
    let factor = square.neg_mul_add(V::splat(0.5), V::splat(1.5));
    (real * factor, imaginary.times(factor))
}

/// The rotation of a unit quaternion.
#[inline(always)]
pub(crate) fn frame_of<V: Lanes>(&(w, Vector([x, y, z])): &Quaternion<V>) -> Matrix<V> {
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
