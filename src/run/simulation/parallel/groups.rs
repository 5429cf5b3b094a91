//! The groups of bodies of a run at present, and how their runs are made.

use crate::instant::meeting::Meeting;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::HeldEffort;
use crate::mechanism::motion::integrator::{Integrator, MethodDescription};
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::structure::islands::Island;
use crate::simulation::parallel::island::IslandRun;
use crate::simulation::tolerance::estimated_run::EstimatedRun;
use crate::simulation::tolerance::handed::{Fineness, Handed};
use crate::stepping::integrator::MethodError;

/// What the run of a group begins with.
pub(crate) enum Begins {
    /// At the start of the run, as fine as that; `None` for the first time.
    First(Option<Fineness>),
    /// With what others have handed on.
    GoingOn(Box<Handed>),
}

/// Makes the run of a group from a state on.
pub(crate) type Make<'a> = Box<dyn Fn(&Mechanism, Begins) -> Result<EstimatedRun<'a>, MethodError> + Send + Sync + 'a>;

/// The groups of a run.
pub(crate) struct Groups<'a> {
    pub(super) meeting: Meeting,
    pub(super) make: Make<'a>,
    /// The number of the group of each body: the places of the groups in the list of islands.
    pub(super) groups: Vec<usize>,
    /// The same for bodies that were in one group at any time of the run: their errors are of all of them.
    pub(super) kin: Vec<usize>,
    /// How long they are expected to stay apart (s).
    pub(super) length: f64,
    /// The whole where the present time of the groups began.
    pub(super) at: State,
    /// The efforts that sampled motors hold there: an entry a motor, or empty without such motors.
    pub(super) held: Vec<Option<f64>>,
    /// External efforts on the joints of the whole, and targets that motors were given since the start.
    pub(super) efforts: Vec<f64>,
    pub(super) aimed: Vec<(usize, f64)>,
    /// How steps of groups that are no more were made, and their number.
    pub(super) gone: Option<(MethodDescription, usize)>,
    /// The times of such steps over events, and asleep in these, and over slips (s), for each body of the whole.
    stepped: Vec<[f64; 3]>,
    /// The same for each group where the present time of the groups began.
    began: Vec<[f64; 3]>,
}

impl<'a> Groups<'a> {
    /// The groups of a state; `None` if there is one alone.
    pub fn new(mechanism: &Mechanism, state: &State, make: Make<'a>) -> Option<Self> {
        let meeting = Meeting::new(mechanism);
        let (groups, length) = meeting.groups(&body_states(mechanism, state), None);
        let several = groups.iter().any(|&group| group > 0);
        several.then(|| Groups {
            meeting,
            make,
            kin: groups.clone(),
            groups,
            length,
            at: state.clone(),
            held: Vec::new(),
            efforts: Vec::new(),
            aimed: Vec::new(),
            gone: None,
            stepped: vec![[0.0; 3]; mechanism.bodies.len()],
            began: Vec::new(),
        })
    }

    /// The run begins in a state.
    pub(super) fn begin(&mut self, state: &State) {
        self.at.copy_from(state);
        self.kin.clone_from(&self.groups);
        self.gone = None;
        self.stepped.fill([0.0; 3]);
    }

    /// Takes the times of steps over events and slips out of the method of a group that is no more, for its bodies; the times where the present time of the
    /// groups began if the group, by its number, goes `back` to there.
    pub(super) fn take_times(&mut self, number: usize, island: &Island, method: &mut MethodDescription, back: bool) {
        let made = times_of(method).map(std::mem::take);
        let times = if back { self.began[number] } else { made };
        for body in 0..island.mechanism.bodies.len() {
            let own = &mut self.stepped[island.body_of_whole(body)];
            own.iter_mut().zip(times).for_each(|(sum, time)| *sum += time);
        }
    }

