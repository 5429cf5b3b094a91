//! Surfaces that move over their bodies (`surface_velocity`): belts and tracks against closed forms, with the work of their drives.

use crate::common::scratch;
use crate::scene_files::{link, report};
use catena::mechanism::motion::integrator::Rejected;
use catena::report::Report;
use std::path::PathBuf;

const GRAVITY: f64 = 9.81;
/// Closed forms are met to this (m, rad, J): tolerances of 1e-11 m and their factors of some ten in velocities and energies.
const BOUND: f64 = 1e-10;

fn scene(folder: &str, text: &str) -> PathBuf {
    let file = scratch(folder).join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

fn run(folder: &str, text: &str, duration: f64) -> Report {
    let end = report(&scene(folder, text), &[], &[], Some(duration), 1e-11);
    assert!(end.energy.max_relative_error < 1e-11, "{:?}", end.energy);
    end
}

fn near(what: &str, (is, wanted): (f64, f64)) {
    assert!((is - wanted).abs() < BOUND, "{what}: {is} instead of {wanted}, off by {:.1e}", is - wanted);
}

#[test]
fn a_box_on_a_belt_slides_until_it_moves_with_the_belt_and_then_rides() {
    let (friction, speed, mass) = (0.4, 2.0, 3.0);
    let text = format!(
        "[[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.2, 0.3, 0.1] }}\nmass = {mass}\npose.position = [0, 0, 0.05]\n\
         [[obstacle]]\nname = \"belt\"\nshape = {{ type = \"half_space\" }}\nfriction = {friction}\nsurface_velocity = [{speed}, 0, 0]\n"
    );
    let acceleration = friction * GRAVITY;
    let rides = speed / acceleration;
    // While it slides: x = ½ μ g t², with half of the work of the drive in heat.
    let end = run("belt_slides", &text, 0.3);
    near("x while it slides", (link(&end, "box").position[0], 0.5 * acceleration * 0.09));
    near("work while it slides", (end.energy.work, mass * acceleration * speed * 0.3));
    // Then it has the speed of the belt, and the drive has no more work to do.
    let end = run("belt_rides", &text, 1.5);
    let own = link(&end, "box");
    // Four corners hold all freedoms of a box that rides, and none of these is still.
    assert_eq!((end.method.crowd.steps, end.rejected.0.of(Rejected::EnergyJump)), (0, 0));
    assert!(end.steps < 20, "{} steps", end.steps);
    near("x", (own.position[0], 0.5 * acceleration * rides * rides + speed * (1.5 - rides)));
    near("z", (own.position[2], 0.05));
    near("kinetic energy", (end.energy.parts.kinetic, 0.5 * mass * speed * speed));
    near("work", (end.energy.work, mass * speed * speed));
    near("heat", (end.energy.friction, 0.5 * mass * speed * speed));
}

#[test]
fn a_box_is_carried_up_an_inclined_belt_and_the_drive_lifts_it() {
    let (friction, speed, mass, slope) = (0.7_f64, 1.2, 2.0, 0.35_f64);
    let (sine, cosine) = slope.sin_cos();
    let text = format!(
        "[[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.4, 0.3, 0.1] }}\nmass = {mass}\n\
         pose = {{ position = [{}, 0, {}], rpy = [0, {}, 0] }}\n\
         [[obstacle]]\nname = \"belt\"\nshape = {{ type = \"half_space\" }}\npose = {{ position = [0, 0, 0], rpy = [0, {}, 0] }}\n\
         friction = {friction}\nsurface_velocity = [{speed}, 0, 0]\n",
        -0.05 * sine,
        0.05 * cosine,
        -slope,
        -slope
    );
    let acceleration = GRAVITY * (friction * cosine - sine);
    let rides = speed / acceleration;
    let duration = rides + 0.8;
    let end = run("belt_up", &text, duration);
    let path = 0.5 * acceleration * rides * rides + speed * 0.8;
    near("height", (link(&end, "box").position[2], 0.05 * cosine + path * sine));
    let slid = mass * GRAVITY * friction * cosine * speed * rides;
    near("work", (end.energy.work, slid + mass * GRAVITY * sine * speed * 0.8));
    near("heat", (end.energy.friction, mass * GRAVITY * friction * cosine * (speed * rides - 0.5 * speed * rides)));
}

#[test]
fn a_ball_on_a_belt_rolls_with_two_sevenths_of_its_speed() {
    let (friction, speed, mass, radius) = (0.3, 1.4, 1.7, 0.11);
    let text = format!(
        "[[body]]\nname = \"ball\"\nshape = {{ type = \"sphere\", radius = {radius} }}\nmass = {mass}\npose.position = [0, 0, {radius}]\n\
         [[obstacle]]\nname = \"belt\"\nshape = {{ type = \"half_space\" }}\nfriction = {friction}\nsurface_velocity = [0, {speed}, 0]\n"
    );
    let end = run("belt_ball", &text, 1.0);
    // The slip of the contact falls by 7/2 μ g; then the ball rolls on at a speed of its own.
    let rolls = 2.0 * speed / (7.0 * friction * GRAVITY);
    let path = 0.5 * friction * GRAVITY * rolls * rolls + 2.0 / 7.0 * speed * (1.0 - rolls);
    near("y", (link(&end, "ball").position[1], path));
    near("kinetic energy", (end.energy.parts.kinetic, mass * speed * speed / 7.0));
    near("work", (end.energy.work, 2.0 / 7.0 * mass * speed * speed));
    near("heat", (end.energy.friction, mass * speed * speed / 7.0));
}

#[test]
fn a_body_drives_itself_with_its_tracks_in_its_own_direction() {
    // Its tracks run backwards at 1.5 m/s; it is turned by half a radian, and so is its way.
    let (friction, speed, mass, yaw) = (0.6, 1.5, 5.0, 0.5_f64);
    let text = format!(
        "[[body]]\nname = \"tank\"\nshape = {{ type = \"box\", size = [0.6, 0.4, 0.2] }}\nmass = {mass}\nsurface_velocity = [-{speed}, 0, 0]\n\
         pose = {{ position = [0, 0, 0.1], rpy = [0, 0, {yaw}] }}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = {friction}\n"
    );
    let end = run("tracks", &text, 1.0);
    let rides = speed / (friction * GRAVITY);
    let path = 0.5 * friction * GRAVITY * rides * rides + speed * (1.0 - rides);
    near("x", (link(&end, "tank").position[0], path * yaw.cos()));
    near("y", (link(&end, "tank").position[1], path * yaw.sin()));
    near("work", (end.energy.work, mass * speed * speed));
}

#[test]
fn an_impact_on_a_belt_gives_the_body_the_impulse_of_its_friction() {
    // A ball falls on a belt without spin: P_T = μ (1 + e) m v while it slips, and the drive does the work P_T w.
    let (friction, speed, mass, radius, restitution) = (0.1, 3.0, 2.0, 0.1, 0.5);
    let fall: f64 = 0.4;
    let text = format!(
        "[[body]]\nname = \"ball\"\nshape = {{ type = \"sphere\", radius = {radius} }}\nmass = {mass}\npose.position = [0, 0, {}]\n\
         [[obstacle]]\nname = \"belt\"\nshape = {{ type = \"half_space\" }}\nfriction = {friction}\nrestitution = {restitution}\n\
         surface_velocity = [{speed}, 0, 0]\n",
        radius + fall
    );
    let (hits, down) = ((2.0 * fall / GRAVITY).sqrt(), (2.0 * GRAVITY * fall).sqrt());
    let end = run("belt_impact", &text, hits + 0.1);
    let impulse = friction * (1.0 + restitution) * mass * down;
    near("x", (link(&end, "ball").position[0], impulse / mass * 0.1));
    near("work", (end.energy.work, impulse * speed));
    // ½ m v² (1 − e²) along the normal; P_T w less the energy of motion and of spin that it gave across it.
    let across = impulse * speed - impulse * impulse / (2.0 * mass) * (1.0 + 2.5);
    near("loss", (end.energy.impacts, 0.5 * mass * down * down * (1.0 - restitution * restitution) + across));
}

#[test]
fn a_push_that_begins_makes_a_box_slip_on_its_belt_at_that_instant_whatever_the_tolerance() {
    // 20 N against a grip of 14.7 N from 1 s to 1.2 s: the step that ends there has the forces before it.
    let (mass, grip, speed) = (3.0, 0.5 * GRAVITY, 1.0);
    let text = format!(
        "[[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.2, 0.2, 0.1] }}\nmass = {mass}\nfriction = 0.5\n\
         pose.position = [0, 0, 0.05]\n[[load]]\nlink = \"box\"\nforce = [-20, 0, 0]\nfrom = 1\nuntil = 1.2\n\
         [[obstacle]]\nname = \"belt\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.5\nsurface_velocity = [{speed}, 0, 0]\n"
    );
    let lost = 0.2 * (20.0 / mass - grip);
    // Behind the belt by ½ v²/(μ g) each time that it is brought to its speed, and by half of the speed that is lost while it is pushed.
    let expected = 2.0 * speed - 0.5 * (speed * speed + lost * lost) / grip - 0.5 * 0.2 * lost;
    for power in 2..12 {
        let tolerance = 10_f64.powi(-power);
        let end = report(&scene("belt_pushed", &text), &[], &[], Some(2.0), tolerance);
        // Accelerations are constant between events, so that steps of any length are exact.
        near(&format!("x at {tolerance:e}"), (link(&end, "box").position[0], expected));
        assert!(end.steps < 12, "{} steps", end.steps);
    }
}
