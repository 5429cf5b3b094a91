//! Samples, figures of steps and events in the order of the log.
//!
//! The figures of a step belong to its end, and so do its events, which lies after the samples inside the step; they wait for the first
//! sample that is not earlier, so that times never go back in the file. The end of a step with events has figures twice: a nanosecond before it those
//! before its impacts, and at it those after them, so that curves of energies have no slopes at events.

use crate::mechanism::motion::event::Event;
use crate::output::log::encoding::time::nanoseconds;
use crate::output::log::messages::figures::Figures;
use crate::output::log::messages::sensitivities::Derivatives;
use crate::output::log::recording::queue::{Between, Piece};
use crate::simulation::{Counts, Sample, StepEnd};
use std::collections::VecDeque;
use std::sync::Arc;

/// Events are at the end of a step if they differ from it by at most this (s), at later times by this part of the time.
const AT_END: f64 = 1e-9;

/// Puts samples, the figures of steps and events in their order.
pub(crate) struct Order {
    stages: f64,
    waiting: Option<StepEnd>,
    events: VecDeque<Event>,
    /// Ends of steps with events.
    eventful: VecDeque<StepEnd>,
    last_figures: Option<f64>,
    last_counts: Counts,
    last_time: u64,
    /// Derivatives of the run, and how many of their rows are added.
    derivatives: Option<Arc<Derivatives>>,
    derived: usize,
}

impl Order {
    /// The order of a run with this number of stages, and with derivatives.
    pub(crate) fn new(stages: f64, derivatives: Option<Arc<Derivatives>>) -> Self {
        Order {
            stages,
            waiting: None,
            events: VecDeque::new(),
            eventful: VecDeque::new(),
            last_figures: None,
            last_counts: Counts::default(),
            last_time: 0,
            derivatives,
            derived: 0,
        }
    }

    /// The time of the last addition, in nanoseconds.
    pub(crate) fn last_time(&self) -> u64 {
        self.last_time
    }

    /// An event, which comes before the first sample that is not earlier.
    pub(crate) fn event(&mut self, event: &Event) {
        self.events.push_back(*event);
    }

    /// The end of a step, after its events.
    pub(crate) fn step(&mut self, end: &StepEnd) {
        let at_end = |event: &Event| (event.time - end.time).abs() <= AT_END * end.time.abs().max(1.0);
        if self.events.iter().any(at_end) {
            self.eventful.push_back(*end);
        }
    }

    /// Adds a sample, and before it what happened up to there.
    pub(crate) fn add(&mut self, sample: &Sample, piece: &mut Piece) {
        self.add_until(sample.time, piece);
        self.add_derivatives(nanoseconds(sample.time), piece);
        self.last_time = nanoseconds(sample.time);
        piece.push(sample.time, sample.position, sample.velocity);
        if self.last_figures.is_none_or(|last| last < sample.step.time) {
            self.waiting = Some(*sample.step);
            self.add_until(sample.time, piece);
        }
    }

    /// Adds the events up to `time`, and the figures of the steps that ended by then, if they wait or have events.
    pub(crate) fn add_until(&mut self, time: f64, piece: &mut Piece) {
        while let Some(end) = self.eventful.front().copied().filter(|end| end.time <= time) {
            self.eventful.pop_front();
            // The same figures.
            self.waiting.take_if(|waiting| waiting.time == end.time);
            self.add_waiting(end.time, piece);
            self.add_both_sides(&end, piece);
        }
        self.add_waiting(time, piece);
        self.add_events(time, piece);
    }

    fn add_waiting(&mut self, time: f64, piece: &mut Piece) {
        if let Some(end) = self.waiting.take_if(|end| end.time <= time)
            && self.last_figures.is_none_or(|last| last < end.time)
        {
            self.add_events(end.time, piece);
            self.add_figures(&end, nanoseconds(end.time), piece);
        }
    }