    /// Adds the times of the groups before to the method of a group: the longest of its bodies.
    pub(super) fn add_times(&self, island: &Island, method: &mut MethodDescription) {
        let bodies = 0..island.mechanism.bodies.len();
        let most =
            |kind: usize| bodies.clone().map(|body| self.stepped[island.body_of_whole(body)][kind]).fold(0.0, f64::max);
        for (kind, time) in times_of(method).into_iter().enumerate() {
            *time += most(kind);
        }
    }

    /// The groups are these from now on.
    pub(super) fn set(&mut self, groups: Vec<usize>) {
        for (body, &group) in groups.iter().enumerate() {
            let first = groups.iter().position(|&other| other == group).unwrap_or(body);
            let (one, other) = (self.kin[first], self.kin[body]);
            if one != other {
                self.kin.iter_mut().filter(|kin| **kin == one.max(other)).for_each(|kin| *kin = one.min(other));
            }
        }
        self.groups = groups;
    }

    /// From where all groups are, how far their bodies move is measured, and a group that goes back to there has the times of its steps over events and
    /// slips until there.
    pub(super) fn mark_beginning(&mut self, parts: &mut [IslandRun]) {
        let times = |part: &IslandRun| {
            let method = part.awake.as_ref().map(EstimatedRun::description);
            method.map_or([0.0; 3], |mut method| times_of(&mut method).map(std::mem::take))
        };
        self.began = parts.iter().map(times).collect();
        for IslandRun { island, state, course, .. } in parts.iter_mut().filter(|part| part.state.time == self.at.time) {
            course.iter_mut().for_each(|course| course.measure_way(&island.mechanism, state));
        }
    }

    /// Takes the efforts that sampled motors hold where all groups are.
    pub(super) fn see_held(&mut self, parts: &[IslandRun], mechanism: &Mechanism) {
        let motors = &mechanism.nonsmooth.motors;
        self.held.clear();
        if mechanism.nonsmooth.samples() {
            self.held.resize(motors.len(), None);
            parts.iter().for_each(|part| part.put_held(motors, &mut self.held));
        }
    }

    /// The number of the group of each body.
    pub fn groups(&self) -> &[usize] {
        &self.groups
    }

    /// Makes the run of a group from the start of the run on.
    ///
    /// # Errors
    /// [`MethodError`] for invalid steps.
    pub fn first(&self, mechanism: &Mechanism, fineness: Option<Fineness>) -> Result<EstimatedRun<'a>, MethodError> {
        (self.make)(mechanism, Begins::First(fineness))
    }
}

/// The times of steps over events, and asleep in these, and over slips (s).
fn times_of(method: &mut MethodDescription) -> [&mut f64; 3] {
    [&mut method.first_order_time, &mut method.first_order_asleep, &mut method.over_slips_time]
}

/// A division of bodies into groups by another one: the groups before of the bodies of each group, and whether it is one of those.
pub(super) struct Division {
    pub members: Vec<Vec<usize>>,
    pub stays: Vec<bool>,
}

impl Division {
    /// From the numbers of the groups of bodies before, and after.
    pub fn new(before: &[usize], after: &[usize]) -> Self {
        let count = after.iter().max().map_or(0, |last| last + 1);
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (&group, &one) in after.iter().zip(before) {
            if !members[group].contains(&one) {
                members[group].push(one);
            }
        }
        let size = |of: &[usize], number: usize| of.iter().filter(|one| **one == number).count();
        let stays = members.iter().enumerate().map(|(number, members)| match members[..] {
            [one] => size(before, one) == size(after, number),
            _ => false,
        });
        Division { stays: stays.collect(), members }
    }

    /// The division that puts these pairs of groups together.
    pub fn joining(before: &[usize], pairs: &[[usize; 2]]) -> Vec<usize> {
        let count = before.iter().max().map_or(0, |last| last + 1);
        let mut first: Vec<usize> = (0..count).collect();
        for &[a, b] in pairs {
            let (a, b) = (first[a], first[b]);
            first.iter_mut().filter(|group| **group == a.max(b)).for_each(|group| *group = a.min(b));
        }
        let mut numbers = vec![usize::MAX; count];
        let mut next = 0;
        let after = before.iter().map(|&group| {
            let joined = first[group];
            if numbers[joined] == usize::MAX {
                numbers[joined] = next;
                next += 1;
            }
            numbers[joined]
        });
        after.collect()
    }
}

