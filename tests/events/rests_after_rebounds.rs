//! Rebounds that are left out before a body rests: each with its friction, so that what slides on has the momentum that it would have after them.
//!
//! ```text
//!     Σ P = m v + m g cos α t     all impulses of bounces and of the rest after them: v is the speed of the first impact
//!     x(t) = ½ (g sin α − μ g cos α) t² + μ h,     after a fall from the height h, whatever the restitution is
//!     x(t) = v t − μ (½ g t² + z(t) − z(0))        of the centre of mass of whatever slides one way on a level floor, however it rocks
//!     ½ m ż² + ½ I ω² + m g z = m g z(0)           of a body that tips on a level floor without friction: what leaves and is not pulled back keeps its rate
//! ```

use crate::mechanisms::GRAVITY;
use crate::scene_files::{report, scene_of};
use catena::report::Report;
use std::f64::consts::FRAC_PI_2;

/// A box that falls flat on something.
fn dropped(height: f64, under: &str, angle: f64) -> String {
    let [along, down] = [GRAVITY * angle.sin(), -GRAVITY * angle.cos()];
    format!(
        "[scene]\ngravity = [{along:?}, 0.0, {down:?}]\n[[obstacle]]\nname = \"under\"\nshape = {{ type = \"half_space\" }}\n{under}\n\
         [[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.2, 0.2, 0.05] }}\nmass = 1.3\n\
         pose = {{ position = [0.0, 0.0, {:?}] }}\n",
        0.025 + height
    )
}

fn along(report: &Report) -> f64 {
    report.links[0].1.position[0]
}

#[test]
fn a_box_that_falls_on_a_slope_slides_as_far_as_if_it_had_not_bounced() {
    // The last rebound was stopped without its friction, 9e-6 m/s: 9e-5 m after ten seconds, of which 2e-10 m were told.
    let (angle, friction) = (0.36651914_f64, 0.31);
    for (restitution, height) in [(0.05, 0.002), (0.085, 0.013), (0.1, 0.005), (0.23, 0.011)] {
        let under = format!("friction = {friction}\nrestitution = {restitution}");
        let file = scene_of("falls_on_slope", "", &dropped(height, &under, angle));
        let expected = 50.0 * GRAVITY * (angle.sin() - friction * angle.cos()) + friction * height;
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let end = report(&file, &[], &[], Some(10.0), tolerance);
            let off = (along(&end) - expected).abs();
            println!("restitution {restitution} at {tolerance:e}: {off:e} m");
            // Roundings of 34 m; the rebounds that are left out are of 1e-4 of the tolerance.
            assert!(off < 1e-12 + 1e-4 * tolerance, "restitution {restitution} at {tolerance:e}: {off:e} m");
        }
    }
}

#[test]
fn a_box_that_falls_on_a_belt_sticks_when_its_friction_has_brought_it_to_the_speed_of_the_belt() {
    let (speed, friction, height) = (0.9, 0.27, 0.005);
    for restitution in [0.0, 0.06, 0.1] {
        let under =
            format!("friction = {friction}\nrestitution = {restitution}\nsurface_velocity = [{speed}, 0.0, 0.0]");
        let file = scene_of("falls_on_belt", "", &dropped(height, &under, 0.0));
        // The speed is μ g t after the fall, until it is that of the belt.
        let sticks = speed / (friction * GRAVITY);
        let expected = 0.5 * friction * GRAVITY * sticks * sticks - friction * height + speed * (10.0 - sticks);
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let end = report(&file, &[], &[], Some(10.0), tolerance);
            let off = (along(&end) - expected).abs();
            println!("restitution {restitution} at {tolerance:e}: {off:e} m of {expected}");
            assert!(off < 1e-12 + 1e-4 * tolerance, "restitution {restitution} at {tolerance:e}: {off:e} m");
        }
    }
}

