//! Flags of `<option>`, ranges without a flag, and frames of free bodies in keyframes.

use crate::common::command;
use catena::session::Model;

fn start_of(name: &str, text: &str) -> (Model, Vec<f64>, Vec<f64>) {
    let folder = command::folder(name);
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::loader().keyframe("k").load(folder.join("model.xml")).expect("a model");
    let (q, v) = model.start().expect("a start");
    (model, q.to_vec(), v.to_vec())
}

fn is_told(model: &Model, said: &str) -> bool {
    model.warnings().iter().any(|line| line.contains(said))
}

#[test]
fn controls_leave_their_ranges_where_clampctrl_is_disabled() {
    let text = "<mujoco><worldbody><body><joint name='j' axis='0 1 0'/><geom size='.1'/></body></worldbody>
      <actuator><motor joint='j' ctrlrange='-.5 .5'/></actuator><keyframe><key name='k' ctrl='3'/></keyframe></mujoco>";
    let off = text.replace("<worldbody>", "<option><flag clampctrl='disable'/></option><worldbody>");
    for (text, wanted) in [(text, 0.5), (off.as_str(), 3.0)] {
        let (model, q, v) = start_of("mjcf_clampctrl", text);
        assert_eq!(model.description().mechanism.nonsmooth.motors[0].effort(0.0, q[0], v[0]), wanted);
    }
    let damper = off.replace("<motor joint='j' ctrlrange='-.5 .5'/>", "<damper joint='j' kv='2' ctrlrange='0 1'/>");
    let (model, ..) = start_of("mjcf_clampctrl", &damper);
    assert!(is_told(&model, "model.xml:2: the control of a damper stays in its ctrlrange all the same"));
}

#[test]
fn every_flag_is_read_or_told() {
    // All of MuJoCo 4.0.0, each not as by default.
    let off = "constraint equality frictionloss limit contact spring damper gravity clampctrl warmstart filterparent actuation refsafe sensor midphase \
        eulerdamp autoreset nativeccd island multiccd colour";
    let on = "override energy fwdinv invdiscrete sleep diagexact ipc speculative";
    let flags = |names: &str, value: &str| {
        names.split_whitespace().map(|name| format!("{name}='{value}' ")).collect::<String>()
    };
    let text = format!(
        "<mujoco><option><flag {}{}/></option><worldbody><body><joint/><geom size='.1'/></body></worldbody></mujoco>",
        flags(off, "disable"),
        flags(on, "enable")
    );
    let scene = super::read("mjcf_flags", &text).expect("a scene");
    let told: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    let read = ["contact", "gravity", "clampctrl"];
    for name in off.split_whitespace().chain(on.split_whitespace()).filter(|name| !read.contains(name)) {
        let (said, without_effect) = (format!("model.xml:1: {name}"), format!("ignored: {name} of <flag>"));
        assert!(told.iter().any(|line| line.contains(&said) || line.contains(&without_effect)), "{name}: {told:#?}");
    }
    // As by default, they are nothing to tell.
    let plain =
        text.replace("disable", "zz").replace("enable", "disable").replace("zz", "enable").replace("colour", "limit2");
    let told = super::read("mjcf_flags", &plain).expect("a scene").warnings;
    assert_eq!(told.iter().filter(|line| !line.to_string().contains("ignored: ")).count(), 1, "{told:#?}");
}

