//! Runs go on through dead points of loops and gimbal locks: joints turn round there, or turn against each other without bound.

use crate::common::shared;
use crate::scene_files::{apart, joint, report, scene_of};
use catena::prelude::{Model, Simulation};
use std::path::PathBuf;

#[test]
fn a_joint_with_friction_turns_round_at_a_dead_point_of_its_loop_while_another_joint_is_held() {
    let Some(folder) = shared("repro/events") else { return };
    for (file, held) in [("sstuck9.toml", "side"), ("loops232.toml", "j5")] {
        let found = report(&folder.join(file), &[], &[], None, 1e-6);
        // Reversals at dead points are among the events; the steps between them have the tolerance.
        assert!(found.energy.max_relative_error < 1e-6, "{file}: {:e}", found.energy.max_relative_error);
        assert!(found.accuracy.as_ref().is_some_and(|accuracy| accuracy.reached), "{file}");
        assert_eq!(joint(&found, held).1, 0.0, "{file}: it is held");
    }
}

#[test]
fn a_neck_with_limits_and_massless_links_goes_on_through_gimbal_lock() {
    let Some(folder) = shared("repro/events") else { return };
    let neck = folder.join("neck.urdf");
    for (positions, velocities) in [
        // A limit is met where the middle joint is at 90°; and the head goes through it.
        ([1.108, 0.539, 0.099], [-4.462, -6.787, 9.399]),
        ([0.784, 0.925, 0.385], [-5.089, 5.37, -5.767]),
        // Seeds 9, 108, 117 and 165 of random starts, in which impacts near the lock gave energy.
        ([-0.089, -0.868, -1.185], [-2.027, 5.865, 0.045]),
        ([-0.887, 0.913, -0.536], [5.05, -1.839, -4.866]),
        ([-0.624, -0.24, -0.224], [-5.37, -5.462, -6.122]),
        ([-1.16, 0.94, -0.638], [7.389, -6.813, -5.187]),
    ] {
        let named = |values: [f64; 3]| ["z", "x", "y"].into_iter().zip(values).collect::<Vec<_>>();
        let found = report(&neck, &named(positions), &named(velocities), Some(0.5), 1e-6);
        // First-order steps of a microsecond next to the lock are off by some thousandths of the kinetic energy, and say so.
        let error = found.energy.max_relative_error;
        let told = found.warnings.iter().any(|warning| warning.contains("first-order"));
        assert!(error < 1e-5 || (error < 1e-2 && told), "{positions:?}: {error:e}, {:?}", found.warnings);
        for name in ["z", "x", "y"] {
            let (position, rate) = joint(&found, name);
            // The limits are 90° rounded up, by 3.7e-6 rad.
            assert!(
                position.abs() <= std::f64::consts::FRAC_PI_2 + 4e-6 && rate.is_finite(),
                "{positions:?}: {name} {position} {rate}"
            );
        }
    }
}

#[test]
fn a_start_in_gimbal_lock_of_links_without_mass_goes_on_as_starts_beside_it_and_is_told() {
    let folder = crate::common::scratch("gimbal_lock");
    let joint = |name: &str, from: &str, to: &str, axis: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{from}\"/><child link=\"{to}\"/><axis xyz=\"{axis}\"/></joint>"
        )
    };
    let urdf = format!(
        "<robot name=\"r\"><link name=\"base\"/><link name=\"r1\"/><link name=\"r2\"/><link name=\"b\"><inertial><mass value=\"1\"/>\
         <inertia ixx=\"0.02\" iyy=\"0.03\" izz=\"0.04\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>{}{}{}</robot>",
        joint("a", "base", "r1", "0 0 1"),
        joint("p", "r1", "r2", "0 1 0"),
        joint("c", "r2", "b", "1 0 0")
    );
    std::fs::write(folder.join("r.urdf"), urdf).expect("a robot");
    let from = |angle: f64| {
        let file = folder.join("s.toml");
        let scene = format!(
            "[[robot]]\nurdf = \"r.urdf\"\npositions = {{ a = 0.3, p = {angle:?}, c = 0.1 }}\nvelocities = {{ a = 0.5, p = 1.0, c = -0.7 }}\n"
        );
        std::fs::write(&file, scene).expect("a scene");
        crate::scene_files::report(&file, &[], &[], Some(3.0), 1e-6)
    };
    let lock = std::f64::consts::FRAC_PI_2;
    let turned =
        |end: &catena::report::Report| end.links.iter().find(|(name, _)| name == "b").expect("a body").1.orientation;
    let beside = from(lock + 1e-6);
    // Three seconds amplify an angle of 1e-6 rad some ten times.
    for angle in [lock, lock + 1e-11, lock - 1e-12] {
        let end = from(angle);
        let off =
            turned(&end).into_iter().zip(turned(&beside)).map(|(own, other)| (own - other).abs()).fold(0.0, f64::max);
        assert!(off < 2e-5, "{angle}: off by {off:e}");
        assert!(end.energy.max_relative_error < 1e-7, "{angle}: {:?}", end.energy);
        assert!(end.warnings.iter().any(|warning| warning.contains("gimbal lock")), "{angle}: {:?}", end.warnings);
    }
    assert!(beside.warnings.is_empty(), "{:?}", beside.warnings);
}

