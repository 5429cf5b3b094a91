//! LU factors of a matrix of blocks over a graph, whose order and places are in `elimination.rs`.
//!
//! ```text
//!     A_ij  (n_i × n_j)     for i = j and for the edges {i, j}, and the edges that elimination adds
//!     A_ab ← A_ab − A_ai A_ii⁻¹ A_ib       for the neighbours a, b of i that are left
//! ```
//!
//! Pivots are exchanged within blocks alone. A single block is factored as a whole.

use crate::elimination::Pattern;

/// The blocks, and their factors after [`Factors::factor`].
#[derive(Clone, Default)]
pub struct Factors {
    data: Vec<f64>,
    inverses: Vec<f64>,
    inverse_places: Vec<usize>,
    pivots: Vec<usize>,
    room: Vec<f64>,
    scaled: Vec<f64>,
}

impl Factors {
    /// All blocks are zero.
    pub fn clear(&mut self, pattern: &Pattern) {
        self.data.clear();
        self.data.resize(pattern.total, 0.0);
    }

    /// The block of two nodes, row by row.
    pub fn block(&mut self, pattern: &Pattern, row: usize, column: usize) -> &mut [f64] {
        let place = pattern.place(row, column);
        &mut self.data[place..place + pattern.sizes[row] * pattern.sizes[column]]
    }

    /// Factors the blocks in place.
    pub fn factor(&mut self, pattern: &Pattern) {
        if let [size] = pattern.sizes[..] {
            return self.factor_whole(size);
        }
        self.inverse_places.clear();
        let mut total = 0;
        for &size in &pattern.sizes {
            self.inverse_places.push(total);
            total += size * size;
        }
        self.inverses.resize(total, 0.0);
        let mut targets = pattern.targets.iter();
        for &node in &pattern.order {
            let (size, own) = (pattern.sizes[node], pattern.diagonal[node]);
            let inverse = self.inverse_places[node]..self.inverse_places[node] + size * size;
            invert(&self.data[own..own + size * size], size, &mut self.inverses[inverse.clone()], &mut self.room);
            let later = &pattern.later[node];
            for row in later {
                let (height, left) = (pattern.sizes[row.node], row.below);
                self.scaled.clear();
                self.scaled.resize(height * size, 0.0);
                let block = &mut self.data[left..left + height * size];
                subtract_product(&mut self.scaled, block, &self.inverses[inverse.clone()], size, size);
                block.iter_mut().zip(&mut self.scaled).for_each(|(entry, scaled)| {
                    *scaled = -*scaled;
                    *entry = *scaled;
                });
                for (column, &target) in later.iter().zip(&mut targets) {
                    let width = pattern.sizes[column.node];
                    let upper = column.right;
                    let (low, high) = (upper.min(target), upper.max(target));
                    let (before, after) = self.data.split_at_mut(high);
                    let (upper, target) = if upper < target {
                        (&before[low..low + size * width], &mut after[..height * width])
                    } else {
                        (&after[..size * width], &mut before[low..low + height * width])
                    };
                    subtract_product(target, &self.scaled, upper, size, width);
                }
            }
        }
    }

    /// b ← A⁻¹ b.
    pub fn solve(&self, pattern: &Pattern, b: &mut [f64]) {
        if let [size] = pattern.sizes[..] {
            return self.solve_whole(size, b);
        }
        let mut own = [0.0; MOST];
        let mut large = Vec::new();
        for &node in &pattern.order {
            let (size, offset) = (pattern.sizes[node], pattern.offsets[node]);
            for row in &pattern.later[node] {
                let height = pattern.sizes[row.node];
                let factors = &self.data[row.below..row.below + height * size];
                let from = pattern.offsets[row.node];
                for (entry, factors) in factors.chunks_exact(size.max(1)).enumerate() {
                    let sum = dot(factors, &b[offset..offset + size]);
                    b[from + entry] -= sum;
                }
            }
        }
        for &node in pattern.order.iter().rev() {
            let (size, offset) = (pattern.sizes[node], pattern.offsets[node]);
            for column in &pattern.later[node] {
                let width = pattern.sizes[column.node];
                let factors = &self.data[column.right..column.right + size * width];
                let from = pattern.offsets[column.node];
                for (entry, factors) in factors.chunks_exact(width.max(1)).enumerate() {
                    let sum = dot(factors, &b[from..from + width]);
                    b[offset + entry] -= sum;
                }
            }
            let inverse = &self.inverses[self.inverse_places[node]..];
            let room = if size <= MOST {
                &mut own[..size]
            } else {
                large.resize(size, 0.0);
                &mut large[..size]
            };
            for (sum, row) in room.iter_mut().zip(inverse.chunks_exact(size.max(1))) {
                *sum = dot(row, &b[offset..offset + size]);
            }
            b[offset..offset + size].copy_from_slice(room);
        }
    }

    fn factor_whole(&mut self, size: usize) {
        let data = &mut self.data;
        self.pivots.clear();
        for column in 0..size {
            let largest = |best: usize, row: usize| {
                if data[row * size + column].abs() > data[best * size + column].abs() { row } else { best }
            };
            let pivot = (column + 1..size).fold(column, largest);
            self.pivots.push(pivot);
            if pivot != column {
                (0..size).for_each(|entry| data.swap(column * size + entry, pivot * size + entry));
            }
            let (top, rest) = data.split_at_mut((column + 1) * size);
            let own = &top[column * size..];
            let inverse = 1.0 / own[column];
            for row in rest.chunks_exact_mut(size) {
                let factor = row[column] * inverse;
                row[column] = factor;
                if factor != 0.0 {
                    row[column + 1..].iter_mut().zip(&own[column + 1..]).for_each(|(x, y)| *x -= factor * y);
                }
            }
        }
    }

