//! Loads that change in time, begin, end or turn with their link, and drag, against closed forms; and a formula of time beside contacts.

use crate::common::scratch;
use crate::scene_files::{joint, report};
use catena::report::Report;
use std::path::{Path, PathBuf};

/// A cart of 2 kg on rails along x, with more tables.
fn cart(folder: &str, more: &str) -> PathBuf {
    let folder = scratch(folder);
    let urdf = "<robot name='r'><link name='base'/><link name='cart'><inertial><mass value='2'/><inertia ixx='1' iyy='1' izz='1' ixy='0' \
                ixz='0' iyz='0'/></inertial></link><joint name='rail' type='prismatic'><parent link='base'/><child link='cart'/>\
                <axis xyz='1 0 0'/><limit lower='-inf' upper='inf' effort='inf' velocity='inf'/></joint></robot>";
    std::fs::write(folder.join("cart.urdf"), urdf).expect("a robot");
    let file = folder.join("cart.toml");
    std::fs::write(&file, format!("[[robot]]\nurdf = \"cart.urdf\"\n{more}")).expect("a scene");
    file
}

/// A free body of 3 kg whose moments are 0.2, 0.5 and 0.4 kg m², without gravity.
fn free_body(folder: &str, more: &str) -> PathBuf {
    let folder = scratch(folder);
    let urdf = "<robot name='r'><link name='hull'><inertial><mass value='3'/><inertia ixx='0.2' iyy='0.5' izz='0.4' ixy='0' ixz='0' \
                iyz='0'/></inertial></link></robot>";
    std::fs::write(folder.join("hull.urdf"), urdf).expect("a robot");
    let file = folder.join("hull.toml");
    let scene = format!("[scene]\ngravity = [0, 0, 0]\n[[robot]]\nurdf = \"hull.urdf\"\nbase = \"floating\"\n{more}");
    std::fs::write(&file, scene).expect("a scene");
    file
}

fn near(what: &str, (is, wanted): (f64, f64), bound: f64) {
    assert!((is - wanted).abs() < bound, "{what}: {is} instead of {wanted}, off by {:.1e}", is - wanted);
}

/// The position of the hull at the end (m).
fn place(report: &Report) -> [f64; 3] {
    report.links.iter().find(|(name, _)| name == "hull").expect("a hull").1.position
}

#[test]
fn a_load_in_a_joint_follows_its_table_its_wave_and_its_switches() {
    // 4 N times a ramp from 0 at 0.5 s to 1 at 1.5 s, then held: v = ½ a τ², x = a τ³/6 on the ramp.
    let ramp = cart("ramp", "[[load]]\njoint = \"rail\"\neffort = 4.0\nfactor = [[0.5, 0], [1.5, 1]]\n");
    let end = report(&ramp, &[], &[], Some(3.0), 1e-11);
    let (x, v) = joint(&end, "rail");
    near("v after the ramp", (v, 1.0 + 2.0 * 1.5), 1e-10);
    near("x after the ramp", (x, 1.0 / 3.0 + 1.5 + 1.5 * 1.5), 1e-10);
    // m ẍ = 3 (0.5 + 2 sin(5 t + 0.3)).
    let wave = "[[load]]\njoint = \"rail\"\neffort = 3.0\nwave = { mean = 0.5, amplitude = 2.0, frequency = 5.0, phase = 0.3 }\n";
    let end = report(&cart("wave", wave), &[], &[], Some(2.0), 1e-11);
    let (x, v) = joint(&end, "rail");
    let cosine = 0.3_f64.cos();
    near("v of the wave", (v, 0.75 * 2.0 + 3.0 / 5.0 * (cosine - 10.3_f64.cos())), 1e-10);
    let wanted = 0.375 * 4.0 + 0.6 * (cosine * 2.0 - (10.3_f64.sin() - 0.3_f64.sin()) / 5.0);
    near("x of the wave", (x, wanted), 1e-10);
    // 10 N from 0.3 s until 0.8 s.
    let push = "[[load]]\njoint = \"rail\"\neffort = 10.0\nfrom = 0.3\nuntil = 0.8\n";
    let end = report(&cart("push", push), &[], &[], Some(1.0), 1e-11);
    let (x, v) = joint(&end, "rail");
    near("v of the push", (v, 2.5), 1e-12);
    near("x of the push", (x, 0.5 * 5.0 * 0.25 + 2.5 * 0.2), 1e-12);
    // All of its energy is work of the load.
    near("work", (end.energy.work, 6.25), 1e-11);
    assert!(end.energy.max_relative_error < 1e-12, "{:?}", end.energy);
}

