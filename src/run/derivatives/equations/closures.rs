//! The equations of loop joints and of joints that follow others, as in [`crate::mechanism::description::closure`].

use crate::derivatives::equations::figures::{End, Figures, Frame, LoopFigures};
use crate::derivatives::equations::placed::{Offsets, Placed, end_frame};
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::Vector;
use crate::mechanism::description::closure::LoopKind;

/// g (m): the rows of the loops and of the anchors, then of the followers.
pub fn closures<T: Number>(
    figures: &Figures<T>,
    anchors: &[LoopFigures<T>],
    placed: &[Placed<T>],
    offsets: &Offsets<T>,
) -> Vec<T> {
    let mut rows = Vec::new();
    figures.loops.iter().chain(anchors).for_each(|joint| add_loop(joint, placed, &mut rows));
    for mimic in &figures.mimics {
        let leader = offsets.coordinate(mimic.leader);
        let pair = offsets.coordinate(mimic.follower) - mimic.multiplier * leader - mimic.offset;
        rows.push(mimic.more.iter().fold(pair, |row, &(own, ratio)| row - ratio * offsets.coordinate(own)));
    }
    rows
}

fn add_loop<T: Number>(joint: &LoopFigures<T>, placed: &[Placed<T>], rows: &mut Vec<T>) {
    let [a, b] = [end_frame(&joint.a, placed), end_frame(&joint.b, placed)];
    let gap = b.origin - a.origin;
    let slides = joint.kind.slides();
    if slides.len() == 3 {
        rows.extend(gap.0);
    } else {
        rows.extend(slides.iter().map(|&axis| a.axes.0[axis].dot(gap)));
    }
    rows.extend(joint.kind.squares().iter().map(|&(first, second)| a.axes.0[first].dot(b.axes.0[second])));
    if let LoopKind::Distance(_) = joint.kind {
        let length = joint.length;
        rows.push((gap.dot(gap) - length * length) / length.times(2.0));
    }
}

/// Hands `Gᵀ λ` out: forces and torques on bodies with their points in the world, and efforts along freedoms.
pub fn push<T: Number>(
    figures: &Figures<T>,
    anchors: &[LoopFigures<T>],
    placed: &[Placed<T>],
    multipliers: &[T],
    on_body: &mut dyn FnMut(Option<usize>, Vector<T>, Vector<T>, Vector<T>),
    on_freedom: &mut dyn FnMut(usize, T),
) {
    let mut rows = multipliers.iter().copied();
    let mut next = || rows.next().unwrap_or_else(T::zero);
    for joint in figures.loops.iter().chain(anchors) {
        let [a, b] = [end_frame(&joint.a, placed), end_frame(&joint.b, placed)];
        let slides = joint.kind.slides();
        let (mut force, at_a) = (Vector::zero(), slides.len() == 3);
        for &axis in slides {
            let along = if at_a { unit(axis) } else { a.axes.0[axis] };
            force = force + along.scaled(next());
        }
        let mut torque = Vector::zero();
        for &(first, second) in joint.kind.squares() {
            torque = torque + a.axes.0[first].cross(b.axes.0[second]).scaled(next());
        }
        if let LoopKind::Distance(_) = joint.kind {
            force = force + (b.origin - a.origin).scaled(next() / joint.length);
        }
        // An axis that turns with the first body acts at the second point on both.
        let turns = !slides.is_empty() && !at_a;
        on_body(joint.a.body, if turns { b.origin } else { a.origin }, -force, torque);
        on_body(joint.b.body, b.origin, force, -torque);
    }
    for mimic in &figures.mimics {
        let pull = next();
        on_freedom(mimic.follower.freedom, pull);
        on_freedom(mimic.leader.freedom, -(mimic.multiplier * pull));
        mimic.more.iter().for_each(|&(own, ratio)| on_freedom(own.freedom, -(ratio * pull)));
    }
}

fn unit<T: Number>(axis: usize) -> Vector<T> {
    let mut unit = Vector::zero();
    unit.0[axis] = T::of(1.0);
    unit
}

/// The same loop joint for places with rates.
pub fn with_rates<T: Number>(joint: &LoopFigures<T>) -> LoopFigures<Jet<T>> {
    let jet = |value: T| Jet { value, rate: T::zero(), acceleration: T::zero() };
    let end = |end: &End<T>| {
        let Frame { axes, origin } = end.frame;
        End { body: end.body, frame: Frame { axes: axes.map(|column| column.map(jet)), origin: origin.map(jet) } }
    };
    LoopFigures { kind: joint.kind, a: end(&joint.a), b: end(&joint.b), length: jet(joint.length) }
}
