//! The margin by which all contacts of a mode can stay closed, where their forces are not unique.
//!
//! ```text
//!     largest m with    D r = −b,    r_c − m e_N in K_c for every contact,    lower + m ≤ r ≤ upper − m for every interval
//! ```
//!
//! All blocks hold their rows (u = 0; of a contact that slides u_N = 0, and r_T = −μ r_N t). If m ≥ 0, admissible forces exist and all contacts keep
//! their states; if m < 0, one must open or slip. m is continuous in the load, in N (N m of joints). It is at most the largest force of the solution
//! of least norm, which bounds it where contacts can pinch a body as hard as they like.
//!
//! A sliding contact whose pressure is looked at alone may have less than its law says by a part of the rounding of that pressure. Its force is zero
//! if no load presses on it, whatever the others are, and m would be roundings on either side of zero.
//!
//! Contacts that touch at rest without a force have the margin 0. The answer of the programme is off by its tolerance there, and would release them
//! again and again. If forces without any in such contacts hold all rows, m is at least 0.
//!
//! Forces are r₀ + N y, with the solution of least norm r₀ and the null space N of the rows in scaled units; the programme in (y, m) is solved by
//! clarabel. If N is empty, m is read off r₀. A problem that falls apart has the least margin of its parts.

use crate::instant::cone::apart::parts_apart;
use crate::instant::cone::least_norm::least_norm;
use crate::instant::cone::problem::{Law, Problem};
use crate::instant::cone::scaled::Scaled;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use nalgebra::{DMatrix, DVector};

/// A solution of least norm with this part of its largest force to spare is margin enough.
const CLEAR: f64 = 0.02;
/// Rows are held to this part of their accelerations.
const HELD: f64 = 1e-8;
/// Rounding as a part of the terms that cancel: under a heavy body a light one is held by forces that are large against its weight.
const ROUNDING: f64 = 1e-13;

/// A margin that lacks less than this part of the largest force may be an error of the programme, and a contact with less than the other part of it may
/// be without a force.
const IN_DOUBT: f64 = 1e-8;
const BARE: f64 = 1e-5;

/// m; −∞ if no forces hold all rows, or the problem is malformed.
#[cfg(test)]
pub(crate) fn margin(problem: &Problem) -> f64 {
    margin_beyond(problem, f64::INFINITY, |_| Known { part: 0.0, own: 0.0 }, |_| false)
}

/// How far the forces of a block are known (N).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Known {
    /// Each part of the problem has as much more, the most of its blocks.
    pub part: f64,
    /// The block itself may have as much less than its law says.
    pub own: f64,
}

/// The same where its size does not matter: the margin of the forces of least norm if that is clear. A part of the problem whose blocks are `unloaded`
/// has the margin 0.
pub(crate) fn margin_or_clear(
    problem: &Problem,
    known: impl Fn(usize) -> Known,
    unloaded: impl Fn(usize) -> bool,
) -> f64 {
    margin_beyond(problem, CLEAR, known, unloaded)
}

/// m, or the margin of the forces of least norm if that is more than this part of the largest of them.
fn margin_beyond(
    problem: &Problem,
    clear: f64,
    known: impl Fn(usize) -> Known,
    unloaded: impl Fn(usize) -> bool,
) -> f64 {
    if problem.check().is_err() {
        return f64::NEG_INFINITY;
    }
    let of_part = |problem: &Problem, blocks: &[usize]| {
        let loaded = !blocks.iter().copied().all(&unloaded);
        let known: Vec<Known> = blocks.iter().copied().map(&known).collect();
        let (margin, largest) = if loaded { margin_of_part(problem, clear, &known) } else { (0.0, 0.0) };
        let more = known.iter().map(|known| known.part).fold(0.0, f64::max);
        (margin + more, largest + more)
    };
    let margins: Vec<(f64, f64)> = match parts_apart(problem) {
        Some(parts) => parts.iter().map(|part| of_part(&part.problem(), &part.blocks)).collect(),
        None => vec![of_part(problem, &(0..problem.laws.len()).collect::<Vec<_>>())],
    };
    let largest = margins.iter().fold(0.0_f64, |most, (_, largest)| most.max(*largest));
    margins.iter().fold(largest, |least, (margin, _)| least.min(*margin))
}

