//! Crowds of events: many steps end at events in a short time, and first-order steps are taken instead.
//!
//! ```text
//!     Σ (1 + contacts/4) over the steps of 1e-5 s > 100, or of 1e-3 s > 400, or jams without end:    a crowd
//!     Σ iterations (rates + 3 contacts)² over the steps of 1e-2 s > 1.2e7, or > 2e6 soon after a crowd, four of which have ended at events:  a crowd
//!     it is left by first-order steps for 1e-4 s; after a crowd that ended less than ten times its length ago for twice as long as then, up to 51 ms
//! ```
//!
//! The cost of steps over events takes the place of 1.2e7 if they keep to the tolerance; ten times that cost in four short steps in which contacts
//! slide needs no event. A scene of a few bodies whose error is estimated saves what it does not
//! spend of that, up to 1e-1 s of it, and spends it before it steps over events: it meets a crowd of a moment event by event. Given instants to which few stages are not enough count as
//! events: many stages gain nothing where efforts jump every millisecond. Given steps count 1 each. The first-order steps have 1e-4 s, and a
//! sixteenth of the whole time if it is longer than 1.6 ms, up to 1e-3 s. So the work for a time of the motion is bounded: if crowds follow without
//! end, 52 ms take 400 steps without contacts and 52 steps of first order.
//!
//! A slip that jams stops within less than a microsecond, in which roundings of gaps are forces: ε/h² of 1e-17 m is 0.1 m/s² for 1e-8 s. It is passed
//! in one step of first order of 1e-6 s, and so are a step that fails otherwise and a mode that could not be decided, as of a body that is wedged for a
//! moment. Jams that follow each other soon take 4, 16 and 64 times that length, and then count as crowds.

/// Length of a step of first order (s).
pub(crate) const STEP: f64 = 1e-4;
/// The most first-order steps of that length that leave a crowd. A longer time is left in fewer and longer steps.
const FINE: usize = 16;
/// Such steps are longer by this factor at most.
const LONGER: usize = 10;
/// Work within a time (s) that makes a crowd, in steps without contacts.
const CROWDS: [(usize, f64); 2] = [(100, 1e-5), (400, 1e-3)];
/// Work of iterations within a time (s), with a number of events, that makes a crowd. An iteration costs about 2e-7 s on one core, times the square
/// of its unknowns. The break of ten billiard balls has 1e7, in impacts that are all true. Soon after a crowd less is enough.
const LABOUR: f64 = 1.2e7;
const LABOUR_AGAIN: f64 = 2e6;
pub(crate) const LABOUR_WITHIN: f64 = 1e-2;
const LABOUR_EVENTS: usize = 4;
/// One of them is enough where the work is larger than what is borne by this factor: feet that turn as they stop. As many short steps on
/// contacts that cost as much need no event.
const FAR_DEARER: f64 = 10.0;
/// A step that cannot be made is replaced by one of first order of this length (s).
pub(crate) const JAM_STEP: f64 = 1e-6;
/// A jam that follows within [`SOON`] times the last length takes a step that is longer by this factor, up to the length of steps of crowds.
const JAM_LONGER: f64 = 4.0;
/// A crowd is left by one such step. Another crowd within this many of its steps takes twice as many as before.
const SOON: f64 = 10.0;
/// A crowd of steps over events ends after this many without an event.
const CALM: usize = 10;
/// Crowds of fewer steps of the least length are brief.
const BRIEF: usize = 4;
/// The most steps of the least length that leave a crowd.
const LONGEST: usize = 512;

/// Labour is saved up to what is borne in this many times the time in which it is counted.
const SAVED: f64 = 10.0;

/// Steps that have become many, and the steps of first order that are to be made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crowding {
    /// Work since a time (s), for each kind of crowd.
    counts: [(usize, f64); CROWDS.len()],
    /// Work of iterations.
    labour: Labour,
    /// Labour that is saved, as a part of what is borne within its time, and when that was (s); negative if more was spent.
    saved: Option<(f64, f64)>,
    /// Steps still to be made for the last crowd, steps that it had, both in the least length, and its end (s).
    left: usize,
    made: usize,
    ended: f64,
    /// The length of the last step of first order in the place of one that could not be solved, and when it ended (s).
    jam: (f64, f64),
    /// Whether the next step of first order is that one.
    jams: bool,
    /// Steps over events without an event until now, and how many end the crowd; when it began and ended (s).
    calm: (usize, usize),
    spell: (f64, f64),
}

