//! Joint positions and velocities of the instants, in lanes.

use super::{INSTANTS, Row};
use crate::lobatto::lanes::Lanes;

/// Positions and velocities of the instants, one after the other; lanes above the last instant repeat it.
pub(super) struct Joints<'j> {
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
    pub(super) fn position<V: Lanes>(&self, entry: usize) -> V {
        lanes_of(&self.row(self.positions, self.position_count, entry))
    }

    /// A velocity.
    #[inline(always)]
    pub(super) fn velocity<V: Lanes>(&self, entry: usize) -> V {
        lanes_of(&self.row(self.velocities, self.velocity_count, entry))
    }

    /// Cosine and sine of half an angle.
    #[inline(always)]
    pub(super) fn half_angle<V: Lanes>(&self, entry: usize) -> [V; 2] {
        let angles = self.row(self.positions, self.position_count, entry);
        let (mut cosines, mut sines) = ([0.0; INSTANTS], [0.0; INSTANTS]);
        for lane in 0..INSTANTS {
            (sines[lane], cosines[lane]) = (0.5 * angles[lane]).sin_cos();
        }
        [lanes_of(&cosines), lanes_of(&sines)]
    }

    /// The quaternion of a ball joint, brought to unit length.
    #[inline(always)]
    pub(super) fn ball<V: Lanes>(&self, entry: usize) -> [V; 4] {
        let [w, x, y, z] = [0, 1, 2, 3].map(|offset| self.position::<V>(entry + offset));
        let length = z.mul_add(z, y.mul_add(y, x.mul_add(x, w * w))).square_root().reciprocal();
        [w * length, x * length, y * length, z * length]
    }
}

/// The lanes of a row.
#[inline(always)]
pub(super) fn lanes_of<V: Lanes>(row: &Row) -> V {
    let mut array = V::zero_array();
    array.as_mut().copy_from_slice(row);
    V::from_array(array)
}