/// The same of a part, and its largest force; infinite without conditions.
fn margin_of_part(problem: &Problem, clear: f64, known: &[Known]) -> (f64, f64) {
    let scaled = Scaled::new(problem);
    let directions = force_directions(&scaled);
    let Some(found) = Holding::of(&scaled, &directions) else { return (f64::NEG_INFINITY, 0.0) };
    // Forces in their own units, as r₀ + N y.
    let particular = DVector::from_vec(scaled.unscale((&directions * &found.least).as_slice()));
    let mut null = &directions * &found.null;
    for mut column in null.column_iter_mut() {
        let unscaled = scaled.unscale(column.as_slice());
        column.copy_from_slice(&unscaled);
    }
    let largest = particular.amax();
    let conditions = Conditions::new(&scaled, problem.laws, known);
    if conditions.cones.is_empty() {
        return (f64::INFINITY, largest);
    }
    let blocks = || problem.laws.iter().zip(&scaled.starts).zip(known);
    let each = |forces: &DVector<f64>| -> Vec<f64> {
        blocks().map(|((law, &start), known)| own_margin(law, &forces.as_slice()[start..], known)).collect()
    };
    let own = each(&particular);
    let least = own.iter().fold(largest, |least, own| least.min(*own));
    // Far from the limit of the contacts only its sign is needed. No force at all is admissible, and the most.
    if null.ncols() == 0 || least > clear * largest || largest == 0.0 {
        return (least, largest);
    }
    let more = known.iter().map(|known| known.part).fold(0.0, f64::max);
    let bears = |forces: &DVector<f64>, part: f64| -> Vec<bool> {
        blocks().map(|((law, &start), _)| forces.rows(start, law.rows()).amax() > part).collect()
    };
    let holds = |own: &[f64], bears: &[bool], enough: f64| {
        bears.contains(&false) && own.iter().zip(bears).all(|(own, bears)| !bears || *own > enough)
    };
    if holds(&own, &bears(&particular, more), clear * largest) {
        return (0.0, largest);
    }
    let Some((margin, along)) = conditions.largest_margin(&particular, &null, largest) else {
        return (f64::NEG_INFINITY, largest);
    };
    let margin = margin.max(least);
    if margin + more >= 0.0 || margin < -IN_DOUBT * largest {
        return (margin, largest);
    }
    let bare = bears(&(&particular + &null * &along), BARE * largest);
    let without = found.without(&scaled, &directions, &along, &bare);
    let without = without.map(|forces| DVector::from_vec(scaled.unscale(forces.as_slice())));
    let is_held = without.is_some_and(|forces| holds(&each(&forces), &bare, 0.0));
    (if is_held { 0.0 } else { margin }, largest)
}

/// The margin of one block with known forces.
fn own_margin(law: &Law, forces: &[f64], known: &Known) -> f64 {
    let margin = match *law {
        Law::Interval { lower, upper } => (forces[0] - lower).min(upper - forces[0]),
        Law::Contact { friction } if friction > 0.0 => forces[0] - forces[1].hypot(forces[2]) / friction,
        Law::Contact { .. } | Law::Sliding { .. } => forces[0],
    };
    margin + known.own
}

/// The rows of the unknown forces of blocks: one column for each force, in scaled units.
fn force_directions(scaled: &Scaled) -> DMatrix<f64> {
    let count = scaled.free.len();
    let mut columns: Vec<DVector<f64>> = Vec::with_capacity(count);
    for (start, law) in scaled.blocks() {
        let mut push = |entries: &[(usize, f64)]| {
            let mut column = DVector::zeros(count);
            entries.iter().for_each(|&(row, value)| column[start + row] = value);
            columns.push(column);
        };
        match law {
            Law::Interval { .. } => push(&[(0, 1.0)]),
            Law::Contact { friction } if friction > 0.0 => (0..3).for_each(|row| push(&[(row, 1.0)])),
            Law::Contact { .. } => push(&[(0, 1.0)]),
            Law::Sliding { friction, direction: [x, y] } => push(&[(0, 1.0), (1, -friction * x), (2, -friction * y)]),
        }
    }
    if columns.is_empty() { DMatrix::zeros(count, 0) } else { DMatrix::from_columns(&columns) }
}

/// Unknown forces that hold all rows: `matrix · x = right`.
struct Holding {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    /// The solution of least norm, and a basis of the null space.
    least: DVector<f64>,
    null: DMatrix<f64>,
}

impl Holding {
    /// `None` if no forces hold the rows.
    fn of(scaled: &Scaled, directions: &DMatrix<f64>) -> Option<Self> {
        // The rows that are held: each row whose unit force is an unknown.
        let held: Vec<usize> = scaled.blocks().flat_map(|(start, law)| start..start + unknowns(&law)).collect();
        let responses = &scaled.mobility * directions;
        let matrix = DMatrix::from_fn(held.len(), held.len(), |row, column| responses[(held[row], column)]);
        let right = DVector::from_fn(held.len(), |row, _| -scaled.free[held[row]]);
        let (least, null) = least_norm(&matrix, &right)?;
        is_solved(&matrix, &least, &right, HELD).then_some(Holding { matrix, right, least, null })
    }