    /// Adds the figures before and after the events at the end of a step, and the events between them.
    fn add_both_sides(&mut self, end: &StepEnd, piece: &mut Piece) {
        let stamp = nanoseconds(end.time);
        if stamp > self.last_time && stamp > 0 {
            let mut before = *end;
            before.energy.kinetic += end.outcome.exchange.impacts;
            before.exchange.impacts -= end.outcome.exchange.impacts;
            self.add_figures(&before, stamp - 1, piece);
        }
        self.add_events(end.time, piece);
        self.add_figures(end, stamp, piece);
    }

    fn add_events(&mut self, time: f64, piece: &mut Piece) {
        // A rest after infinitely many impacts is told before it happens, so that events after it may be earlier.
        let waits = |event: &Event| event.time > time;
        while let Some(index) = self.events.iter().position(|event| !waits(event)) {
            let Some(event) = self.events.remove(index) else { return };
            self.add_derivatives(nanoseconds(event.time), piece);
            self.last_time = self.last_time.max(nanoseconds(event.time));
            piece.push_event(self.last_time, event);
        }
    }

    /// Adds the derivatives up to a time in nanoseconds.
    fn add_derivatives(&mut self, until: u64, piece: &mut Piece) {
        let Some(derivatives) = &self.derivatives else { return };
        while let Some(stamp) = derivatives.rows.get(self.derived).map(|row| nanoseconds(row.time)) {
            if stamp > until {
                return;
            }
            self.last_time = self.last_time.max(stamp);
            piece.push_between(Between::Derivatives(self.last_time, self.derived));
            self.derived += 1;
        }
    }