#[test]
fn given_steps_go_on_through_dead_points_of_a_loop_with_held_joints_as_chosen_ones_do() {
    // A crank, a rod that rubs in its knee, and a rocker that comes to rest on its limit: then the knee stops, and the crank and the rod go on as a pendulum.
    let link = |name: &str, at: f64, mass: f64, turning: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='{at} 0 0'/><mass value='{mass}'/>\
             <inertia ixx='{0}' iyy='{turning}' izz='{turning}' ixy='0' ixz='0' iyz='0'/></inertial></link>",
            0.1 * turning
        )
    };
    let hinge = |name: &str, parent: &str, child: &str, at: f64, rest: &str| {
        let kind = if rest.contains("limit") { "revolute" } else { "continuous" };
        format!(
            "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/><origin xyz='{at} 0 0'/>\
             <axis xyz='0 -1 0'/>{rest}</joint>"
        )
    };
    let robot = [
        "<link name='base'/>".to_string(),
        link("a", 0.05365055, 0.2227341, 0.0002137045720891795),
        hinge("crank", "base", "a", 0.0, "<dynamics damping='0.002483921' friction='0'/>"),
        link("b", 0.1549055, 0.55634, 0.004449925162651761),
        hinge("knee", "a", "b", 0.1073011, "<dynamics damping='0' friction='0.01445573'/>"),
        link("c", 0.22900215, 2.373057, 0.041482606299065784),
        hinge(
            "rocker",
            "base",
            "c",
            0.2452202,
            "<limit lower='1.098406730632811' upper='3.419923530632811' effort='1000' velocity='1000'/>\
             <dynamics damping='0.1594881' friction='0.02417648'/>",
        ),
    ];
    let scene = "[[robot]]\nurdf = \"robot.urdf\"\n\
                 positions = { crank = -1.870149, knee = 3.9416409477964947, rocker = 2.763075730632811 }\n\
                 velocities = { crank = -3.422525 }\n[[loop]]\nname = \"closure\"\ntype = \"distance\"\n\
                 a = { link = \"b\", position = [0.309811, 0, 0] }\nb = { link = \"c\", position = [0.32060300999999997, 0, 0] }\n\
                 [[joint]]\nname = \"rocker\"\nrestitution = 0.0\n[simulation]\nduration = 0.5424932\n";
    let file = scene_of("dead_points", &robot.concat(), scene);
    let wanted = report(&file, &[], &[], None, 1e-8);
    let model = Model::load(&file).expect("a model");
    for step in [5e-3, 2e-3, 1e-3] {
        let mut simulation = Simulation::new(&model).fixed(5, step);
        simulation.run().unwrap_or_else(|error| panic!("steps of {step} s: {error}"));
        let found = simulation.finish().expect("a report");
        assert_eq!(found.method.crowd.steps, wanted.method.crowd.steps);
        for name in ["crank", "knee", "rocker"] {
            // The dead points amplify roundings: the tolerance of the other run.
            let off = (joint(&found, name).0 - joint(&wanted, name).0).abs();
            assert!(off <= 1e-8, "steps of {step} s: {name} is {off:e} off");
        }
    }
}

