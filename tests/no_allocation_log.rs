//! A sample of the log allocates nothing on the heap.

use catena::lobatto::Lobatto;
use catena::lobatto::assembly::assemble;
use catena::log::{Ending, Recorder};
use catena::model::{Base, Model, ModelOptions};
use catena::scene::{PackagePath, read_scene, read_urdf};
use catena::simulation::{Observer, ObserverError, RunOptions, Sample, run};
use catena::state::State;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Counts what is allocated between two samples, on all threads.
struct Counter<'r> {
    between: (usize, usize),
    seen: usize,
    region: Region<'r, System>,
    count: usize,
}

impl Observer for Counter<'_> {
    fn sample(&mut self, _: &Sample) -> Result<(), ObserverError> {
        self.seen += 1;
        if self.seen == self.between.0 {
            self.region.reset();
        } else if self.seen == self.between.1 {
            let change = self.region.change();
            self.count = change.allocations + change.reallocations;
        }
        Ok(())
    }
}

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

// One test in this file: another one on another thread would be counted too.
#[test]
fn a_sample_allocates_nothing_whatever_the_joints_loops_and_forces() {
    const SAMPLES: usize = 6000;
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
        let mut recorder = Recorder::create(&path, &model, BTreeMap::new()).unwrap();
        // The first half lets the buffers grow to their size.
        let mut counter =
            Counter { between: (SAMPLES / 2, SAMPLES), seen: 0, region: Region::new(ALLOCATOR), count: 0 };
        let options = RunOptions { duration: 0.6, rate: Some(SAMPLES as f64 / 0.6), interrupt: None };
        let (_, ended) = run(mechanism, &mut state, &mut lobatto, &options, &mut [&mut recorder, &mut counter]);
        ended.unwrap();
        recorder.finish(Ending::default()).unwrap();
        assert!(counter.seen >= SAMPLES);
        // Chunks may still find a buffer too small, and are rare; the half that is looked at has 3000 samples.
        assert!(counter.count < 100, "{}: {} allocations", mechanism.name, counter.count);
    }
}
