//! Taking a sample for the log does not allocate on the thread of the simulation: tens of thousands of samples cost what the
//! beginning of a run and the growth of buffers do. The messages are made by the log's own thread, and what that allocates is
//! measured where they are made (`src/run/output/log/recording/encoder.rs`), but for writing the file: the writer of chunks makes its indexes anew
//! for each.

use allocation_counter::measure;
use catena::instant::start::assembly::assemble;
use catena::mechanism::motion::state::State;
use catena::model::{Base, Model, ModelOptions};
use catena::output::log::{Ending, LogOptions, Recorder};
use catena::scene::{PackagePath, read_scene, read_urdf};
use catena::simulation::{RunOptions, run};
use catena::stepping::integrator::Lobatto;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn robots(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(file)
}

fn urdf(file: &str, base: Base) -> (Model, State) {
    let robot = read_urdf(&robots(file), &PackagePath::default()).unwrap();
    let model = Model::new(robot, &ModelOptions { base, ..ModelOptions::default() }).unwrap();
    let state = model.zero_state();
    (model, state)
}

fn scene(file: &str) -> (Model, State) {
    let (model, start) = Model::from_scene(&read_scene(&robots(file), &PackagePath::default()).unwrap()).unwrap();
    let mut state = model.initial_state(&start.positions, &start.velocities, None).unwrap();
    assemble(&model.mechanism, &mut state).unwrap();
    (model, state)
}

#[test]
fn taking_a_sample_does_not_allocate_whatever_the_joints_loops_and_forces() {
    const SAMPLES: u64 = 30_000;
    let all = [
        urdf("arm7.urdf", Base::Fixed),
        urdf("humanoid.urdf", Base::Floating),
        urdf("spherical_chain.urdf", Base::Fixed),
        urdf("planar_slider.urdf", Base::Fixed),
        scene("stewart_platform.toml"),
        scene("damped_oscillator.toml"),
        scene("cassie_like_leg.toml"),
    ];
    for (model, mut state) in all {
        let mechanism = &model.mechanism;
        let mut lobatto = Lobatto::fixed(mechanism, 4, 0.002).unwrap();
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("no_allocation.mcap");
        let mut recorder = Recorder::create(&path, &model, BTreeMap::new(), &LogOptions::default()).unwrap();
        let options = RunOptions { duration: 0.3, rate: Some(SAMPLES as f64 / 0.3), interrupt: None };
        // A run before lets the buffers of the integrator grow to their size.
        run(mechanism, &mut state, &mut lobatto, &options, &mut []).1.unwrap();
        // Counts on this thread alone.
        let measured = measure(|| run(mechanism, &mut state, &mut lobatto, &options, &mut [&mut recorder]).1.unwrap());
        recorder.finish(Ending::default()).unwrap();
        let allocations = measured.count_total;
        // What a run needs at its beginning, and buffers that grow by doubling: some dozen each.
        assert!(allocations < SAMPLES / 100, "{}: {allocations} allocations", mechanism.name);
    }
}