/// A neck of three axes with a head that is a point of mass, 3.67e-6 rad beside a lock; with these more tables.
fn neck(more: &str) -> PathBuf {
    let link = |name: &str, at: &str, mass: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='{at}'/><mass value='{mass}'/><inertia ixx='0' iyy='0' izz='0' ixy='0' ixz='0' iyz='0'/>\
             </inertial></link>"
        )
    };
    let joint = |name: &str, [parent, child]: [&str; 2], at: &str, axis: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/><origin xyz='{at}'/>\
             <axis xyz='{axis}'/><limit lower='-0.7' upper='0.7' effort='0' velocity='0'/><dynamics damping='1'/></joint>"
        )
    };
    let robot = [
        "<link name='base'/>".to_string(),
        link("first", "0 0 0", 0.1),
        link("second", "0 0 0", 0.1),
        link("head", "0.0185 0 0.11", 1.34),
        joint("pitch", ["base", "first"], "0 0 1", "0 1 0"),
        joint("roll", ["first", "second"], "0.0095 0 0", "1 0 0"),
        joint("yaw", ["second", "head"], "0 0 0", "0 0 1"),
    ];
    scene_of(
        "singular_places_neck",
        &robot.concat(),
        &format!("[[robot]]\nurdf = \"robot.urdf\"\npositions = {{ pitch = 0.3, yaw = 3.67e-6 }}\n{more}"),
    )
}

#[test]
fn dampers_that_move_next_to_no_inertia_get_rotors_and_the_motion_is_that_of_smaller_ones() {
    let armature = |value: f64| {
        ["roll", "yaw"].map(|joint| format!("[[joint]]\nname = \"{joint}\"\narmature = {value}\n")).concat()
    };
    let run = |more: &str| report(&neck(more), &[], &[], Some(1.0), 1e-6);
    let smaller = run(&armature(1e-7));
    let ended = run("");
    let warned = ended.warnings.iter().find(|warning| warning.contains("rotors")).expect("a warning");
    assert!(
        ["\"roll\" 1e-5 kg m²", "\"yaw\" 1e-5 kg m²", "armature"].iter().all(|part| warned.contains(part)),
        "{warned}"
    );
    assert!(
        !warned.contains("pitch") && !smaller.warnings.iter().any(|warning| warning.contains("rotors")),
        "{warned}"
    );
    let off = apart(&ended, &smaller);
    println!("{} steps, {off:e} m from rotors of 1e-7 kg m²", ended.steps);
    // 1e-5 s at up to 1 m/s. It was 62 000 steps for 0.05 s before.
    assert!(off <= 1e-5 && ended.steps <= 2000, "{off:e} m in {} steps", ended.steps);
    assert!(ended.accuracy.as_ref().is_some_and(|accuracy| accuracy.reached));
}

#[test]
fn points_of_mass_without_dampers_on_single_axes_get_no_rotors() {
    let robot = "<link name='base'/><link name='bob'><inertial><origin xyz='0 0 -0.4'/><mass value='2'/>\
                 <inertia ixx='0' iyy='0' izz='0' ixy='0' ixz='0' iyz='0'/></inertial></link>\
                 <joint name='hinge' type='revolute'><parent link='base'/><child link='bob'/><axis xyz='0 1 0'/>\
                 <limit lower='-3' upper='3' effort='0' velocity='0'/><dynamics damping='DAMPING'/></joint>";
    for damping in ["0", "0.1", "1e4"] {
        let file =
            scene_of("singular_places_bob", &robot.replace("DAMPING", damping), "[[robot]]\nurdf = \"robot.urdf\"\n");
        let ended = report(&file, &[("hinge", 1.0)], &[], Some(0.2), 1e-6);
        // 0.32 kg m² decay in 3e-5 s at least.
        assert!(!ended.warnings.iter().any(|warning| warning.contains("rotors")), "{damping}: {:?}", ended.warnings);
    }
}