/// Work of iterations, work of decisions of modes in the same unit, events, slips that are not slow, impacts, instants in all at which a motion breaks, and steps
/// that slips have made short, since a time (s).
#[derive(Clone, Copy, Debug)]
struct Labour {
    work: f64,
    decided: f64,
    events: usize,
    lively: usize,
    impacts: usize,
    breaks: usize,
    slips: usize,
    since: f64,
}

/// How a step ended, for the count of its work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ended {
    /// Where the method ended it.
    Smoothly,
    /// At a given instant, to which few stages were not enough.
    AtInstant,
    /// Soon, with contacts that slide: slips turn or stop.
    AtSlip,
    /// With a decision of this work, as iterations, and an impact or without one.
    AtEvent { decided: f64, impact: bool },
}

impl Crowding {
    /// The counts before the first event.
    pub const CALM: Crowding = Crowding {
        counts: [(0, f64::NEG_INFINITY); CROWDS.len()],
        labour: Labour {
            work: 0.0,
            decided: 0.0,
            events: 0,
            lively: 0,
            impacts: 0,
            breaks: 0,
            slips: 0,
            since: f64::NEG_INFINITY,
        },
        saved: None,
        left: 0,
        made: 0,
        ended: f64::NEG_INFINITY,
        jam: (0.0, f64::NEG_INFINITY),
        jams: false,
        calm: (0, CALM),
        spell: (0.0, f64::NEG_INFINITY),
    };

    /// Counts steps that would only repeat earlier events, and are not made.
    pub fn count_repeated(&mut self, steps: usize) {
        self.counts.iter_mut().for_each(|(count, _)| *count += steps);
    }

    /// Counts the work of a step from a time (s) on: iterations, times the square of their unknowns.
    pub fn labour(&mut self, time: f64, work: f64, ended: Ended) {
        let labour = &mut self.labour;
        if time - labour.since > LABOUR_WITHIN {
            *labour = Labour { since: time, ..Crowding::CALM.labour };
        }
        labour.work += work;
        labour.breaks += usize::from(!matches!(ended, Ended::Smoothly | Ended::AtSlip));
        labour.slips += usize::from(ended == Ended::AtSlip);
        if let Ended::AtEvent { decided, impact } = ended {
            labour.events += 1;
            labour.impacts += usize::from(impact);
            labour.decided += decided;
        }
    }

    /// Saves the part of the labour that is borne that a step of this work from a time (s) on has not spent.
    pub fn save(&mut self, time: f64, work: f64, ended: Ended, borne: Option<f64>) {
        let decided = if let Ended::AtEvent { decided, .. } = ended { decided } else { 0.0 };
        let spent = work + decided;
        self.saved = borne.map(|borne| {
            let (saved, since) = self.saved.unwrap_or((SAVED, time));
            ((saved + (time - since) / LABOUR_WITHIN).min(SAVED) - spent / borne, time)
        });
    }

    /// Whether the labour that is counted now is more than this, among events or slips that break the motion.
    pub fn is_dear(&self, bearable: f64) -> bool {
        let Labour { work, decided, breaks, slips, .. } = self.labour;
        breaks + slips >= LABOUR_EVENTS && work + decided > bearable
    }

    /// Whether the labour that is counted now, up to a time (s), is far more than this, in short steps on contacts without impacts: dozens of contacts that
    /// share their loads take many iterations of many unknowns in each of them.
    pub fn is_far_dearer(&self, time: f64, bearable: f64) -> bool {
        let Labour { work, decided, impacts, breaks, slips, since, .. } = self.labour;
        // The last step may be longer than the time in which it counts.
        let within = ((time - since) / LABOUR_WITHIN).max(1.0);
        impacts == 0 && breaks + slips >= LABOUR_EVENTS && work + decided > FAR_DEARER * bearable * within
    }

    /// Whether the labour that is counted now is among many events.
    pub fn is_eventful(&self) -> bool {
        self.labour.events >= LABOUR_EVENTS
    }

