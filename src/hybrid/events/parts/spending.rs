//! What exact steps spend on events, and when that is too much: the rule that chooses between exact steps and steps over events.
//!
//! ```text
//!     w = c i n² + c_g g + c_d (3 n_c)³ + c_0            cost of a step that ends at an event, an instant or a slip (s)
//!     R(t) = Σ_k w_k e^{−(t − t_k)/τ} / τ                cost of a second of the motion, in the mean over τ (s/s)
//!     steps over events are made from R > p on
//! ```
//!
//! i: iterations, also of attempts that failed; n: their unknowns; g: looks at gaps of hulls; n_c: closed contacts, whose mode is decided;
//! c, c_g, c_d, c_0: measured costs (s). All are counts, so that the choice does not depend on a clock.
//!
//! p is the price of exact steps: twice the cost of steps over events where these keep to the tolerance, and [`DEAREST`] where they do not. Events take at most
//! p (T + τ) of CPU time in a time T of the motion, and one more event for each τ, however they follow. τ is how long exact steps may cost more ([`Patience`]).

/// p where no other steps keep to the tolerance (s/s).
pub(crate) const DEAREST: f64 = 20.0;
/// c_0 (s).
const STEP: f64 = 3e-5;
/// τ (s), by patience.
const SPANS: [f64; 4] = [1e-2, 3e-2, 1e-1, 1e-1];

/// How long costs are remembered: for how long exact steps may cost more than their price.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Patience {
    /// 10 ms: steps over events are as good.
    Short,
    /// 30 ms: they are, but the error is estimated, and they end what the estimate holds for.
    Medium,
    /// 0.1 s: they do not keep to the tolerance.
    Long,
    /// 0.1 s of events alone, without slips: the order of a few impacts decides what follows.
    Order,
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ended {
    /// Where the method ended it.
    Smoothly,
    /// At a given instant, to which few stages were not enough.
    AtInstant,
    /// Soon, with contacts that slide: slips turn or stop.
    AtSlip,
    /// At an event.
    AtEvent,
}

/// The cost of exact steps that events end, in the mean over the time before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spending {
    /// τ R for each patience (s), and when that was (s).
    spent: [f64; 4],
    at: f64,
    /// The cost of the last step (s).
    last: f64,
    /// When the last impact and the last fast slip were (s).
    impact: f64,
    fast: f64,
}

impl Spending {
    /// Before the first event.
    pub const NONE: Spending =
        Spending { spent: [0.0; 4], at: 0.0, last: 0.0, impact: f64::NEG_INFINITY, fast: f64::NEG_INFINITY };

    /// Counts a step from a time (s) on that has ended so, with w without c_0 (s). Smooth steps have no cost, and c_0 for a long time.
    pub fn spend(&mut self, time: f64, cost: f64, ended: Ended) {
        self.spent = [0, 1, 2, 3].map(|kind| self.spent_at(time, kind));
        (self.at, self.last) = (time, cost + STEP);
        let (own, smooth, slip) = (self.last, ended == Ended::Smoothly, ended == Ended::AtSlip);
        let short = if smooth { 0.0 } else { own };
        let costs = [short, short, if smooth { STEP } else { own }, if smooth || slip { STEP } else { own }];
        self.spent.iter_mut().zip(costs).for_each(|(spent, cost)| *spent += cost);
    }

    /// Counts steps that would only repeat the last one, and are not made.
    pub fn repeat(&mut self, steps: usize) {
        self.spent.iter_mut().for_each(|spent| *spent += steps as f64 * self.last);
    }

    /// Forgets what was spent.
    pub fn forget(&mut self) {
        self.spent = [0.0; 4];
    }

    /// R at a time (s/s).
    pub fn rate(&self, time: f64, patience: Patience) -> f64 {
        let kind = patience as usize;
        self.spent_at(time, kind) / SPANS[kind]
    }