    fn add_figures(&mut self, end: &StepEnd, stamp: u64, piece: &mut Piece) {
        self.add_derivatives(stamp, piece);
        let (energy, exchange) = (end.energy, end.exchange);
        // Several steps may have been made since the figures before these.
        let (counts, last) = (end.so_far, self.last_counts);
        let figures = Figures {
            energies: [
                energy.kinetic,
                energy.potential,
                energy.total(),
                exchange.dissipated,
                exchange.work,
                exchange.friction,
                exchange.impacts,
            ],
            violation: [end.violation.position, end.violation.velocity],
            work: [
                end.outcome.step,
                self.stages,
                (counts.steps - last.steps) as f64,
                (counts.iterations - last.iterations) as f64,
                (counts.rejected - last.rejected) as f64,
            ],
        };
        piece.push_between(Between::Figures(stamp, figures));
        self.last_counts = counts;
        self.last_figures = Some(end.time);
        self.last_time = self.last_time.max(stamp);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::forces::total::Exchange;
    use crate::mechanism::motion::energy::{Energy, Violation};
    use crate::mechanism::motion::event::EventKind;
    use crate::mechanism::motion::integrator::StepOutcome;

    /// The content of a piece, in its order: samples, figures and events with their times in milliseconds.
    fn listed(piece: &Piece) -> Vec<String> {
        let mut all = Vec::new();
        let mut between = piece.between.iter().peekable();
        let mut say = |before: usize, all: &mut Vec<String>| {
            while let Some((_, what)) = between.next_if(|(place, _)| *place <= before) {
                all.push(match what {
                    Between::Figures(stamp, _) => format!("figures {}", *stamp as f64 / 1e6),
                    Between::Event(stamp, _) => format!("event {}", stamp / 1_000_000),
                    Between::Contacts(stamp, _) => format!("contacts {}", stamp / 1_000_000),
                    Between::Derivatives(stamp, _) => format!("derivatives {}", stamp / 1_000_000),
                    Between::Line(..) => "line".to_string(),
                });
            }
        };
        for (place, time) in piece.times.iter().enumerate() {
            say(place, &mut all);
            all.push(format!("sample {}", (time * 1e3).round()));
        }
        say(usize::MAX, &mut all);
        all
    }

    #[test]
    fn events_come_in_order_of_time_between_samples_and_the_figures_of_their_step_after_them() {
        let end = |time: f64| StepEnd {
            time,
            energy: Energy::default(),
            exchange: Exchange::default(),
            deviation: 0.0,
            violation: Violation::default(),
            outcome: StepOutcome::default(),
            so_far: Counts::default(),
        };
        let sample = |order: &mut Order, piece: &mut Piece, time: f64, step: &StepEnd| {
            order.add(&Sample { time, position: &[], velocity: &[], step }, piece);
        };
        let event = |time: f64| Event { time, kind: EventKind::Stick, body: 0, pair: None, impulse: None };
        let (mut order, mut piece) = (Order::new(5.0, None), Piece::default());
        sample(&mut order, &mut piece, 0.0, &end(0.0));
        // A step from 0 to 25 ms, at whose end are two events.
        order.event(&event(0.025));
        order.event(&event(0.025));
        order.step(&end(0.025));
        for time in [0.010, 0.020] {
            sample(&mut order, &mut piece, time, &end(0.025));
        }
        // One from there to a sample, with an event there.
        order.event(&event(0.030));
        order.step(&end(0.030));
        sample(&mut order, &mut piece, 0.030, &end(0.030));
        // And one after the last sample.
        order.event(&event(0.035));
        order.add_until(f64::INFINITY, &mut piece);
        let expected = [
            "sample 0",
            "figures 0",
            "sample 10",
            "sample 20",
            "figures 24.999999",
            "event 25",
            "event 25",
            "figures 25",
            "figures 29.999999",
            "event 30",
            "figures 30",
            "sample 30",
            "event 35",
        ];
        assert_eq!(listed(&piece), expected);
        assert_eq!(order.last_time(), 35_000_000);
    }

    #[test]
    fn energies_jump_at_an_impact_by_what_it_took() {
        let impacts = 3.0;
        let exchange = Exchange { impacts: 4.0, ..Exchange::default() };
        let energy = Energy { kinetic: 5.0, potential: 7.0, ..Energy::default() };
        let outcome = StepOutcome {
            step: 0.025,
            exchange: Exchange { impacts, ..Exchange::default() },
            ..StepOutcome::default()
        };
        let so_far = Counts { steps: 2, iterations: 9, rejected: 1 };
        let violation = Violation::default();
        let end = StepEnd { time: 0.025, energy, exchange, deviation: 0.0, violation, outcome, so_far };
        let (mut order, mut piece) = (Order::new(5.0, None), Piece::default());
        order.event(&Event { time: 0.025, kind: EventKind::LimitImpact, body: 0, pair: None, impulse: Some(1.0) });
        order.step(&end);
        order.add_until(0.1, &mut piece);
        let figures: Vec<&Figures> = (piece.between.iter())
            .filter_map(|(_, what)| if let Between::Figures(_, figures) = what { Some(figures) } else { None })
            .collect();
        assert_eq!(figures.len(), 2);
        // Kinetic, potential, total, …, impacts: 3 J more before, of which the first joule was lost earlier.
        assert_eq!(figures[0].energies, [8.0, 7.0, 15.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(figures[1].energies, [5.0, 7.0, 12.0, 0.0, 0.0, 0.0, 4.0]);
        // Steps, iterations and rejected steps count once.
        assert_eq!([&figures[0].work[2..], &figures[1].work[2..]].concat(), [2.0, 9.0, 1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn an_event_that_is_told_before_it_happens_keeps_back_no_event_after_it() {
        let event = |time: f64| Event { time, kind: EventKind::Rest, body: 0, pair: None, impulse: None };
        let (mut order, mut piece) = (Order::new(5.0, None), Piece::default());
        [0.020, 0.010, f64::NAN, 0.012].iter().for_each(|&time| order.event(&event(time)));
        order.add_until(0.015, &mut piece);
        // A time that is not a number is the time of the event before it.
        assert_eq!(listed(&piece), ["event 10", "event 10", "event 12"]);
        order.add_until(f64::INFINITY, &mut piece);
        assert_eq!(listed(&piece).last().map(String::as_str), Some("event 20"));
    }
}
