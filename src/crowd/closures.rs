//! The closures of a tree: which of its rates are independent, and how the others follow them.
//!
//! ```text
//!     G v = 0,     G_d v_d + G_i v_i = 0,     v_d = B v_i,     B = −G_d⁻¹ G_i,     v = E v_i
//!     q_d ← q_d ⊕ δ,     δ = −G_d⁻¹ g(q)      until |δ| ≤ 1e-14, for loops; relations of mimic joints are linear
//! ```
//!
//! `v` (N) are the rates of the tree, `v_d` as many as G has independent rows, g (k) the gaps of all loop joints and mimic relations (m or rad), and G (k × N) their
//! gradients. The dependent rates are the pivots of an elimination with complete pivoting, in rows of lengths that are divided by their largest entry, so
//! B is well conditioned wherever the tree is not near a singular position. Rows that others imply have no pivot.
//!
//! Source: R. A. Wehage, E. J. Haug, Generalized coordinate partitioning, Journal of Mechanical Design 104 (1982).

use catena_mechanism::description::body_state::{BodyState, WORLD};
use catena_mechanism::description::closure::LoopJoint;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::gaps::{loop_gaps, mimic_gap};
use catena_mechanism::motion::state::State;
use nalgebra::Vector3;

/// Pivots below this are roundings: their rows are implied by others.
const ROUNDING: f64 = 1e-9;
/// A pivot that has become smaller than this part of what it was is one no more.
const FADED: f64 = 1e-3;

/// A loop joint on two bodies by the numbers 0 and 1, and the columns of the freedoms that move each of them alone.
#[derive(Clone)]
struct Loop {
    joint: LoopJoint,
    bodies: [Option<usize>; 2],
    columns: [Vec<usize>; 2],
}

/// The closures of one tree.
#[derive(Clone)]
pub struct Closures {
    loops: Vec<Loop>,
    /// Mimic relations by their numbers in the mechanism, each with its columns and entries.
    mimics: Vec<(usize, Vec<(usize, f64)>)>,
    /// N, the freedoms of the tree.
    count: usize,
    /// G and g: a row has N entries and its gap.
    rows: Vec<f64>,
    /// The row, the column and the first size of each pivot, in the order of the elimination.
    pivots: Vec<(usize, usize, f64)>,
    /// The freedoms that closures connect have the same number.
    parts: Vec<usize>,
    /// E: each freedom in independent ones, by their places among these.
    ways: Vec<Vec<(usize, f64)>>,
    /// Whether the pivots of its last elimination are large enough.
    fit: bool,
}

/// The motion that each freedom of a tree gives to its bodies: a velocity where the root is [m/s] and a rate of turning [rad/s].
pub(crate) struct Motions<'m> {
    pub root: Vector3<f64>,
    pub of_column: &'m dyn Fn(usize) -> (Vector3<f64>, Vector3<f64>),
}

impl Closures {
    /// The loops and mimic relations with these numbers, of the tree with these freedoms; `paths` has the columns of the freedoms on the way to each body.
    pub(crate) fn new(
        mechanism: &Mechanism,
        freedoms: &[usize],
        [loops, mimics]: [&[usize]; 2],
        paths: &[Vec<usize>],
    ) -> Self {
        let column = |freedom: usize| freedoms.iter().position(|own| *own == freedom);
        let of_loop = |&number: &usize| {
            let mut joint = mechanism.loops[number].clone();
            let bodies = [joint.a.body, joint.b.body];
            let path = |end: usize| bodies[end].map_or(&[][..], |body| &paths[body]);
            let shared = path(0).iter().zip(path(1)).take_while(|(one, other)| one == other).count();
            let columns = [0, 1].map(|end| path(end)[shared..].to_vec());
            (joint.a.body, joint.b.body) = (bodies[0].map(|_| 0), bodies[1].map(|_| 1));
            Loop { joint, bodies, columns }
        };
        let of_mimic = |&number: &usize| {
            let terms = mechanism.mimics[number].terms();
            (number, terms.filter_map(|(at, entry)| Some((column(at.freedom)?, entry))).collect())
        };
        let mut own = Closures {
            loops: loops.iter().map(of_loop).collect(),
            mimics: mimics.iter().map(of_mimic).collect(),
            count: freedoms.len(),
            rows: Vec::new(),
            pivots: Vec::new(),
            parts: (0..freedoms.len()).collect(),
            ways: vec![Vec::new(); freedoms.len()],
            fit: true,
        };
        let together = own.loops.iter().map(|own| own.columns.concat());
        let together = together.chain(own.mimics.iter().map(|(_, terms)| terms.iter().map(|term| term.0).collect()));
        for columns in together.collect::<Vec<_>>() {
            let Some(first) = columns.iter().map(|&column| own.parts[column]).min() else { continue };
            let joined: Vec<usize> = columns.iter().map(|&column| own.parts[column]).collect();
            own.parts.iter_mut().filter(|part| joined.contains(part)).for_each(|part| *part = first);
        }
        if !own.change() {
            // The rows of mimic relations are the same everywhere.
            let still = |_: usize| (Vector3::zeros(), Vector3::zeros());
            own.choose(&[], &Motions { root: Vector3::zeros(), of_column: &still });
        }
        own
    }

    /// Whether G changes with the positions.
    pub(crate) fn change(&self) -> bool {
        !self.loops.is_empty()
    }

    /// Whether the rates that were chosen as dependent ones still are.
    pub(crate) fn is_fit(&self) -> bool {
        self.fit
    }

    /// E: each freedom in independent ones, by their places among these.
    pub(crate) fn ways(&self) -> &[Vec<(usize, f64)>] {
        &self.ways
    }

