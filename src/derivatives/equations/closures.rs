//! The equations of loop joints and of joints that follow others, as in [`crate::mechanism::description::closure`].

use crate::derivatives::equations::figures::{Figures, LoopFigures};
use crate::derivatives::equations::placed::{Offsets, Placed, end_frame};
use crate::derivatives::numbers::number::Number;
use crate::mechanism::description::closure::LoopKind;

/// g (m): the rows of the loops, then of the followers.
pub fn closures<T: Number>(figures: &Figures<T>, placed: &[Placed<T>], offsets: &Offsets<T>) -> Vec<T> {
    let mut rows = Vec::new();
    figures.loops.iter().for_each(|joint| add_loop(joint, placed, &mut rows));
    for mimic in &figures.mimics {
        let leader = offsets.coordinate(mimic.leader);
        rows.push(offsets.coordinate(mimic.follower) - mimic.multiplier * leader - mimic.offset);
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