#[test]
fn ranges_without_a_flag_bound_nothing_where_they_are_empty_and_are_told_where_nothing_infers_limits() {
    let text = "<mujoco><compiler angle='radian'/><worldbody><body><joint name='j' axis='0 1 0' range='0 0' damping='1'/><geom size='.1'/></body></worldbody>
      <actuator><motor joint='j' ctrlrange='0 0'/></actuator><keyframe><key name='k' qvel='1' ctrl='.5'/></keyframe></mujoco>";
    // `jnt_limited` and `actuator_ctrllimited` of MuJoCo 4.0.0 are false.
    let (model, q, v) = start_of("mjcf_ranges", text);
    assert_eq!((q.len(), model.description().mechanism.nonsmooth.limits.len()), (1, 0));
    assert_eq!(model.description().mechanism.nonsmooth.motors[0].effort(0.0, q[0], v[0]), 0.5);
    let text = text.replace("angle='radian'", "angle='radian' autolimits='false'").replace("'0 0'", "'-1 1'");
    let (model, ..) = start_of("mjcf_ranges", &text);
    for said in ["1: range without limited", "2: ctrlrange without ctrllimited"] {
        let said = format!("model.xml:{said} bounds nothing while autolimits=\"false\"");
        assert!(is_told(&model, &said), "{said}: {:#?}", model.warnings());
    }
    // The range of a damper needs no flag.
    let damper = text.replace("<motor joint='j' ctrlrange='-1 1'/>", "<damper joint='j' kv='2' ctrlrange='0 1'/>");
    let (model, q, v) = start_of("mjcf_ranges", &damper);
    let motor = &model.description().mechanism.nonsmooth.motors[0];
    // −kv u q̇ at u = 0.5.
    assert_eq!(motor.effort(0.0, q[0], v[0]), -1.0);
}

#[test]
fn keyframes_of_aligned_free_bodies_are_about_their_inertial_frames() {
    let text = |compiler: &str, joint: &str, body: &str| {
        format!(
            "<mujoco>{compiler}<worldbody><body name='l' pos='9 9 9'>{joint}{body}</body></worldbody>
             <keyframe><key name='k' qpos='.1 .2 .3 .8 .6 0 0' qvel='1 2 3 .4 .5 .6'/></keyframe></mujoco>"
        )
    };
    let tilted = "<geom type='box' size='.1 .2 .3' pos='.1 .2 .05' euler='0 30 40'/>";
    let given = "<inertial mass='2' pos='.1 .2 .3' quat='.6 .8 0 0' diaginertia='.1 .2 .15'/>";
    let (align, free, all) = ("<freejoint align='true'/>", "<freejoint/>", "<compiler alignfree='true'/>");
    // Position and velocity of the origin of the body from MuJoCo 4.0.0; the spin in the world is the same for all.
    let cases = [
        (
            text("", align, tilted),
            [-0.07574780567622727, 0.25775798847752424, 0.16480856696143334],
            [1.0215162882713793, 1.9401919951372313, 2.9464771521161746],
        ),
        (text(all, free, given), [0.0, -0.12992, 0.15456], [1.2772, 1.993376, 2.824432]),
        (text(all, "<freejoint align='false'/>", tilted), [0.1, 0.2, 0.3], [1.0, 2.0, 3.0]),
        // A body with a child stays as it is.
        (text("", align, &format!("{tilted}<body><geom size='.01'/></body>")), [0.1, 0.2, 0.3], [1.0, 2.0, 3.0]),
    ];
    for (number, (text, position, velocity)) in cases.iter().enumerate() {
        let scene = super::read_at("mjcf_align", text, Some("k")).expect("a scene");
        let robot = &scene.robots[0];
        let wanted: Vec<f64> = velocity.iter().chain(&[0.4, -0.436, 0.648]).copied().collect();
        let (own, _) = robot.velocity.expect("a velocity");
        assert!(own.iter().zip(&wanted).all(|(own, wanted)| (own - wanted).abs() < 1e-14), "{number}: {own:?}");
        let at = robot.pose.translation.vector;
        assert!(at.iter().zip(position).all(|(own, wanted)| (own - wanted).abs() < 1e-14), "{number}: {at}");
        assert!(
            scene.warnings.iter().all(|line| !line.to_string().contains("inertial frame")),
            "{:#?}",
            scene.warnings
        );
    }
    let several = text("", align, &format!("{tilted}<geom size='.1' pos='1 0 0'/>"));
    let scene = super::read_at("mjcf_align", &several, Some("k")).expect("a scene");
    let said = "model.xml:2: the keyframe gives the inertial frame of body \"l\", as align or alignfree says; it is read as the frame of the body";
    assert!(scene.warnings.iter().any(|line| line.to_string().contains(said)), "{:#?}", scene.warnings);
    let silent = super::read("mjcf_align", &several).expect("a scene").warnings;
    assert!(silent.iter().all(|line| !line.to_string().contains("inertial frame")), "{silent:#?}");
}
