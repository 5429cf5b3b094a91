//! Copies, height fields, joints in frames, and actuators with dynamics of MJCF files.

use super::read;
use crate::common::command;
use catena::session::{Model, Simulation};

#[test]
fn copies_have_the_names_and_frames_of_mujoco_and_what_names_them_is_copied_too() {
    let text = "<mujoco><worldbody>
      <replicate count='3' offset='0.5 0 0' euler='0 0 30' sep='-'><body name='b' pos='0 0 1'><joint name='j' axis='0 1 0'/>
        <geom name='g' size='.1' pos='.2 0 0'/><site name='s'/></body></replicate>
      <body name='c'><joint name='k' type='slide'/><geom size='.1' mass='1'/>
        <replicate count='2' offset='0 1 0' sep='_'><replicate count='11' offset='0 0 1'><geom name='h' size='.1' mass='0.5'/></replicate></replicate></body>
      </worldbody>
      <tendon><spatial name='t' range='0 9'><site site='hook'/><site site='s'/></spatial></tendon>
      <actuator><motor name='m' joint='j' gear='2'/><motor joint='k' gear='3'/></actuator>
      <keyframe><key name='home' qpos='0.1 0.2 0.3 0.4' ctrl='1 2 3 4'/></keyframe></mujoco>"
        .replace("<worldbody>", "<worldbody><site name='hook'/>");
    let folder = command::folder("mjcf_copies");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::loader().keyframe("home").load(folder.join("model.xml")).expect("a model");
    assert_eq!(model.joint_names(), ["b-0/j-0", "b-1/j-1", "b-2/j-2", "c/k"]);
    // (0.5, 0, 0) and 30° about z, once and twice, as MuJoCo 4.0.0 writes them, and 1 m above.
    let wanted = [[0.0, 0.0, 1.0], [0.5, 0.0, 1.0], [0.933_012_701_892_219_3, 0.25, 1.0]];
    let (q, _) = model.start().expect("a start");
    for (copy, wanted) in wanted.into_iter().enumerate() {
        let place = model.pose(&format!("b-{copy}/b-{copy}"), &q).expect("a link").translation.vector;
        // Some roundings of sums of one.
        assert!((place - nalgebra::Vector3::from(wanted)).amax() < 1e-15, "{copy}: {place}");
    }
    // Its own kilogram and 22 balls of half a kilogram.
    let description = model.description();
    let mass = description.links[description.link("c/c").expect("a link")].mass;
    assert!((mass - 12.0).abs() < 1e-14, "{mass}");
    // Controls go to the actuator that names none of the copies, then to those of the copies.
    let efforts: Vec<(String, f64)> = model
        .motor_names()
        .iter()
        .zip(&description.mechanism.nonsmooth.motors)
        .map(|(joint, motor)| (joint.to_string(), motor.effort(0.0, 0.0, 0.0)))
        .collect();
    let wanted = [("c/k", 3.0), ("b-0/j-0", 4.0), ("b-1/j-1", 6.0), ("b-2/j-2", 8.0)];
    for (joint, effort) in wanted {
        assert!(efforts.contains(&(joint.to_string(), effort)), "{joint}: {efforts:?}");
    }
    let ropes = read("mjcf_copied_ropes", &std::fs::read_to_string(folder.join("model.xml")).expect("a file"));
    let ropes: Vec<String> = ropes.expect("a scene").ropes.into_iter().map(|rope| rope.name).collect();
    assert_eq!(ropes, ["t-0", "t-1", "t-2"]);
    for (given, said) in [
        ("<replicate count='1.5'>", "model.xml:1: <replicate count=\"1.5\">: a whole number from 1 on is wanted"),
        ("<replicate count='1e9'>", "model.xml:1: <replicate count=\"1e9\">: a whole number from 1 on is wanted"),
        ("<replicate>", "model.xml:1: <replicate> has no count"),
    ] {
        let text =
            format!("<mujoco><worldbody>{given}<body><joint/><geom size='1'/></body></replicate></worldbody></mujoco>");
        let error = read("mjcf_wrong_copies", &text).expect_err(given).to_string();
        assert!(error.contains(said) && error.lines().count() == 1, "{given}: {error}");
    }
}

#[test]
fn joints_in_frames_of_a_body_turn_about_the_axes_of_their_frames() {
    let text = "<mujoco><worldbody><body name='b'><joint name='j'/><frame pos='1 0 0' euler='0 90 0'><joint name='k' axis='0 0 1' pos='0 1 0'/></frame>
      <geom size='.1' pos='3 0 0'/></body></worldbody></mujoco>";
    let folder = command::folder("mjcf_frames");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::load(folder.join("model.xml")).expect("a model");
    assert_eq!(model.joint_names(), ["j", "k"]);
    // MuJoCo 4.0.0 has the axis x through (1, 1, 0) for k: a quarter turn takes (3, 0, 0) to (3, 1, −1).
    let pose = model.pose("b", &[0.0, std::f64::consts::FRAC_PI_2]).expect("a link");
    let center = pose * nalgebra::Point3::new(3.0, 0.0, 0.0);
    assert!((center.coords - nalgebra::Vector3::new(3.0, 1.0, -1.0)).amax() < 1e-14, "{center}");
}

