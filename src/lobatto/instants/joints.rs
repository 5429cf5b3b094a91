//! Joint positions and velocities of the instants, in lanes.

use crate::instants::quaternion::Quaternion;
use crate::instants::snapshot::Row;
use crate::numbers::algebra::Vector;
use crate::numbers::lanes::Lanes;
use crate::numbers::series::half_angle;
use std::f64::consts::FRAC_1_PI;

/// 2π as a sum whose first two terms have 33 bits (Cody and Waite; the parts of π/2 in fdlibm's `e_rem_pio2.c`, times four).
const TURN: [f64; 3] =
    [4.0 * 1.570_796_326_734_125_6, 4.0 * 6.077_100_506_303_966e-11, 4.0 * 2.022_266_248_795_950_6e-21];

/// Positions and velocities of the instants, one after the other; lanes above the last instant repeat it.
pub(crate) struct Joints<'j> {
    pub positions: &'j [f64],
    pub velocities: &'j [f64],
    pub count: usize,
    pub position_count: usize,
    pub velocity_count: usize,
}

impl Joints<'_> {
    fn row(&self, numbers: &[f64], stride: usize, entry: usize) -> Row {
        std::array::from_fn(|lane| numbers[lane.min(self.count - 1) * stride + entry])
    }

    /// A position.
    #[inline(always)]
    pub(crate) fn position<V: Lanes>(&self, entry: usize) -> V {
        lanes_of(&self.row(self.positions, self.position_count, entry))
    }

    /// A velocity.
    #[inline(always)]
    pub(crate) fn velocity<V: Lanes>(&self, entry: usize) -> V {
        lanes_of(&self.row(self.velocities, self.velocity_count, entry))
    }

    /// Cosine and sine of half an angle, both with the same sign or the opposite one.
    #[inline(always)]
    pub(crate) fn half_angle<V: Lanes>(&self, entry: usize) -> [V; 2] {
        let mut angles = self.row(self.positions, self.position_count, entry);
        for angle in &mut angles {
            // Whole turns are taken off, exactly up to a million of them; the turns change the sign only.
            let turns = (*angle * (0.5 * FRAC_1_PI)).round_ties_even();
            *angle = ((*angle - turns * TURN[0]) - turns * TURN[1]) - turns * TURN[2];
        }
        let angle: V = lanes_of(&angles);
        let (cosine, sine_ratio) = half_angle(angle * angle);
        [cosine, angle * sine_ratio]
    }

    /// The quaternion of a ball joint, brought to unit length.
    #[inline(always)]
    pub(crate) fn ball<V: Lanes>(&self, entry: usize) -> Quaternion<V> {
        let real: V = self.position(entry);
        let imaginary = Vector([self.position(entry + 1), self.position(entry + 2), self.position(entry + 3)]);
        let factor = imaginary.dot_plus(imaginary, real * real).square_root().reciprocal();
        (real * factor, imaginary.times(factor))
    }
}

/// The lanes of a row.
#[inline(always)]
pub(crate) fn lanes_of<V: Lanes>(row: &Row) -> V {
    let mut array = V::zero_array();
    array.as_mut().copy_from_slice(row);
    V::from_array(array)
}
