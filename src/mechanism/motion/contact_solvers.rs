//! How often each entry of the portfolio of contact solvers has solved a problem.
//!
//! Each entry starts where the one before has failed. The counts say which of them earn their place. Problems of reports and logs are not counted.

/// The entries in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactSolver {
    /// Newton's method from the forces of a similar problem.
    Warm,
    /// Newton's method after some sweeps from zero.
    Cold,
    /// Newton's method with a compliance that follows the residual.
    Soft,
    /// An interior point that starts this deep in the cones, by its number among the depths.
    Interior(usize),
    /// Newton's method with compliances that vanish.
    Compliant,
    /// Rounds of convex problems, from zero.
    RoundsFromZero,
    /// Rounds of convex problems, from the best forces so far.
    RoundsFromBest,
    /// None of them.
    Unsolved,
}

/// The depths in the cones at which interior points start, in the order in which they are tried.
pub const DEPTHS: [f64; 11] = [10.0, 100.0, 1.0, 30.0, 3.0, 0.3, 300.0, 0.1, 20.0, 1000.0, 50.0];

/// Entries before the interior points.
const BEFORE: usize = 3;
/// All entries.
const COUNT: usize = BEFORE + DEPTHS.len() + 4;

impl ContactSolver {
    fn index(self) -> usize {
        match self {
            ContactSolver::Warm => 0,
            ContactSolver::Cold => 1,
            ContactSolver::Soft => 2,
            ContactSolver::Interior(depth) => BEFORE + depth.min(DEPTHS.len() - 1),
            ContactSolver::Compliant => BEFORE + DEPTHS.len(),
            ContactSolver::RoundsFromZero => BEFORE + DEPTHS.len() + 1,
            ContactSolver::RoundsFromBest => BEFORE + DEPTHS.len() + 2,
            ContactSolver::Unsolved => BEFORE + DEPTHS.len() + 3,
        }
    }

    /// All entries in their order.
    pub fn all() -> impl Iterator<Item = ContactSolver> {
        let interior = (0..DEPTHS.len()).map(ContactSolver::Interior);
        let last = [
            ContactSolver::Compliant,
            ContactSolver::RoundsFromZero,
            ContactSolver::RoundsFromBest,
            ContactSolver::Unsolved,
        ];
        [ContactSolver::Warm, ContactSolver::Cold, ContactSolver::Soft].into_iter().chain(interior).chain(last)
    }

    /// Its name in files.
    pub fn key(self) -> String {
        match self {
            ContactSolver::Warm => "warm".into(),
            ContactSolver::Cold => "cold".into(),
            ContactSolver::Soft => "soft".into(),
            ContactSolver::Interior(depth) => {
                format!("interior_{}", DEPTHS.get(depth).copied().unwrap_or(f64::NAN))
            }
            ContactSolver::Compliant => "compliant".into(),
            ContactSolver::RoundsFromZero => "rounds_from_zero".into(),
            ContactSolver::RoundsFromBest => "rounds_from_best".into(),
            ContactSolver::Unsolved => "unsolved".into(),
        }
    }
}

/// A count for each entry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ContactSolvers([u32; COUNT]);

impl ContactSolvers {
    /// Counts a problem that an entry has solved.
    pub fn count(&mut self, by: ContactSolver) {
        self.0[by.index()] += 1;
    }

    /// The problems that an entry has solved.
    pub fn of(&self, by: ContactSolver) -> usize {
        self.0[by.index()] as usize
    }

    /// All problems.
    pub fn total(&self) -> usize {
        self.0.iter().map(|&count| count as usize).sum()
    }

    /// Every entry that has solved a problem, with its count, and the problems without an answer.
    pub fn used(&self) -> impl Iterator<Item = (ContactSolver, usize)> + '_ {
        ContactSolver::all().map(|by| (by, self.of(by))).filter(|(_, count)| *count > 0)
    }

    /// Adds the counts of another part of the run.
    pub fn add(&mut self, other: &ContactSolvers) {
        for (count, more) in self.0.iter_mut().zip(other.0) {
            *count += more;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_has_its_own_count_and_its_own_name() {
        let all: Vec<ContactSolver> = ContactSolver::all().collect();
        assert_eq!(all.len(), COUNT);
        for (index, by) in all.iter().enumerate() {
            assert_eq!(by.index(), index, "{by:?}");
            assert!(all[..index].iter().all(|other| other.key() != by.key()), "{by:?}");
        }
    }
}