/// Lets the sampled motors of a group hold what they held at an instant (s).
pub(super) fn hold(island: &mut Island, whole: &Mechanism, held: &[Option<f64>], since: f64) {
    let own: Vec<usize> = island.mechanism.nonsmooth.motors.iter().map(|motor| motor.coordinate.body).collect();
    for (index, body) in own.into_iter().enumerate() {
        let body = island.body_of_whole(body);
        let place = whole.nonsmooth.motors.iter().position(|motor| motor.coordinate.body == body);
        if let Some(effort) = place.and_then(|place| held.get(place).copied().flatten()) {
            island.mechanism.nonsmooth.motors[index].held = Some(HeldEffort { since, effort });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use crate::mechanism::structure::islands::group;
    use nalgebra::Vector3;

    #[test]
    fn times_of_groups_that_follow_each_other_add_up_for_their_bodies() {
        let body = |_| {
            let joint = Joint::new("ball", JointKind::Floating, Pose::identity(), Pose::identity());
            Body { name: "ball".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(0.01), joint }
        };
        let mut balls = Mechanism::new("balls", Vector3::zeros(), (0..3).map(body).collect()).expect("free bodies");
        for body in 0..3 {
            let shape = Shape::Sphere { radius: 0.1 };
            balls.nonsmooth.colliders.push(Collider::still("ball", Some(body), Pose::identity(), shape));
        }
        balls.nonsmooth.pairs.push(ContactPair::without_moments(0, [0, 1], 0.5, 0.0));
        let mut state = State::zero(&balls);
        (0..3).for_each(|body| state.position[7 * body] = body as f64);
        let mut groups = Groups::new(&balls, &state, Box::new(|_, _| unreachable!())).expect("three groups");
        let method = |time: f64| {
            let fixed = MethodDescription::fixed("crowd", 2, 2, 0.1);
            MethodDescription { first_order_time: time, first_order_asleep: 0.5 * time, ..fixed }
        };
        // The first two together for 0.2 s, then the last two for 0.3 s, and now all of them for 0.1 s.
        for (numbers, time) in [([0, 0, 1], 0.2), ([0, 1, 1], 0.3)] {
            let number = usize::from(numbers[1] == 1);
            let mut gone = method(time);
            groups.take_times(number, &group(&balls, &numbers, number), &mut gone, false);
            assert_eq!((gone.first_order_time, gone.first_order_asleep), (0.0, 0.0));
        }
        // One that goes back to where it began takes no time, whatever it has done since.
        groups.began = vec![[0.0; 3]];
        groups.take_times(0, &group(&balls, &[0, 0, 0], 0), &mut method(0.7), true);
        let mut all = method(0.1);
        groups.add_times(&group(&balls, &[0, 0, 0], 0), &mut all);
        assert!((all.first_order_time - 0.6).abs() < 1e-15 && (all.first_order_asleep - 0.3).abs() < 1e-15);
        let mut last = method(0.1);
        groups.add_times(&group(&balls, &[0, 0, 1], 1), &mut last);
        assert!((last.first_order_time - 0.4).abs() < 1e-15, "{}", last.first_order_time);
    }

    #[test]
    fn a_group_stays_if_its_bodies_are_those_of_one_before() {
        let Division { members, stays } = Division::new(&[0, 0, 1, 2, 2], &[0, 1, 2, 1, 1]);
        assert_eq!(members, [vec![0], vec![0, 2], vec![1]]);
        assert_eq!(stays, [false, false, true]);
    }

    #[test]
    fn groups_that_meet_a_third_one_are_joined_and_numbers_follow_the_first_bodies() {
        assert_eq!(Division::joining(&[0, 1, 2, 3, 1], &[[1, 3], [2, 3]]), [0, 1, 1, 1, 1]);
        assert_eq!(Division::joining(&[0, 1, 2, 3], &[[0, 2]]), [0, 1, 0, 2]);
    }
}
