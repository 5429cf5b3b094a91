//! Products of 3-vectors and 3×3 matrices written out, so that the compiler keeps them in registers.

use nalgebra::{Matrix3, Vector3};

/// A symmetric 3×3 matrix by its six different entries.
#[derive(Clone, Copy, Debug, Default)]
pub struct Symmetric {
    pub xx: f64,
    pub xy: f64,
    pub xz: f64,
    pub yy: f64,
    pub yz: f64,
    pub zz: f64,
}

impl Symmetric {
    /// A multiple of the identity.
    #[inline(always)]
    pub fn scalar(value: f64) -> Self {
        Symmetric { xx: value, yy: value, zz: value, ..Symmetric::default() }
    }

    /// The upper triangle of a matrix that is symmetric.
    pub fn from_matrix(m: &Matrix3<f64>) -> Self {
        Symmetric { xx: m[(0, 0)], xy: m[(0, 1)], xz: m[(0, 2)], yy: m[(1, 1)], yz: m[(1, 2)], zz: m[(2, 2)] }
    }

    /// `S v`.
    #[inline(always)]
    pub fn times(&self, v: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }

    /// `S + T`, in place.
    #[inline(always)]
    pub fn add(&mut self, other: &Symmetric) {
        self.xx += other.xx;
        self.xy += other.xy;
        self.xz += other.xz;
        self.yy += other.yy;
        self.yz += other.yz;
        self.zz += other.zz;
    }

    /// `S − a bᵀ` for parallel vectors `a` and `b`, in place.
    #[inline(always)]
    pub fn subtract_dyad(&mut self, a: &Vector3<f64>, b: &Vector3<f64>) {
        self.xx -= a.x * b.x;
        self.xy -= a.x * b.y;
        self.xz -= a.x * b.z;
        self.yy -= a.y * b.y;
        self.yz -= a.y * b.z;
        self.zz -= a.z * b.z;
    }

    /// `R S Rᵀ`.
    #[inline(always)]
    pub fn congruence(&self, r: &Matrix3<f64>) -> Symmetric {
        // The rows of R, then the rows of R S; a row of R S Rᵀ is a row of R S against the rows of R.
        let row = |i: usize| Vector3::new(r[(i, 0)], r[(i, 1)], r[(i, 2)]);
        let (x, y, z) = (row(0), row(1), row(2));
        let (sx, sy, sz) = (self.times(&x), self.times(&y), self.times(&z));
        Symmetric {
            xx: dot(&sx, &x),
            xy: dot(&sx, &y),
            xz: dot(&sx, &z),
            yy: dot(&sy, &y),
            yz: dot(&sy, &z),
            zz: dot(&sz, &z),
        }
    }
}

/// `a · b`.
#[inline(always)]
pub fn dot(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// `a × b`.
#[inline(always)]
pub fn cross(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// `A v`.
#[inline(always)]
pub fn times(a: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        a[(0, 0)] * v.x + a[(0, 1)] * v.y + a[(0, 2)] * v.z,
        a[(1, 0)] * v.x + a[(1, 1)] * v.y + a[(1, 2)] * v.z,
        a[(2, 0)] * v.x + a[(2, 1)] * v.y + a[(2, 2)] * v.z,
    )
}

/// `Aᵀ v`.
#[inline(always)]
pub fn transpose_times(a: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(dot(&column(a, 0), v), dot(&column(a, 1), v), dot(&column(a, 2), v))
}

/// `A B`.
#[inline(always)]
pub fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    from_columns(&times(a, &column(b, 0)), &times(a, &column(b, 1)), &times(a, &column(b, 2)))
}

/// One column of a matrix.
#[inline(always)]
pub fn column(a: &Matrix3<f64>, j: usize) -> Vector3<f64> {
    Vector3::new(a[(0, j)], a[(1, j)], a[(2, j)])
}

/// The matrix with these columns.
#[inline(always)]
pub fn from_columns(x: &Vector3<f64>, y: &Vector3<f64>, z: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z)
}

/// `A Bᵀ`.
#[inline(always)]
pub fn product_transposed(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    let row = |i: usize| Vector3::new(b[(i, 0)], b[(i, 1)], b[(i, 2)]);
    from_columns(&times(a, &row(0)), &times(a, &row(1)), &times(a, &row(2)))
}

/// The matrix of `a ×`.
#[inline(always)]
pub fn cross_matrix(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// `[a]× S`.
#[inline(always)]
pub fn cross_symmetric(a: &Vector3<f64>, s: &Symmetric) -> Matrix3<f64> {
    from_columns(
        &cross(a, &Vector3::new(s.xx, s.xy, s.xz)),
        &cross(a, &Vector3::new(s.xy, s.yy, s.yz)),
        &cross(a, &Vector3::new(s.xz, s.yz, s.zz)),
    )
}

/// `W + Wᵀ` for `W = A [r]×`.
#[inline(always)]
pub fn twice_symmetric_part_of_cross(a: &Matrix3<f64>, r: &Vector3<f64>) -> Symmetric {
    // Row i of A [r]× is (row i of A) × r.
    let row = |i: usize| cross(&Vector3::new(a[(i, 0)], a[(i, 1)], a[(i, 2)]), r);
    let (x, y, z) = (row(0), row(1), row(2));
    Symmetric { xx: 2.0 * x.x, xy: x.y + y.x, xz: x.z + z.x, yy: 2.0 * y.y, yz: y.z + z.y, zz: 2.0 * z.z }
}