#[test]
fn a_load_that_begins_pulls_a_joint_off_its_friction() {
    // Friction of 6 N holds until the load, a ramp of 10 N/s, exceeds it at 0.6 s; then ẍ = 5 (t − 0.6).
    let scene = "[[joint]]\nname = \"rail\"\nfriction = 6.0\n[[load]]\njoint = \"rail\"\neffort = 10.0\nfactor = [[0, 0], [2, 2]]\n";
    let end = report(&cart("friction", scene), &[], &[], Some(1.6), 1e-11);
    let (x, v) = joint(&end, "rail");
    near("v", (v, 2.5), 1e-9);
    near("x", (x, 5.0 / 6.0), 1e-9);
    // A jump beyond the friction at 0.7 s.
    let jump =
        "[[joint]]\nname = \"rail\"\nfriction = 6.0\n[[load]]\nlink = \"cart\"\nforce = [10, 0, 0]\nfrom = 0.7\n";
    let end = report(&cart("jump", jump), &[], &[], Some(1.7), 1e-11);
    let (x, v) = joint(&end, "rail");
    near("v after the jump", (v, 2.0), 1e-10);
    near("x after the jump", (x, 1.0), 1e-10);
}

#[test]
fn a_force_that_turns_with_its_link_drives_it_on_a_circle() {
    // A spin of 2 rad/s about z and a force of 3 N ahead: v̇ = (cos 2t, sin 2t).
    let scene = "velocity = { angular = [0, 0, 2] }\n[[load]]\nlink = \"hull\"\nforce = [3, 0, 0]\nframe = \"link\"\n";
    let end = report(&free_body("circle", scene), &[], &[], Some(3.0), 1e-11);
    let t: f64 = 3.0;
    let [x, y, z] = place(&end);
    near("x", (x, 0.25 * (1.0 - (2.0 * t).cos())), 1e-10);
    near("y", (y, 0.5 * t - 0.25 * (2.0 * t).sin()), 1e-10);
    near("z", (z, 0.0), 1e-12);
    assert!(end.energy.max_relative_error < 1e-10, "{:?}", end.energy);
    // A torque about an axis of the link that is no axis of the world: ω₃ = 0.5 t about z of the hull, which is −x of the world.
    let turned = "pose = { rpy = [0, \"-90 deg\", 0] }\n[[load]]\nlink = \"hull\"\ntorque = [0, 0, 0.2]\nframe = \"link\"\nuntil = 2.0\n";
    let end = report(&free_body("torque", turned), &[], &[], Some(3.0), 1e-11);
    let spin = end.links.iter().find(|(name, _)| name == "hull").expect("a hull").1.angular_velocity;
    near("spin", (spin[0], -1.0), 1e-11);
    near("work", (end.energy.work, 0.2), 1e-11);
}

#[test]
fn drag_slows_bodies_as_in_closed_form() {
    // Linear: v = v₀ e^{−ct/m}, quadratic: v = v₀ / (1 + k v₀ t/m).
    let linear = "velocity = { linear = [2, 0, 0], angular = [0, 3, 0] }\n[[drag]]\nlink = \"hull\"\nlinear = 1.5\nangular = 0.25\n";
    let end = report(&free_body("linear", linear), &[], &[], Some(2.0), 1e-11);
    let hull = &end.links.iter().find(|(name, _)| name == "hull").expect("a hull").1;
    let decay = (-1.0_f64).exp();
    near("x", (hull.position[0], 4.0 * (1.0 - decay)), 1e-10);
    near("spin", (hull.angular_velocity[1], 3.0 * decay), 1e-10);
    let lost = 0.5 * 3.0 * 4.0 * (1.0 - decay * decay) + 0.5 * 0.5 * 9.0 * (1.0 - decay * decay);
    near("heat", (end.energy.dissipated, lost), 1e-9);
    let quadratic = "velocity = { linear = [2, 0, 0] }\n[[drag]]\nlink = \"hull\"\nquadratic = 0.6\n";
    let end = report(&free_body("quadratic", quadratic), &[], &[], Some(2.0), 1e-11);
    near("x", (place(&end)[0], 5.0 * 1.8_f64.ln()), 1e-10);
    // In the plane of a cart, that falls through a fluid: v = v∞ tanh(g t / v∞) with v∞² = m g/k.
    let falls = "[scene]\ngravity = [-9.81, 0, 0]\n[[drag]]\nlink = \"cart\"\nquadratic = 0.4\n";
    let end = report(&cart("falls", falls), &[], &[], Some(1.5), 1e-11);
    let limit = (2.0 * 9.81 / 0.4_f64).sqrt();
    near("v", (joint(&end, "rail").1, -limit * (9.81 * 1.5 / limit).tanh()), 1e-9);
    assert!(end.energy.max_relative_error < 1e-10, "{:?}", end.energy);
}

