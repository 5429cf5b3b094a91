//! Mixing the stages of vectors, `Σ_i columns[i] · self[i]`: every lane meets a column of its own.
//!
//! Out of a register a lane has to be shuffled first. A lane in memory is an operand of the multiplication ([`ReadBack`]), which costs less if a
//! register has many lanes. But then the multiplication waits for the latest store, unless that was long before (`Numbers::STORES_EARLY`). Either way
//! the products are added up in the same order, to the same bits.

use crate::numbers::arithmetic::{Arithmetic, InLines, one_by_one};
use crate::numbers::lanes::{Lanes, Mixing};

/// Lanes are read back from memory.
#[derive(Clone)]
pub struct ReadBack;

impl<V: Lanes> Mixing<V> for ReadBack {
    const EARLY: bool = true;
    type Stored = V::Array;
    #[inline(always)]
    fn mix_all<const N: usize>(values: [V; N], columns: &[V]) -> [V; N] {
        mix_from_memory(&stored(values), columns)
    }
    #[inline(always)]
    fn store_all<const N: usize>(values: [V; N]) -> InLines<V::Array, N> {
        stored(values)
    }
    #[inline(always)]
    fn mix_stored<const N: usize>(values: &InLines<V::Array, N>, columns: &[V]) -> [V; N] {
        mix_stored_before(values, columns)
    }
}

/// Lanes are shuffled in registers.
#[derive(Clone)]
pub struct Shuffled;

impl<V: Lanes> Mixing<V> for Shuffled {
    const EARLY: bool = false;
    type Stored = V;
    #[inline(always)]
    fn mix_all<const N: usize>(values: [V; N], columns: &[V]) -> [V; N] {
        one_by_one(values, columns)
    }
    #[inline(always)]
    fn store_all<const N: usize>(values: [V; N]) -> InLines<V, N> {
        InLines(values)
    }
    #[inline(always)]
    fn mix_stored<const N: usize>(InLines(values): &InLines<V, N>, columns: &[V]) -> [V; N] {
        one_by_one(*values, columns)
    }
}

/// [`Numbers::mix`] of several, the lanes of which are read back from memory, to the same bits; or of one lane of the columns alone.
#[inline(always)]
pub(crate) fn mix_from_memory<V: Arithmetic, A: AsRef<[V::Real]>, const N: usize>(
    arrays: &InLines<A, N>,
    columns: &[V],
) -> [V; N] {
    // The compiler would see that they come from registers, and shuffle.
    mix_stored_before(std::hint::black_box(arrays), columns)
}

/// [`mix_from_memory`] of values stored out of the compiler's sight.
#[inline(always)]
pub(crate) fn mix_stored_before<V: Arithmetic, A: AsRef<[V::Real]>, const N: usize>(
    InLines(arrays): &InLines<A, N>,
    columns: &[V],
) -> [V; N] {
    let mut sums = [V::zero(); N];
    let mut value = 0;
    while value < N {
        sums[value] = columns[0] * V::whole(arrays[value].as_ref()[0]);
        value += 1;
    }
    let mut lane = 1;
    while lane < arrays[0].as_ref().len() {
        let column = columns[lane];
        let mut value = 0;
        while value < N {
            sums[value] = column.mul_add(V::whole(arrays[value].as_ref()[lane]), sums[value]);
            value += 1;
        }
        lane += 1;
    }
    sums
}

/// Several values where lanes are read back from.
#[inline(always)]
pub(crate) fn stored<V: Lanes, const N: usize>(values: [V; N]) -> InLines<V::Array, N> {
    let mut arrays = InLines([V::zero_array(); N]);
    let mut value = 0;
    while value < N {
        arrays.0[value] = values[value].to_array();
        value += 1;
    }
    arrays
}