#[test]
fn a_height_field_is_a_solid_on_which_bodies_rest_at_the_heights_of_mujoco() {
    let place = |x: f64, y: f64| {
        let text = format!(
            "<mujoco><asset><hfield name='h' nrow='3' ncol='4' size='2 1 0.5 0.1' elevation='0 1 2 3  4 5 6 7  8 9 10 5'/></asset><worldbody>
             <geom name='land' type='hfield' hfield='h' pos='0 0 1'/>
             <body name='b' pos='{x} {y} 3'><joint name='z' type='slide' axis='0 0 1'/><geom size='0.01' mass='1'/></body></worldbody></mujoco>"
        );
        let folder = command::folder("mjcf_field");
        std::fs::write(folder.join("model.xml"), text).expect("written");
        let model = Model::load(folder.join("model.xml")).expect("a model");
        let mut simulation = Simulation::new(&model).duration(1.5).tolerance(1e-8);
        simulation.run().expect("a run");
        simulation.pose("b").expect("a link").translation.z
    };
    // Heights of MuJoCo 4.0.0 below the points, by rays, and the slopes of the triangles there: a ball of the radius r on a slide rests
    // r √(1 + s²) above a triangle of the slope s.
    let places: [(f64, f64, f64, [f64; 2]); 3] = [
        (-1.6, -0.8, 1.375, [0.05 * 0.75, -0.2]),
        (1.9, -0.9, 1.278_75, [-0.25 * 0.75, 0.1]),
        (1.4, 0.2, 1.2875, [0.05 * 0.75, -0.2]),
    ];
    for (x, y, height, slope) in places {
        let wanted = height + 0.01 * (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
        let seen = place(x, y);
        // The tolerance, and the impact, after which it is pressed to the triangle.
        assert!((seen - wanted).abs() < 1e-8, "{x} {y}: {seen} {wanted}");
    }
    let moving = "<mujoco><asset><hfield name='h' nrow='2' ncol='2' size='2 1 0.5 0.1'/><hfield file='a.png' size='1 1 1 1'/></asset><worldbody>
      <body><joint/><geom type='hfield' hfield='h'/><geom size='1'/></body><geom type='hfield' hfield='a'/></worldbody></mujoco>";
    let warnings = read("mjcf_moving_field", moving).expect("a scene").warnings;
    let told: Vec<String> = warnings.iter().map(|warning| warning.to_string()).collect();
    for said in [
        "model.xml:1: a height field from a picture is not read",
        "model.xml:2: a height field that moves touches nothing",
    ] {
        assert!(told.iter().any(|line| line.contains(said)), "{said}: {told:#?}");
    }
    let wrong = "<mujoco><asset><hfield name='h' nrow='2' ncol='2' size='2 1 0 0.1'/></asset></mujoco>";
    let error = read("mjcf_wrong_field", wrong).expect_err("a size of zero").to_string();
    assert!(error.contains("model.xml:1: <hfield size=\"2 1 0 0.1\">: all four numbers"), "{error}");
}

/// A force over time, position and rate.
type Force = Box<dyn Fn(f64, f64, f64) -> f64>;

/// Solves `M q̈ = f(t, q, q̇)` by the classical method of Runge and Kutta in steps of 1e-4 s.
fn integrated(mass: f64, duration: f64, force: impl Fn(f64, f64, f64) -> f64) -> (f64, f64) {
    let steps = (duration / 1e-4).round() as usize;
    let h = duration / steps as f64;
    let rate = |t: f64, [q, v]: [f64; 2]| [v, force(t, q, v) / mass];
    let moved = |[q, v]: [f64; 2], [dq, dv]: [f64; 2], by: f64| [q + by * dq, v + by * dv];
    let mut at = [0.0, 0.0];
    for step in 0..steps {
        let t = h * step as f64;
        let a = rate(t, at);
        let b = rate(t + 0.5 * h, moved(at, a, 0.5 * h));
        let c = rate(t + 0.5 * h, moved(at, b, 0.5 * h));
        let d = rate(t + h, moved(at, c, h));
        at = [0, 1].map(|i| at[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    (at[0], at[1])
}

#[test]
fn actuators_with_dynamics_of_their_own_drive_as_their_activations_say() {
    let run = |actuator: &str, key: &str| {
        let text = format!(
            "<mujoco><option gravity='0 0 0'/><worldbody><body><joint name='x' type='slide' axis='1 0 0'/><geom size='.1' mass='2'/></body></worldbody>
             <actuator>{actuator}</actuator><keyframe><key name='k' {key}/></keyframe></mujoco>"
        );
        let folder = command::folder("mjcf_dynamics");
        std::fs::write(folder.join("model.xml"), text).expect("written");
        let model = Model::loader().keyframe("k").load(folder.join("model.xml")).expect("a model");
        assert!(model.warnings().iter().all(|line| !line.contains("not simulated")), "{:?}", model.warnings());
        let mut simulation = Simulation::new(&model).duration(2.0).tolerance(1e-10);
        simulation.run().expect("a run");
        (simulation.position("x").expect("a joint")[0], simulation.velocity("x").expect("a joint")[0])
    };
    let filter = |u: f64, a: f64, time: f64| move |t: f64| u + (a - u) * (-t / time).exp();
    let integrator = |u: f64, a: f64, end: f64| move |t: f64| a + u * t.min(end);
    let cases: Vec<(&str, &str, Force)> = vec![
        ("<general joint='x' dyntype='filter' dynprm='0.3' gear='2'/>", "ctrl='3' act='1'", {
            let a = filter(3.0, 1.0, 0.3);
            Box::new(move |t, _, _| 2.0 * a(t))
        }),
        ("<position joint='x' kp='20' kv='3' timeconst='0.4'/>", "ctrl='0.5'", {
            let a = filter(0.5, 0.0, 0.4);
            Box::new(move |t, q, v| 20.0 * (a(t) - q) - 3.0 * v)
        }),
        // Stiffness and damping in the ratio of the time constant.
        ("<position joint='x' kp='20' kv='5' timeconst='0.25'/>", "ctrl='0.5'", {
            let a = filter(0.5, 0.0, 0.25);
            Box::new(move |t, q, v| 20.0 * (a(t) - q) - 5.0 * v)
        }),
        ("<intvelocity joint='x' kp='20' kv='4' actrange='-1 0.6'/>", "ctrl='0.5' act='0.1'", {
            let a = integrator(0.5, 0.1, 1.0);
            Box::new(move |t, q, v| 20.0 * (a(t) - q) - 4.0 * v)
        }),
        (
            "<general joint='x' dyntype='integrator' gainprm='5' biastype='affine' biasprm='0.5 0 -3'/>",
            "ctrl='-0.5'",
            {
                let a = integrator(-0.5, 0.0, f64::INFINITY);
                Box::new(move |t, _, v| 5.0 * a(t) + 0.5 - 3.0 * v)
            },
        ),
        ("<general joint='x' dyntype='integrator' gainprm='5' actrange='-1 0.6'/>", "ctrl='0.5' act='0.1'", {
            let a = integrator(0.5, 0.1, 1.0);
            Box::new(move |t, _, _| 5.0 * a(t))
        }),
        ("<cylinder joint='x' timeconst='0.2' area='3' bias='1 -2 -1'/>", "ctrl='0.5'", {
            let a = filter(0.5, 0.0, 0.2);
            Box::new(move |t, q, v| 3.0 * a(t) + 1.0 - 2.0 * q - v)
        }),
    ];
    for (actuator, key, force) in cases {
        let (q, v) = run(actuator, key);
        let (wanted_q, wanted_v) = integrated(2.0, 2.0, force);
        // The tolerance; the other integration is some 1e-13 off, and 1e-12 at a kink on the end of one of its steps.
        assert!(
            (q - wanted_q).abs() < 1e-10 && (v - wanted_v).abs() < 1e-9,
            "{actuator}: {q} {wanted_q}, {v} {wanted_v}"
        );
    }
    // A damper brakes by its control: m v̇ = −kv u v.
    let text = "<mujoco><option gravity='0 0 0'/><worldbody><body><joint name='x' type='slide' axis='1 0 0'/><geom size='.1' mass='2'/></body></worldbody>
      <actuator><damper joint='x' kv='2' ctrlrange='0 1'/></actuator><keyframe><key name='k' qvel='1' ctrl='0.5'/></keyframe></mujoco>";
    let folder = command::folder("mjcf_damper");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::loader().keyframe("k").load(folder.join("model.xml")).expect("a model");
    let mut simulation = Simulation::new(&model).duration(2.0).tolerance(1e-10);
    simulation.run().expect("a run");
    let rate = simulation.velocity("x").expect("a joint")[0];
    assert!((rate - (-1.0_f64).exp()).abs() < 1e-10, "{rate}");
}

#[test]
fn a_muscle_is_told_with_its_line_and_counts_among_the_activations() {
    let text = "<mujoco><worldbody><body><joint name='x' type='slide'/><geom size='.1'/></body></worldbody>
      <actuator><muscle joint='x'/>
      <general joint='x' dyntype='filter'/></actuator><keyframe><key name='k' act='0.25 0.5'/></keyframe></mujoco>";
    let folder = command::folder("mjcf_muscle");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::loader().keyframe("k").load(folder.join("model.xml")).expect("a model");
    let told = model.warnings();
    let said = "model.xml:2: actuators with the dynamics \"muscle\" are not simulated";
    assert!(told.iter().any(|line| line.contains(said)), "{told:#?}");
    assert_eq!(model.description().mechanism.nonsmooth.motors[0].effort(0.0, 0.0, 0.0), 0.5);
}