#[test]
fn a_rod_that_rocks_to_rest_while_it_slides_keeps_all_of_its_friction() {
    // Its ends kick each other open, because its weight is beyond them. The last of these flights were stopped without their friction: up to 1e-4 m off at
    // 1e-3 m, and 1e-7 m off at 1e-9 m, of which 4e-12 m were told.
    let (friction, speed) = (0.25, 4.0);
    let robot = "<link name='rod'><inertial><mass value='1.3'/><inertia ixx='0.03' iyy='0.03' izz='0.002' ixy='0' ixz='0' iyz='0'/></inertial>\
        <collision><geometry><capsule radius='0.04' length='0.2'/></geometry></collision></link>";
    for (height, pitch) in [(0.1, 0.05), (0.2, 0.2), (0.3, -0.4), (0.15, -0.02)] {
        for restitution in [0.0, 0.1, 0.3] {
            let scene = format!(
                "[[robot]]\nname = \"r\"\nurdf = \"robot.urdf\"\nbase = \"floating\"\nvelocity = {{ linear = [{speed}, 0, 0] }}\n\
                 pose = {{ position = [0, 0, {height}], rpy = [0, {}, 0] }}\n[[obstacle]]\nname = \"floor\"\n\
                 shape = {{ type = \"half_space\" }}\nfriction = {friction}\nrestitution = {restitution}\n",
                FRAC_PI_2 + pitch
            );
            let file = scene_of("rod_rocks_and_slides", robot, &scene);
            for tolerance in [1e-3, 1e-6, 1e-9] {
                let end = report(&file, &[], &[], Some(1.0), tolerance);
                let [x, _, z] = end.links[0].1.position;
                let off = (x - speed + friction * (0.5 * GRAVITY + z - height)).abs();
                println!("from {height} m at {pitch} rad, restitution {restitution}, {tolerance:e}: {off:e} m");
                assert!(
                    off < 1e-11,
                    "from {height} m at {pitch} rad, restitution {restitution}, {tolerance:e}: {off:e} m"
                );
            }
        }
    }
}

#[test]
fn a_body_that_tips_from_one_foot_to_another_beside_it_keeps_its_speed_at_every_tolerance() {
    // The first foot leaves at 2e-6 m/s and is not pulled back. At 1e-2 m it was brought to rest, which stopped the body: 2e-3 J, its whole kinetic energy then.
    let (apart, bottom) = (1e-5_f64, 0.5_f64);
    let foot = |x: f64, z: f64| {
        format!("<collision><origin xyz='{x:?} 0 {z:?}'/><geometry><sphere radius='0.01'/></geometry></collision>")
    };
    let feet = foot(0.0, -bottom) + &foot(apart * bottom.cos(), apart * bottom.sin() - bottom);
    let robot = format!(
        "<link name='rod'><inertial><mass value='1'/><inertia ixx='0.02' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial>{feet}</link>"
    );
    let lean = 0.499_f64;
    let high = 0.01 + bottom * lean.cos();
    let scene = format!(
        "[[robot]]\nname = \"r\"\nurdf = \"robot.urdf\"\nbase = \"floating\"\npose = {{ position = [0, 0, {high:?}], rpy = [0, {lean}, 0] }}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.0\n"
    );
    let file = scene_of("tips_over_two_feet", &robot, &scene);
    for tolerance in [1e-2, 1e-3, 1e-5, 1e-7, 1e-9] {
        let end = report(&file, &[], &[], Some(0.2), tolerance);
        let rod = &end.links[0].1;
        let spin = rod.angular_velocity[1];
        let energy = 0.5 * rod.linear_velocity[2].powi(2) + 0.01 * spin * spin + GRAVITY * rod.position[2];
        let off = (energy - GRAVITY * high).abs();
        println!("{tolerance:e}: {off:e} J off, {spin} rad/s");
        assert!(spin > 2.0, "{tolerance:e}: the second foot has not come down");
        // Of 4.4 J. Steps leave 2e-10 J at the loosest tolerance, and the impact takes 1e-12 J.
        assert!(off < 1e-9, "{tolerance:e}: {off:e} J");
    }
}