    /// Notes a step that begins at a time (s) with a slip that is not slow.
    pub fn note_lively(&mut self, time: f64) {
        self.labour.lively += usize::from(time - self.labour.since <= LABOUR_WITHIN);
    }

    /// Whether impacts or slips that are not slow are among what is counted now.
    pub fn is_lively(&self) -> bool {
        self.labour.impacts + self.labour.lively > 0
    }

    /// Counts the labour anew.
    pub fn forget_labour(&mut self) {
        self.labour = Crowding::CALM.labour;
    }

    /// Counts a step that begins at a time (s), with its work in steps without contacts; returns whether it is to be one of first order. Steps over events
    /// that are accurate enough take the place of exact ones with a labour beyond `bearable`, their decisions included, if events or given instants break
    /// the motion; one is enough for bodies that are one island, `alone`, if the labour is far beyond, and short steps in which contacts slide need no
    /// event.
    pub fn count(&mut self, time: f64, work: usize, bearable: Option<f64>, alone: bool) -> bool {
        self.jams = false;
        if self.left == 0 {
            let mut crowded = false;
            for ((count, since), (most, within)) in self.counts.iter_mut().zip(CROWDS) {
                if time - *since > within {
                    (*count, *since) = (0, time);
                }
                *count += work;
                crowded |= *count > most;
            }
            let Labour { work, decided, events, breaks, .. } = self.labour;
            // The same work takes that long to be counted again.
            let soon = 2.0 * LABOUR_WITHIN;
            let most = if self.is_soon(time, soon) { LABOUR_AGAIN } else { LABOUR };
            let dearer = bearable.is_some_and(|bearable| {
                let least = if alone && work + decided > FAR_DEARER * bearable { 1 } else { LABOUR_EVENTS };
                let spent = self.saved.is_none_or(|(saved, _)| saved < 0.0);
                (work + decided > bearable && breaks >= least || self.is_far_dearer(time, bearable)) && spent
            });
            let laboured = work > most && events >= LABOUR_EVENTS || dearer;
            if !crowded && !laboured {
                return false;
            }
            self.begin(time, if crowded { 0.0 } else { soon });
        }
        self.make(time);
        true
    }

    /// A step that begins at a time (s) failed at every length, and one of first order is made in its place. A failed attempt is the most expensive
    /// one, so failures that follow soon are left by more and more of these steps, as crowds are.
    fn fail(&mut self, time: f64) {
        self.jams = false;
        self.begin(time, 0.0);
        self.make(time);
    }

    /// A step that begins at a time (s) could not be made. A jam is over in a moment, and is left by a step of first order that is hardly longer.
    pub fn jam(&mut self, time: f64) {
        let length = if self.jams_again(time) { JAM_LONGER * self.jam.0 } else { JAM_STEP };
        if length >= STEP {
            self.fail(time);
        } else {
            (self.jam, self.jams) = ((length, time + length), true);
            // The events that led to it are over, and so is most of the time in which they count.
            self.counts[0] = (0, time);
        }
    }

    /// Whether a slip that jams at a time (s) follows another one soon.
    pub fn jams_again(&self, time: f64) -> bool {
        let (length, ended) = self.jam;
        time - ended <= SOON * length
    }

    /// Whether the next step of first order is one in the place of a step that jams.
    pub fn is_jammed(&self) -> bool {
        self.jams
    }

    /// The length of the steps of first order of the last crowd, or of the one in the place of a step that jams (s).
    pub fn length(&self) -> f64 {
        if self.jams { self.jam.0 } else { self.longer() as f64 * STEP }
    }

    /// Steps over events begin at a time (s); if the last ones ended soon before, more calm steps end them.
    pub fn enter(&mut self, time: f64) {
        let (began, ended) = self.spell;
        let soon = time - ended <= (SOON * (ended - began)).max(2.0 * LABOUR_WITHIN);
        self.calm = (0, if soon { (2 * self.calm.1).min(LONGEST) } else { CALM });
        self.spell.0 = time;
    }

    /// Whether plastic steps are enough: in the place of one that jams, and in a crowd that does not follow others, unless steps over events keep to
    /// the tolerance.
    pub fn is_brief(&self, keeps: bool) -> bool {
        self.jams || self.made < BRIEF && !keeps
    }