    /// Notes impacts, and slips that are not slow, in a step from a time (s) on.
    pub fn see(&mut self, time: f64, impact: bool, fast: bool) {
        self.impact = if impact { time } else { self.impact };
        self.fast = if fast { time } else { self.fast };
    }

    /// Whether there was an impact less than 10 ms before a time (s).
    pub fn meets_impacts(&self, time: f64) -> bool {
        time - self.impact <= SPANS[0]
    }

    /// Whether there was a fast slip less than 10 ms before a time (s).
    pub fn slips_fast(&self, time: f64) -> bool {
        time - self.fast <= SPANS[0]
    }

    fn spent_at(&self, time: f64, kind: usize) -> f64 {
        self.spent[kind] * (-(time - self.at).max(0.0) / SPANS[kind]).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cost (s) of a second of events of `cost` (s) each 0.1 µs, where a step over events of 0.1 ms is made from a price (s/s) on.
    fn spent_in_a_second(cost: f64, price: f64, patience: Patience) -> f64 {
        let (mut spending, mut time, mut sum) = (Spending::NONE, 0.0, 0.0);
        while time < 1.0 {
            if spending.rate(time, patience) > price {
                time += 1e-4;
            } else {
                spending.spend(time, cost, Ended::AtEvent);
                (time, sum) = (time + 1e-7, sum + cost + STEP);
            }
        }
        sum
    }

    #[test]
    fn events_without_an_end_cost_their_price_and_what_is_spent_at_once() {
        for (patience, span) in
            [(Patience::Short, 0.01), (Patience::Medium, 0.03), (Patience::Long, 0.1), (Patience::Order, 0.1)]
        {
            for (cost, price) in [(1e-4, 1.0), (5e-3, 20.0)] {
                let spent = spent_in_a_second(cost, price, patience);
                // The event with which the price is reached may exceed it.
                let bound = (price + (cost + STEP) / span) * (1.0 + span);
                assert!(spent <= bound, "{spent} of {bound}");
                // A step over events of 0.1 ms is a hundredth of the shortest time.
                assert!(spent >= 0.9 * price, "{spent} of {price}");
            }
        }
    }

    #[test]
    fn one_event_that_costs_more_than_the_price_of_its_time_is_enough_and_is_forgotten_after_it() {
        let mut spending = Spending::NONE;
        spending.spend(1.0, 0.05, Ended::AtEvent);
        assert!(spending.rate(1.0, Patience::Short) > 5.0 && spending.rate(1.0, Patience::Long) < 0.6);
        // e⁻³ of 5 s/s after three times 10 ms.
        let later = spending.rate(1.03, Patience::Short);
        assert!((later / (0.05003 / 0.01 * (-3.0_f64).exp()) - 1.0).abs() < 1e-9, "{later}");
    }

    #[test]
    fn smooth_steps_cost_nothing_for_a_short_time_and_little_for_a_long_one_and_slips_change_no_order() {
        let of = |ended: Ended| {
            let mut spending = Spending::NONE;
            spending.spend(0.0, 0.05, ended);
            spending.spent
        };
        let (whole, least) = (0.05 + STEP, STEP);
        assert_eq!(of(Ended::Smoothly), [0.0, 0.0, least, least]);
        assert_eq!(of(Ended::AtSlip), [whole, whole, whole, least]);
        assert_eq!(of(Ended::AtInstant), [whole; 4]);
        assert_eq!(of(Ended::AtEvent), [whole; 4]);
    }

    #[test]
    fn steps_that_are_not_made_because_they_would_repeat_the_last_one_cost_as_much_as_that() {
        let mut spending = Spending::NONE;
        spending.spend(0.0, 1e-3, Ended::AtEvent);
        spending.repeat(9);
        assert!((spending.rate(0.0, Patience::Short) - 10.0 * (1e-3 + STEP) / SPANS[0]).abs() < 1e-12);
    }
}