    /// The columns of the independent freedoms.
    pub(crate) fn independent(&self) -> Vec<usize> {
        (0..self.count).filter(|column| self.pivots.iter().all(|(_, pivot, _)| pivot != column)).collect()
    }

    /// Takes G where the bodies are placed, and chooses the dependent rates anew.
    pub(crate) fn choose(&mut self, bodies: &[BodyState], motions: &Motions) {
        self.pivots.clear();
        self.fill(bodies, motions, |_| 0.0);
        self.eliminate(true);
        self.follow();
    }

    /// Takes G where the bodies are placed, with the same dependent rates.
    pub(crate) fn place(&mut self, bodies: &[BodyState], motions: &Motions) {
        self.fill(bodies, motions, |_| 0.0);
        self.eliminate(false);
        self.follow();
    }

    /// δ in a state that places the bodies: the columns of the dependent freedoms with their changes (m or rad).
    pub(crate) fn gaps(
        &mut self,
        mechanism: &Mechanism,
        state: &State,
        bodies: &[BodyState],
        motions: &Motions,
    ) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.fill(bodies, motions, |mimic| mimic_gap(&mechanism.mimics[mimic], state).0);
        self.eliminate(false);
        let Closures { rows, pivots, count, .. } = &*self;
        pivots.iter().map(move |&(row, column, _)| (column, -rows[row * (count + 1) + count]))
    }

    /// Fills G and g; `gap_of` has those of mimic relations.
    fn fill(&mut self, bodies: &[BodyState], motions: &Motions, gap_of: impl Fn(usize) -> f64) {
        let (count, width) = (self.count, self.count + 1);
        self.rows.clear();
        for Loop { joint, bodies: ends, columns } in &self.loops {
            let still = |body: Option<usize>| BodyState {
                velocity: Vector3::zeros(),
                angular_velocity: Vector3::zeros(),
                ..body.map_or(WORLD, |body| bodies[body])
            };
            let mut placed = ends.map(still);
            let (first, gaps) = (self.rows.len(), loop_gaps(joint, &placed));
            self.rows.resize(first + gaps.count * width, 0.0);
            for (row, gap) in gaps.position[..gaps.count].iter().enumerate() {
                self.rows[first + row * width + count] = *gap;
            }
            for (end, columns) in columns.iter().enumerate() {
                let at_rest = placed[end];
                for &column in columns {
                    let (linear, turn) = (motions.of_column)(column);
                    placed[end].velocity = linear + turn.cross(&(at_rest.position - motions.root));
                    placed[end].angular_velocity = turn;
                    for (row, rate) in loop_gaps(joint, &placed).velocity[..gaps.count].iter().enumerate() {
                        self.rows[first + row * width + column] = *rate;
                    }
                }
                placed[end] = at_rest;
            }
            // Rows of lengths, before those of angles.
            let lengths = gaps.count - joint.kind.squares().len();
            let lengths = &mut self.rows[first..first + lengths * width];
            let entries = lengths.chunks_exact(width).flat_map(|row| &row[..count]);
            let largest = entries.fold(0.0_f64, |most, entry| most.max(entry.abs()));
            if largest > 0.0 {
                lengths.iter_mut().for_each(|entry| *entry /= largest);
            }
        }
        for (number, terms) in &self.mimics {
            let first = self.rows.len();
            self.rows.resize(first + width, 0.0);
            terms.iter().for_each(|&(column, entry)| self.rows[first + column] += entry);
            self.rows[first + count] = gap_of(*number);
        }
    }

    /// Makes the columns of the pivots unit vectors; pivots are chosen, or are the same as before.
    fn eliminate(&mut self, chooses: bool) {
        let width = self.count + 1;
        let height = self.rows.len() / width;
        self.fit = true;
        for number in 0..height {
            if chooses {
                let free = |row: &usize| self.pivots.iter().all(|(own, ..)| own != row);
                let entries = (0..height).filter(free).flat_map(|row| (0..self.count).map(move |at| (row, at)));
                let sized = entries.map(|(row, column)| (row, column, self.rows[row * width + column].abs()));
                let best = sized.fold((0, 0, 0.0), |best, own| if own.2 > best.2 { own } else { best });
                if best.2 <= ROUNDING {
                    break;
                }
                self.pivots.push(best);
            }
            let Some(&(row, column, size)) = self.pivots.get(number) else { break };
            let pivot = self.rows[row * width + column];
            if pivot.abs().partial_cmp(&(FADED * size)) != Some(std::cmp::Ordering::Greater) {
                self.fit = false;
                return;
            }
            let (before, rest) = self.rows.split_at_mut(row * width);
            let (own, after) = rest.split_at_mut(width);
            own.iter_mut().for_each(|entry| *entry /= pivot);
            for other in before.chunks_exact_mut(width).chain(after.chunks_exact_mut(width)) {
                let factor = other[column];
                if factor != 0.0 {
                    other.iter_mut().zip(&*own).for_each(|(entry, own)| *entry -= factor * own);
                }
            }
        }
    }

    /// Writes E.
    fn follow(&mut self) {
        let (independent, width) = (self.independent(), self.count + 1);
        for (place, &column) in independent.iter().enumerate() {
            self.ways[column].clear();
            self.ways[column].push((place, 1.0));
        }
        for &(row, column, _) in &self.pivots {
            let own = &mut self.ways[column];
            own.clear();
            for (place, &other) in independent.iter().enumerate() {
                if self.parts[other] == self.parts[column] {
                    own.push((place, -self.rows[row * width + other]));
                }
            }
        }
    }
}