#[test]
fn quadratic_drag_that_comes_to_a_standstill_is_as_accurate_as_the_run_says() {
    // Thrown up at 8 m/s: v∞² = m g/k, h = v∞²/(2 g) ln(1 + v₀²/v∞²) after (v∞/g) atan(v₀/v∞), then v∞²/g ln cosh(g τ/v∞) down again. A sideways
    // speed of u turns the kink at the top into a bend of u/g seconds; the same throw seen from a frame that moves with u has no closed form, so that
    // it is compared with itself at a tolerance of 1e-12 m.
    let (weight, drag) = (2.0 * 9.81, 0.6_f64);
    let limit = (weight / drag).sqrt();
    let rises = limit / 9.81 * (8.0 / limit).atan();
    let top = limit * limit / (2.0 * 9.81) * (64.0 / (limit * limit)).ln_1p();
    let fallen = limit * limit / 9.81 * (9.81 * (1.5 - rises) / limit).cosh().ln();
    let thrown =
        "velocities = { rail = 8.0 }\n[scene]\ngravity = [-9.81, 0, 0]\n[[drag]]\nlink = \"cart\"\nquadratic = 0.6\n";
    for tolerance in [1e-4, 1e-6, 1e-9] {
        let end = report(&cart("thrown", thrown), &[], &[], Some(1.5), tolerance);
        let off = (joint(&end, "rail").0 - (top - fallen)).abs();
        let estimated = end.accuracy.as_ref().expect("an estimate").estimated;
        // Ten times, because the estimate is an order of magnitude; it was 1e4 times and more.
        assert!(off <= (10.0 * estimated).min(tolerance), "{off:e} m at {tolerance:e}, said {estimated:e}");
    }
    for sideways in [1e-5, 1e-3, 0.03, 0.5] {
        let near = format!(
            "velocity = {{ linear = [{sideways}, 0, 8] }}\n[[load]]\nlink = \"hull\"\nforce = [0, 0, -30]\n\
             [[drag]]\nlink = \"hull\"\nquadratic = 0.9\n"
        );
        let file = free_body("bend", &near);
        let fine = place(&report(&file, &[], &[], Some(1.5), 1e-12));
        for tolerance in [1e-5, 1e-8] {
            let end = place(&report(&file, &[], &[], Some(1.5), tolerance));
            let off = (end[0] - fine[0]).hypot(end[2] - fine[2]);
            assert!(off <= tolerance, "{off:e} m at {tolerance:e} with {sideways} m/s sideways");
        }
    }
}

#[test]
fn no_pulse_and_no_kink_of_a_formula_is_jumped_over() {
    // A pulse e^{−((t − c)/w)²}/w gives √π N s, so that a body of m kg is at √π (T − c)/m at the end: to e^{−(c/w)²}, zero in doubles.
    let impulse = std::f64::consts::PI.sqrt();
    for width in [0.1, 0.03, 0.01, 0.003, 0.001, 1e-5] {
        let pulse = format!("factor = {{ formula = \"exp(-((t-3.7)/w)^2)/w\", w = {width} }}\n");
        let on_body = format!("[[load]]\nlink = \"hull\"\nforce = [1, 0, 0]\n{pulse}");
        let end = report(&free_body("pulse", &on_body), &[], &[], Some(10.0), 1e-6);
        near("the place of a free body", (place(&end)[0], impulse * 6.3 / 3.0), 1e-6);
        let on_joint = format!("[[load]]\njoint = \"rail\"\neffort = 1\n{pulse}");
        let end = report(&cart("pulse", &on_joint), &[], &[], Some(10.0), 1e-6);
        near("the place of a cart", (joint(&end, "rail").0, impulse * 6.3 / 2.0), 1e-6);
        let motor = format!(
            "[[motor]]\njoint = \"rail\"\nkind = \"effort\"\ntarget = {{ formula = \"exp(-((t-3.7)/w)^2)/w\", w = {width} }}\n"
        );
        let end = report(&cart("driven", &motor), &[], &[], Some(10.0), 1e-6);
        near("the place of a driven cart", (joint(&end, "rail").0, impulse * 6.3 / 2.0), 1e-6);
        // Its steps are few beside the hundreds of thousands of pulses in the run.
        assert!(end.steps < 400, "{} steps for {width} s", end.steps);
    }
    // ∫∫ |t − c| = T c²/2 − c³/6 + (T − c)³/6.
    let kink = "[[load]]\nlink = \"hull\"\nforce = [3, 0, 0]\nfactor = { formula = \"sqrt((t-0.533)^2)\" }\n";
    for tolerance in [1e-6, 1e-9] {
        let end = report(&free_body("kink", kink), &[], &[], Some(2.0), tolerance);
        let wanted = 2.0 * 0.533_f64.powi(2) / 2.0 - 0.533_f64.powi(3) / 6.0 + 1.467_f64.powi(3) / 6.0;
        near("the place after a kink", (place(&end)[0], wanted), tolerance);
    }
}