    fn solve_whole(&self, size: usize, b: &mut [f64]) {
        let data = &self.data;
        (0..size).for_each(|row| b.swap(row, self.pivots[row]));
        for row in 0..size {
            let own = &data[row * size..row * size + row];
            b[row] = own.iter().zip(&b[..row]).fold(b[row], |sum, (factor, x)| sum - factor * x);
        }
        for row in (0..size).rev() {
            let own = &data[row * size..(row + 1) * size];
            let sum = own[row + 1..].iter().zip(&b[row + 1..]).fold(b[row], |sum, (factor, x)| sum - factor * x);
            b[row] = sum / own[row];
        }
    }
}

/// Blocks up to this size need no room of their own.
const MOST: usize = 64;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    if let (Ok(a), Ok(b)) = (<&[f64; 6]>::try_from(a), <&[f64; 6]>::try_from(b)) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
    }
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// c (m × n) ← c − a (m × k) b (k × n).
fn subtract_product(c: &mut [f64], a: &[f64], b: &[f64], inner: usize, width: usize) {
    if let (6, 6, Ok(c)) = (inner, width, <&mut [f64; 36]>::try_from(&mut *c))
        && let (Some(a), Some(b)) = (a.first_chunk::<36>(), b.first_chunk::<36>())
    {
        let (rows, of_a) = (c.as_chunks_mut::<6>().0, a.as_chunks::<6>().0);
        return rows.iter_mut().zip(of_a).for_each(|(row, a)| subtract_row(row, a, b));
    }
    for (own, row) in c.chunks_exact_mut(width).zip(a.chunks_exact(inner)) {
        for (&factor, other) in row.iter().zip(b.chunks_exact(width)) {
            if factor != 0.0 {
                own.iter_mut().zip(other).for_each(|(x, y)| *x -= factor * y);
            }
        }
    }
}

/// c (6) ← c − a (6) b (6 × 6). Apart from its caller, which would mix several rows in one vector register and take twice as long.
#[inline(never)]
fn subtract_row(c: &mut [f64; 6], a: &[f64; 6], b: &[f64; 36]) {
    let mut sums = [0.0; 6];
    for (inner, factor) in a.iter().enumerate() {
        (0..6).for_each(|column| sums[column] += factor * b[6 * inner + column]);
    }
    (0..6).for_each(|column| c[column] -= sums[column]);
}

/// The inverse of a matrix, by elimination with exchanges of rows.
fn invert(matrix: &[f64], size: usize, inverse: &mut [f64], room: &mut Vec<f64>) {
    if let (Ok(matrix), Ok(inverse)) = (<&[f64; 36]>::try_from(matrix), <&mut [f64; 36]>::try_from(&mut *inverse)) {
        return invert_six(matrix, inverse);
    }
    let width = 2 * size;
    room.clear();
    room.resize(size * width, 0.0);
    for row in 0..size {
        room[row * width..row * width + size].copy_from_slice(&matrix[row * size..(row + 1) * size]);
        room[row * width + size + row] = 1.0;
    }
    for column in 0..size {
        let largest = |best: usize, row: usize| {
            if room[row * width + column].abs() > room[best * width + column].abs() { row } else { best }
        };
        let pivot = (column + 1..size).fold(column, largest);
        if pivot != column {
            (0..width).for_each(|entry| room.swap(column * width + entry, pivot * width + entry));
        }
        let factor = 1.0 / room[column * width + column];
        room[column * width + column..(column + 1) * width].iter_mut().for_each(|entry| *entry *= factor);
        let (head, rest) = room.split_at_mut(column * width);
        let (own, tail) = rest.split_at_mut(width);
        for row in head.chunks_exact_mut(width).chain(tail.chunks_exact_mut(width)) {
            let factor = row[column];
            if factor != 0.0 {
                row[column..].iter_mut().zip(&own[column..]).for_each(|(x, y)| *x -= factor * y);
            }
        }
    }
    for row in 0..size {
        inverse[row * size..(row + 1) * size].copy_from_slice(&room[row * width + size..(row + 1) * width]);
    }
}

/// The same of a free body: in place, column by column.
fn invert_six(matrix: &[f64; 36], inverse: &mut [f64; 36]) {
    let mut rows = [[0.0; 6]; 6];
    for (row, entries) in rows.iter_mut().zip(matrix.chunks_exact(6)) {
        row.copy_from_slice(entries);
    }
    let mut swaps = [0; 6];
    for column in 0..6 {
        let mut pivot = column;
        for row in column + 1..6 {
            if rows[row][column].abs() > rows[pivot][column].abs() {
                pivot = row;
            }
        }
        swaps[column] = pivot;
        rows.swap(column, pivot);
        let factor = 1.0 / rows[column][column];
        rows[column][column] = 1.0;
        rows[column].iter_mut().for_each(|entry| *entry *= factor);
        let own = rows[column];
        for row in (0..6).filter(|&row| row != column) {
            let factor = rows[row][column];
            rows[row][column] = 0.0;
            (0..6).for_each(|entry| rows[row][entry] -= factor * own[entry]);
        }
    }
    for column in (0..6).rev().filter(|&column| swaps[column] != column) {
        rows.iter_mut().for_each(|row| row.swap(column, swaps[column]));
    }
    for (entries, row) in inverse.chunks_exact_mut(6).zip(&rows) {
        entries.copy_from_slice(row);
    }
}