    /// Scaled forces near `least + null · along`, without any in the blocks that do not bear; `None` unless they hold all rows up to roundings.
    fn without(
        &self,
        scaled: &Scaled,
        directions: &DMatrix<f64>,
        along: &DVector<f64>,
        bears: &[bool],
    ) -> Option<DVector<f64>> {
        let bearing = scaled.blocks().zip(bears).flat_map(|((_, law), bears)| vec![*bears; unknowns(&law)]);
        let mut matrix = self.matrix.clone();
        let mut forces = &self.least + &self.null * along;
        for (column, _) in bearing.enumerate().filter(|(_, bears)| !bears) {
            matrix.column_mut(column).fill(0.0);
            forces[column] = 0.0;
        }
        let (rest, _) = least_norm(&matrix, &(&self.right - &matrix * &forces))?;
        forces += rest;
        is_solved(&matrix, &forces, &self.right, ROUNDING).then(|| directions * forces)
    }
}

/// Whether forces hold all rows, up to this part of the largest right side and roundings of the terms.
fn is_solved(matrix: &DMatrix<f64>, forces: &DVector<f64>, right: &DVector<f64>, part: f64) -> bool {
    let off = (matrix * forces - right).amax();
    let terms = (matrix.abs() * forces.abs()).amax();
    off <= part * right.amax() + ROUNDING * terms
}

/// How many unknown forces a block has.
fn unknowns(law: &Law) -> usize {
    match *law {
        Law::Contact { friction } if friction > 0.0 => 3,
        _ => 1,
    }
}

/// `forces = rows r + offset − margin · m` in cones.
struct Conditions {
    cones: Vec<SupportedConeT<f64>>,
    /// For each condition: row of r, its factor, the offset, and the factor of m.
    lines: Vec<(usize, f64, f64, f64)>,
}

impl Conditions {
    fn new(scaled: &Scaled, laws: &[Law], known: &[Known]) -> Self {
        let (mut cones, mut lines) = (Vec::new(), Vec::new());
        for ((&start, law), &Known { own, .. }) in scaled.starts.iter().zip(laws).zip(known) {
            match *law {
                Law::Interval { lower, upper } => {
                    for (factor, bound) in
                        [(1.0, lower), (-1.0, upper)].into_iter().filter(|(_, bound)| bound.is_finite())
                    {
                        lines.push((start, factor, own - factor * bound, 1.0));
                        cones.push(SupportedConeT::NonnegativeConeT(1));
                    }
                }
                Law::Contact { friction } if friction > 0.0 => {
                    lines.extend([
                        (start, friction, friction * own, friction),
                        (start + 1, 1.0, 0.0, 0.0),
                        (start + 2, 1.0, 0.0, 0.0),
                    ]);
                    cones.push(SupportedConeT::SecondOrderConeT(3));
                }
                Law::Contact { .. } | Law::Sliding { .. } => {
                    lines.push((start, 1.0, own, 1.0));
                    cones.push(SupportedConeT::NonnegativeConeT(1));
                }
            }
        }
        Conditions { cones, lines }
    }

    /// The largest m, at most the largest force, and the y that has it; `None` if clarabel fails.
    fn largest_margin(
        mut self,
        particular: &DVector<f64>,
        null: &DMatrix<f64>,
        largest: f64,
    ) -> Option<(f64, DVector<f64>)> {
        let unknowns = null.ncols() + 1;
        // In units of the largest force; rows of A x + s = limit with s in the cones.
        let unit = if largest > 0.0 { largest } else { 1.0 };
        let mut rows = Vec::with_capacity(self.lines.len() + 1);
        let mut limits = Vec::with_capacity(self.lines.len() + 1);
        for &(row, factor, offset, of_margin) in &self.lines {
            let mut entries: Vec<f64> = null.row(row).iter().map(|entry| -factor * entry).collect();
            entries.push(of_margin);
            rows.push(entries);
            limits.push((factor * particular[row] + offset) / unit);
        }
        let mut bound = vec![0.0; unknowns];
        bound[unknowns - 1] = 1.0;
        rows.push(bound);
        limits.push(largest / unit);
        self.cones.push(SupportedConeT::NonnegativeConeT(1));
        let mut linear = vec![0.0; unknowns];
        linear[unknowns - 1] = -1.0;
        let tight = 1e-12;
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            tol_gap_abs: tight,
            tol_gap_rel: tight,
            tol_feas: tight,
            ..DefaultSettings::default()
        };
        let (quadratic, rows) = (CscMatrix::zeros((unknowns, unknowns)), CscMatrix::from(&rows));
        let mut solver = DefaultSolver::new(&quadratic, &linear, &rows, &limits, &self.cones, settings).ok()?;
        solver.solve();
        let (margin, along) = solver.solution.x.split_last()?;
        let along = DVector::from_column_slice(along) * unit;
        margin.is_finite().then_some((*margin * unit, along))
    }
}