#[test]
fn the_estimated_error_has_the_quadrature_of_forces_that_are_given_in_time() {
    let impulse = std::f64::consts::PI.sqrt();
    for width in [0.1, 0.01, 0.001] {
        let pulse = format!("exp(-((t-3.7)/w)^2)/w\", w = {width} }}\n");
        let on_body = format!("[[load]]\nlink = \"hull\"\nforce = [1, 0, 0]\nfactor = {{ formula = \"{pulse}");
        let on_joint = format!("[[load]]\njoint = \"rail\"\neffort = 1\nfactor = {{ formula = \"{pulse}");
        let motor = format!("[[motor]]\njoint = \"rail\"\nkind = \"effort\"\ntarget = {{ formula = \"{pulse}");
        for tolerance in [1e-3, 1e-6, 1e-8] {
            let told = |file: &Path, off: &dyn Fn(&Report) -> f64| {
                let end = report(file, &[], &[], Some(10.0), tolerance);
                let accuracy = end.accuracy.expect("an estimate");
                let (error, estimated) = (off(&end).abs(), accuracy.estimated);
                // Below 1e-11 m roundings add up. Errors of steps have different signs, and their sizes are added: hundreds of times at most.
                assert!(
                    error <= 3.0 * estimated + 1e-11,
                    "{width} s, {tolerance:e} m: {error:e} m off, told {estimated:e} m"
                );
                assert!(
                    estimated <= 300.0 * error + 1e-11,
                    "{width} s, {tolerance:e} m: {error:e} m off, told {estimated:e} m"
                );
                assert!(accuracy.reached && accuracy.begun == 1, "{accuracy:?}");
            };
            told(&free_body("told", &on_body), &|end| place(end)[0] - impulse * 6.3 / 3.0);
            told(&cart("told", &on_joint), &|end| joint(end, "rail").0 - impulse * 6.3 / 2.0);
            told(&cart("told", &motor), &|end| joint(end, "rail").0 - impulse * 6.3 / 2.0);
        }
    }
}

#[test]
fn what_cannot_be_a_load_is_refused_in_one_line() {
    for (scene, reason) in [
        ("[[load]]\njoint = \"rail\"\neffort = 1\nframe = \"link\"\n", "no position, force, torque or frame"),
        ("[[load]]\njoint = \"rail\"\neffort = 1\nfrom = 2\nuntil = 1\n", "a load ends after it begins"),
        ("[[load]]\njoint = \"rail\"\neffort = 1\nfactor = 2\nwave = { frequency = 1 }\n", "either a factor or a wave"),
        ("[[load]]\njoint = \"rail\"\neffort = 1\nfactor = [[1, 0], [1, 2]]\n", "give increasing times"),
        ("[[drag]]\nlink = \"cart\"\n", "drag needs its linear"),
        ("[[drag]]\nlink = \"base\"\nlinear = 1\n", "drag of \"base\""),
    ] {
        let error = catena::session::Model::load(cart("refused", scene)).expect_err(reason).to_string();
        assert!(error.contains("cart.toml:") && error.contains(reason) && !error.contains('\n'), "{error}");
    }
}

/// A winch pulls at a box on a floor, beside its centre. Steps once went half of what was left of the run, down to lengths without digits: 40 of
/// them, and a velocity that was off by 2e-5 m/s.
#[test]
fn a_formula_of_time_beside_contacts_does_not_make_steps_ever_shorter_towards_the_end() {
    let folder = scratch("winch_beside_contacts");
    let scene = "[[body]]\nname = \"box\"\nshape = { type = \"box\", size = [0.4, 0.2, 0.1] }\nmass = 4\npose.position = [0, 0, 0.05]\n\
        [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n\
        [[rope]]\nname = \"r\"\n\
        points = [{ link = \"world\", position = [0.3, 0.05, 1.5] }, { link = \"box\", position = [0.2, 0.03, 0.05] }]\n\
        length = { formula = \"1.5 - v*t\", v = 0.2 }\n";
    let file = folder.join("winch.toml");
    std::fs::write(&file, scene).expect("a scene");
    let end = report(&file, &[], &[], Some(0.4885), 1e-9);
    assert!(end.steps <= 10, "{} steps", end.steps);
    // The rope goes taut at 0.4815 s, and the box tilts on an edge that slides. Steps of 1e-3 s and of 3e-5 s, of three to nine stages, have this
    // velocity at the end to its last digit.
    let (_, link) = &end.links[0];
    let off = (link.linear_velocity[0] + 0.023125148684).abs();
    assert!(off < 1e-12, "{off:e}: {:?}", link.linear_velocity);
}
