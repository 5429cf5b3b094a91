//! Steps over events that are given up.

use super::{boxes, put};
use crate::events::crowd::contacts::Scene;
use crate::events::crowd::step::Crowd;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::touching::Touching;
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[test]
fn no_step_is_made_once_a_run_is_interrupted_and_its_iterations_end() {
    let mechanism = boxes(3, Vector3::repeat(0.1), 0.5, 0.0);
    let (elements, touching) = (Elements::new(&mechanism), Touching::new(&mechanism));
    let scene = Scene { whole: &mechanism, elements: &elements, touching: &touching };
    let mut response = Response::new(&mechanism);
    let mut state = State::zero(&mechanism);
    (0..3).for_each(|body| put(&mut state, body, [0.01 * body as f64, 0.0, 0.1 + 0.2 * body as f64], [0.0; 3]));
    let mut crowd = Crowd::new(&mechanism).expect("trees");
    let flag = Arc::new(AtomicBool::new(false));
    crowd.heed(flag.clone());
    let mut step = || {
        let mut forces = |at: &State, accelerations: &mut [f64], efforts: &mut [f64]| {
            response.accelerations(at, efforts, accelerations);
        };
        crowd.step(scene, &mut forces, &mut state, 1e-3, false)
    };
    assert!(step().expect("a step").iterations > 0);
    flag.store(true, Ordering::Relaxed);
    assert!(step().is_none());
    flag.store(false, Ordering::Relaxed);
    assert!(step().is_some());
}