    /// Counts a step over events with this number of them; returns whether the crowd is over, if exact steps are no dearer.
    pub fn is_calm(&mut self, events: usize) -> bool {
        self.calm.0 = if events == 0 { self.calm.0 + 1 } else { 0 };
        self.calm.0 >= self.calm.1
    }

    /// Steps over events end at a time (s).
    pub fn leave(&mut self, time: f64) {
        self.spell.1 = time;
        self.left = 0;
        self.jams = false;
        (self.counts, self.labour) = (Crowding::CALM.counts, Crowding::CALM.labour);
    }

    fn longer(&self) -> usize {
        (self.made / FINE).clamp(1, LONGER)
    }

    /// Whether a crowd has ended less than `soon` ago (s), or soon for its length.
    fn is_soon(&self, time: f64, soon: f64) -> bool {
        time - self.ended <= soon.max(SOON * self.made as f64 * STEP)
    }

    /// A crowd begins, the same as the last one if that is soon.
    fn begin(&mut self, time: f64, soon: f64) {
        let again = self.is_soon(time, soon);
        self.made = if again { (2 * self.made).min(LONGEST) } else { 1 };
        self.left = self.made;
    }

    fn make(&mut self, time: f64) {
        self.left = self.left.saturating_sub(self.longer());
        self.ended = time + self.longer() as f64 * STEP;
        (self.counts, self.labour) = (Crowding::CALM.counts, Crowding::CALM.labour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of 0.1 µs, or as many as are given for a failure, and the steps of first order over a second.
    fn made(work: usize, fails: Option<usize>) -> (usize, usize) {
        let (mut crowding, mut time, mut steps, mut coarse) = (Crowding::CALM, 0.0, 0, 0);
        while time < 1.0 {
            let failed = fails.is_some_and(|each| steps % each == each - 1);
            if crowding.count(time, work, None, false) {
                (coarse, time) = (coarse + 1, time + crowding.length());
            } else if failed {
                crowding.fail(time);
                (steps, coarse, time) = (steps + 1, coarse + 1, time + crowding.length());
            } else {
                (steps, time) = (steps + 1, time + 1e-7);
            }
        }
        (steps, coarse)
    }

    #[test]
    fn crowds_without_end_take_a_bounded_number_of_steps_the_fewer_the_more_contacts_are_closed() {
        // Nine crowds that double, and one each 51 ms, of 400 steps without contacts or a ninth of them.
        let (bare, coarse) = made(1, None);
        assert!(bare <= 29 * 401 && coarse <= 2000, "{bare} and {coarse} of first order");
        let (closed, coarse) = made(9, None);
        assert!(closed <= 29 * 45 && coarse <= 2000, "{closed} and {coarse} of first order");
    }

    #[test]
    fn costly_events_are_left_for_longer_and_longer_and_costly_steps_without_events_are_not() {
        // Steps of 50 µs with ten iterations of 100 unknowns, every second of which ends at an event: 120 of them are a crowd, and 20 soon after it.
        let run = |events: bool| {
            let (mut crowding, mut time, mut steps, mut coarse) = (Crowding::CALM, 0.0, 0, 0);
            while time < 1.0 {
                if crowding.count(time, 5, None, false) {
                    (coarse, time) = (coarse + 1, time + crowding.length());
                } else {
                    let at_event = events && steps % 2 == 0;
                    let ended = if at_event { Ended::AtEvent { decided: 0.0, impact: true } } else { Ended::AtInstant };
                    crowding.labour(time, 1e5, ended);
                    (steps, time) = (steps + 1, time + 5e-5);
                }
            }
            (steps, coarse)
        };
        let (steps, coarse) = run(true);
        assert!(steps <= 121 + 29 * 21 && coarse <= 2000, "{steps} and {coarse} of first order");
        assert_eq!(run(false).1, 0);
    }

    #[test]
    fn given_instants_count_as_events_where_steps_over_them_are_accurate_enough() {
        // Ten steps of 1 ms to ticks, each with five iterations of 60 unknowns: 1.8e5.
        let crowded = |ended: Ended, bearable: Option<f64>| {
            let mut crowding = Crowding::CALM;
            (0..20).any(|tick| {
                crowding.labour(1e-3 * f64::from(tick), 1.8e4, ended);
                crowding.count(1e-3 * f64::from(tick), 1, bearable, false)
            })
        };
        assert!(
            crowded(Ended::AtInstant, Some(1e5)) && crowded(Ended::AtEvent { decided: 0.0, impact: true }, Some(1e5))
        );
        assert!(!crowded(Ended::Smoothly, Some(1e5)) && !crowded(Ended::AtInstant, None));
        assert!(
            !crowded(Ended::AtInstant, Some(2.5e5))
                && crowded(Ended::AtEvent { decided: 1e4, impact: true }, Some(2.5e5))
        );
    }

    #[test]
    fn a_crowd_of_a_moment_spends_what_was_saved_and_a_crowd_that_lasts_does_not() {
        // Events 0.1 ms apart, each a tenth of what is borne in 10 ms: 1 ms spends that; ten times as much is saved before, and a tenth while it is spent.
        let last = |borne: Option<f64>| {
            let (mut crowding, event) = (Crowding::CALM, Ended::AtEvent { decided: 0.0, impact: true });
            (0..200).map(|step| 1e-4 * f64::from(step)).find(|&time| {
                crowding.labour(time, 5e3, event);
                crowding.save(time, 5e3, event, borne);
                crowding.count(time, 1, Some(5e4), false)
            })
        };
        assert!((last(None).expect("a crowd") - 1e-3).abs() < 2e-4, "{:?}", last(None));
        assert!((last(Some(5e4)).expect("a crowd") - 1.1e-2).abs() < 5e-4, "{:?}", last(Some(5e4)));
    }

    #[test]
    fn one_event_is_enough_for_one_island_where_its_work_is_ten_times_what_is_borne() {
        // 3.6e4 at an event, and nine steps without one.
        let crowded = |bearable: f64, alone: bool| {
            let mut crowding = Crowding::CALM;
            (0..10).any(|step| {
                let time = 1e-4 * f64::from(step);
                let event = Ended::AtEvent { decided: 0.0, impact: true };
                crowding.labour(time, 3.6e4, if step == 0 { event } else { Ended::Smoothly });
                crowding.count(time, 1, Some(bearable), alone)
            })
        };
        assert!(crowded(3e4, true) && !crowded(4e4, true));
        // An event of one body of many is no reason for all.
        assert!(!crowded(3e4, false));
        // Without an event it is a smooth motion, unless short steps on contacts that slide cost as much in the same time.
        let smooth = |ended: Ended, until: f64| {
            let mut crowding = Crowding::CALM;
            (0..LABOUR_EVENTS).for_each(|_| crowding.labour(0.0, 9e4, ended));
            crowding.count(until, 1, Some(3e4), true)
        };
        assert!(smooth(Ended::AtSlip, 1e-2) && !smooth(Ended::AtSlip, 1.3e-2) && !smooth(Ended::Smoothly, 1e-2));
    }

    #[test]
    fn what_jams_is_left_by_a_microsecond_and_what_jams_again_soon_by_more_up_to_a_crowd() {
        let mut crowding = Crowding::CALM;
        let mut jammed = |time: f64| {
            crowding.jam(time);
            crowding.length()
        };
        let (mut time, mut lengths) = (0.1, Vec::new());
        for _ in 0..6 {
            lengths.push(jammed(time));
            time += lengths[lengths.len() - 1];
        }
        for (length, wanted) in lengths.iter().zip([1e-6, 4e-6, 1.6e-5, 6.4e-5, STEP, STEP]) {
            assert!((length / wanted - 1.0).abs() < 1e-12, "{lengths:?}");
        }
        // Long after the last one, which was 64 µs long.
        assert_eq!(jammed(time + 1e-2), JAM_STEP);
    }

    #[test]
    fn steps_that_fail_again_and_again_are_left_for_longer_and_longer() {
        let (steps, coarse) = made(1, Some(1));
        assert!(steps <= 50 && coarse <= 2000, "{steps} failures and {coarse} of first order");
        // Two that are far from each other are left by one step each.
        let mut crowding = Crowding::CALM;
        for time in [0.1, 0.2] {
            crowding.fail(time);
            assert!(crowding.length() == STEP && !crowding.count(time + STEP, 1, None, false));
        }
    }
}
