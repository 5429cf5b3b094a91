//! Every number with a key path has a derivative, or is refused in one line that says why.

use crate::robot;
use catena::prelude::*;

#[test]
fn every_key_path_has_finite_derivatives_or_is_refused_in_one_line() {
    let scenes = [
        "double_pendulum.urdf",
        "four_bar_2.toml",
        "damped_oscillator.toml",
        "friction_pendulum.toml",
        "bouncing_pendulum.toml",
        "ball_dropped.toml",
        "block_on_incline.toml",
        "heavy_top_slow.toml",
        "slider_crank.toml",
        "spinning_coin.toml",
    ];
    let (mut walked, mut refused) = (0, 0);
    for name in scenes {
        let model = Model::load(robot(name)).expect("a model");
        let params = model.params().expect("numbers");
        let keys: Vec<String> = params.into_iter().filter_map(|(key, value)| value.map(|_| key)).collect();
        let (mut own, mut lost) = (0, 0);
        for key in ["start.q", "start.v"].into_iter().chain(keys.iter().map(String::as_str)) {
            let run = Simulation::new(&model).fixed(5, 0.02).duration(0.06).without_figures();
            match run.sensitivity(&[key]) {
                Ok(found) => {
                    own += 1;
                    let is_finite = |of: &[nalgebra::DMatrix<f64>]| of.iter().flatten().all(|entry| entry.is_finite());
                    assert!(is_finite(&found.dq) && is_finite(&found.dv), "{name}, {key}");
                    assert!(found.valid_within.iter().all(|within| *within >= 0.0), "{name}, {key}");
                }
                Err(error) => {
                    lost += 1;
                    let error = error.to_string();
                    println!("{name}: {error}");
                    assert!(!error.is_empty() && !error.contains('\n'), "{name}, {key}: {error}");
                }
            }
        }
        println!("{name}: {own} walked, {lost} refused");
        // A number at the edge of its range, as e = 0, has no derivative, and those of shapes that follow no number have none.
        assert!(own > 2 * lost, "{name}: {own} walked, {lost} refused");
        (walked, refused) = (walked + own, refused + lost);
    }
    println!("{walked} walked, {refused} refused");
}
