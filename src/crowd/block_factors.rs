//! LU factors of a matrix of blocks over a graph: one node a tree, one edge for trees that touch each other.
//!
//! ```text
//!     A_ij  (n_i × n_j)     for i = j and for the edges {i, j}, and the edges that elimination adds
//!     least degree first:   A_ab ← A_ab − A_ai A_ii⁻¹ A_ib       for the neighbours a, b of i that are left
//! ```
//!
//! Pivots are exchanged within blocks alone. A single block is factored as a whole.

/// The order of elimination and the places of the blocks.
#[derive(Clone, Default)]
pub struct Pattern {
    /// Sizes of the blocks, and where their unknowns begin.
    pub sizes: Vec<usize>,
    pub offsets: Vec<usize>,
    order: Vec<usize>,
    /// The nodes after each that it is joined with.
    later: Vec<Vec<usize>>,
    /// The first entries of the blocks of pairs of nodes, for pairs that are joined.
    places: Vec<usize>,
    total: usize,
}

impl Pattern {
    /// For blocks of these sizes, joined by edges.
    pub fn new(sizes: Vec<usize>, edges: &[(usize, usize)]) -> Self {
        let count = sizes.len();
        let mut offsets = Vec::with_capacity(count);
        let mut unknowns = 0;
        for &size in &sizes {
            offsets.push(unknowns);
            unknowns += size;
        }
        let words = count.div_ceil(64);
        let mut joined = vec![0_u64; count * words];
        for &(one, other) in edges.iter().filter(|(one, other)| one != other) {
            joined[one * words + other / 64] |= 1 << (other % 64);
            joined[other * words + one / 64] |= 1 << (one % 64);
        }
        let degree = |joined: &[u64], node: usize| -> u32 {
            joined[node * words..(node + 1) * words].iter().map(|word| word.count_ones()).sum()
        };
        let mut degrees: Vec<u32> = (0..count).map(|node| degree(&joined, node)).collect();
        let mut left: Vec<usize> = (0..count).collect();
        let (mut order, mut later) = (Vec::with_capacity(count), vec![Vec::new(); count]);
        while let Some(place) = (0..left.len()).min_by_key(|&place| (degrees[left[place]], left[place])) {
            let node = left.swap_remove(place);
            order.push(node);
            let row: Vec<u64> = joined[node * words..(node + 1) * words].to_vec();
            let others: Vec<usize> = (0..count).filter(|other| row[other / 64] >> (other % 64) & 1 == 1).collect();
            for &other in &others {
                for (word, more) in joined[other * words..(other + 1) * words].iter_mut().zip(&row) {
                    *word |= more;
                }
                joined[other * words + other / 64] &= !(1 << (other % 64));
                joined[other * words + node / 64] &= !(1 << (node % 64));
                degrees[other] = degree(&joined, other);
            }
            later[node] = others;
        }
        let (mut places, mut total) = (vec![usize::MAX; count * count], 0);
        for node in 0..count {
            places[node * count + node] = total;
            total += sizes[node] * sizes[node];
            for &other in &later[node] {
                places[node * count + other] = total;
                total += sizes[node] * sizes[other];
                places[other * count + node] = total;
                total += sizes[node] * sizes[other];
            }
        }
        Pattern { sizes, offsets, order, later, places, total }
    }

    fn place(&self, row: usize, column: usize) -> usize {
        self.places[row * self.sizes.len() + column]
    }
}

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
        for &node in &pattern.order {
            let (size, own) = (pattern.sizes[node], pattern.place(node, node));
            let inverse = self.inverse_places[node]..self.inverse_places[node] + size * size;
            invert(&self.data[own..own + size * size], size, &mut self.inverses[inverse.clone()], &mut self.room);
            let later = &pattern.later[node];
            for &row in later {
                let (height, left) = (pattern.sizes[row], pattern.place(row, node));
                self.scaled.clear();
                self.scaled.resize(height * size, 0.0);
                let block = &self.data[left..left + height * size];
                subtract_product(&mut self.scaled, block, &self.inverses[inverse.clone()], size, size);
                self.scaled.iter_mut().for_each(|entry| *entry = -*entry);
                self.data[left..left + height * size].copy_from_slice(&self.scaled);
                for &column in later {
                    let width = pattern.sizes[column];
                    let (upper, target) = (pattern.place(node, column), pattern.place(row, column));
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
        let multiply = |matrix: &[f64], from: &[f64], row: usize| -> f64 {
            let entries = &matrix[row * from.len()..(row + 1) * from.len()];
            entries.iter().zip(from).map(|(entry, x)| entry * x).sum()
        };
        let mut own = [0.0; MOST];
        let mut large = Vec::new();
        for &node in &pattern.order {
            let (size, offset) = (pattern.sizes[node], pattern.offsets[node]);
            for &row in &pattern.later[node] {
                let factors = &self.data[pattern.place(row, node)..];
                for entry in 0..pattern.sizes[row] {
                    let sum = multiply(factors, &b[offset..offset + size], entry);
                    b[pattern.offsets[row] + entry] -= sum;
                }
            }
        }
        for &node in pattern.order.iter().rev() {
            let (size, offset) = (pattern.sizes[node], pattern.offsets[node]);
            for &column in &pattern.later[node] {
                let factors = &self.data[pattern.place(node, column)..];
                let range = pattern.offsets[column]..pattern.offsets[column] + pattern.sizes[column];
                for entry in 0..size {
                    let sum = multiply(factors, &b[range.clone()], entry);
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
            for (entry, sum) in room.iter_mut().enumerate() {
                *sum = multiply(inverse, &b[offset..offset + size], entry);
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

/// c (m × n) ← c − a (m × k) b (k × n).
fn subtract_product(c: &mut [f64], a: &[f64], b: &[f64], inner: usize, width: usize) {
    if let (6, 6, Ok(c)) = (inner, width, <&mut [f64; 36]>::try_from(&mut *c))
        && let (Some(a), Some(b)) = (a.first_chunk::<36>(), b.first_chunk::<36>())
    {
        for row in 0..6 {
            let mut sums = [0.0; 6];
            for inner in 0..6 {
                let factor = a[6 * row + inner];
                (0..6).for_each(|column| sums[column] += factor * b[6 * inner + column]);
            }
            (0..6).for_each(|column| c[6 * row + column] -= sums[column]);
        }
        return;
    }
    for (own, row) in c.chunks_exact_mut(width).zip(a.chunks_exact(inner)) {
        for (&factor, other) in row.iter().zip(b.chunks_exact(width)) {
            if factor != 0.0 {
                own.iter_mut().zip(other).for_each(|(x, y)| *x -= factor * y);
            }
        }
    }
}

/// The inverse of a matrix, by elimination with exchanges of rows.
fn invert(matrix: &[f64], size: usize, inverse: &mut [f64], room: &mut Vec<f64>) {
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
