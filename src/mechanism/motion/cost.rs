//! The cost of steps: iterations of accepted and abandoned attempts, and why attempts were thrown away.
//!
//! ```text
//!     attempts at a step = 1 + Σ_why rejected[why] + located        located: attempts that end the step at an event, which reject nothing
//! ```
//!
//! Costs are added by [`Cost::add`] alone, so that no merge of two outcomes can lose a figure.

/// Why an attempt at a step was thrown away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejected {
    /// The iteration of the stages did not converge.
    NotConverged,
    /// A joint turned further than the stages can represent.
    TurnedTooFar,
    /// The motion in the step is not smooth enough for the tolerance.
    NotSmooth,
    /// The energy changed by more than the tolerance, the loads and the dampers explain.
    EnergyJump,
    /// A watched function is negative from the start on: it may be so on the dense output of a long step alone.
    EventAtStart,
    /// A contact force jumps from one solution of the stages to another.
    ForceJump,
    /// A slip passes near its stop and turns faster than the step can follow.
    SlipTurned,
    /// Closed contacts overlap at the end by more than roundings.
    Overlap,
    /// Distances of a pair are not known closely enough to exclude a contact inside the step.
    Unseen,
    /// Contacts gave or took energy that friction does not explain.
    OffBalance,
}

impl Rejected {
    /// All reasons, in the order of the counts.
    pub const ALL: [Rejected; 10] = [
        Rejected::NotConverged,
        Rejected::TurnedTooFar,
        Rejected::NotSmooth,
        Rejected::EnergyJump,
        Rejected::EventAtStart,
        Rejected::ForceJump,
        Rejected::SlipTurned,
        Rejected::Overlap,
        Rejected::Unseen,
        Rejected::OffBalance,
    ];

    /// Its name in files.
    pub fn key(self) -> &'static str {
        match self {
            Rejected::NotConverged => "not_converged",
            Rejected::TurnedTooFar => "turned_too_far",
            Rejected::NotSmooth => "not_smooth",
            Rejected::EnergyJump => "energy_jump",
            Rejected::EventAtStart => "event_at_start",
            Rejected::ForceJump => "force_jump",
            Rejected::SlipTurned => "slip_turned",
            Rejected::Overlap => "overlap",
            Rejected::Unseen => "unseen",
            Rejected::OffBalance => "off_balance",
        }
    }

    /// Its words for people, after a number.
    pub fn words(self) -> &'static str {
        match self {
            Rejected::NotConverged => "not converged",
            Rejected::TurnedTooFar => "turned too far",
            Rejected::NotSmooth => "not smooth enough",
            Rejected::EnergyJump => "with a jump of the energy",
            Rejected::EventAtStart => "with an event at the start",
            Rejected::ForceJump => "with a jump of a contact force",
            Rejected::SlipTurned => "with a slip that turned",
            Rejected::Overlap => "with an overlap",
            Rejected::Unseen => "with distances that were not certain",
            Rejected::OffBalance => "with energy from contacts",
        }
    }
}

/// Attempts that were thrown away, counted by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rejections([u32; Rejected::ALL.len()]);

impl Rejections {
    /// Counts one attempt.
    pub fn count(&mut self, why: Rejected) {
        self.0[why as usize] += 1;
    }

    /// The attempts with this reason.
    pub fn of(&self, why: Rejected) -> usize {
        self.0[why as usize] as usize
    }

    /// All attempts.
    pub fn total(&self) -> usize {
        self.0.iter().map(|&count| count as usize).sum()
    }

    /// Every reason that occurred, with its count.
    pub fn reasons(&self) -> impl Iterator<Item = (Rejected, usize)> + '_ {
        Rejected::ALL.into_iter().map(|why| (why, self.of(why))).filter(|(_, count)| *count > 0)
    }
}

/// The cost of a step, of a run, or of a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Iterations of the nonlinear solve, or evaluations of the right-hand side.
    pub iterations: usize,
    /// Number of these iterations that kept the factors of an earlier one.
    pub kept: usize,
    /// Attempts that were thrown away, by reason.
    pub rejected: Rejections,
    /// Attempts with another length that end a step at an event.
    pub located: usize,
}

impl Cost {
    /// The cost of this number of iterations.
    pub fn of(iterations: usize) -> Self {
        Cost { iterations, ..Cost::default() }
    }

    /// Counts an attempt that is thrown away.
    pub fn reject(&mut self, why: Rejected) {
        self.rejected.count(why);
    }

    /// Adds the cost of other work.
    pub fn add(&mut self, other: &Cost) {
        self.iterations += other.iterations;
        self.kept += other.kept;
        self.located += other.located;
        for (count, more) in self.rejected.0.iter_mut().zip(other.rejected.0) {
            *count += more;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_of_costs_has_every_figure_of_both() {
        let mut one = Cost { iterations: 3, kept: 1, located: 2, ..Cost::default() };
        one.reject(Rejected::Overlap);
        let mut sum = Cost::of(4);
        for why in Rejected::ALL {
            sum.reject(why);
        }
        sum.add(&one);
        assert_eq!((sum.iterations, sum.kept, sum.located, sum.rejected.total()), (7, 1, 2, 11));
        assert_eq!(sum.rejected.of(Rejected::Overlap), 2);
        assert_eq!(one.rejected.reasons().collect::<Vec<_>>(), [(Rejected::Overlap, 1)]);
    }

    #[test]
    fn every_reason_has_its_own_count_and_its_own_name() {
        for (index, why) in Rejected::ALL.into_iter().enumerate() {
            assert_eq!(why as usize, index, "{why:?}");
            assert!(Rejected::ALL[..index].iter().all(|other| other.key() != why.key()), "{why:?}");
        }
    }
}
