//! Contacts between bodies that are moved in time and what they carry: when they press no more.

use crate::scene_files::{apart, joint, report, scene_of};
use catena::report::Report;

fn releases(report: &Report) -> usize {
    report.events.list.iter().filter(|event| event.kind == "release").count()
}

#[test]
fn a_follower_leaves_its_cam_whatever_the_friction() {
    // The follower is guided along z, so that friction is across its motion and changes none of it.
    let urdf = "<link name='base'/><link name='disc'><inertial><origin xyz='0.02 0 0'/><mass value='1'/>\
        <inertia ixx='0.001' iyy='0.001' izz='0.001' ixy='0' ixz='0' iyz='0'/></inertial>\
        <collision><origin xyz='0.02 0 0' rpy='1.5707963267948966 0 0'/><geometry><cylinder radius='0.06' length='0.03'/></geometry></collision></link>\
        <link name='follower'><inertial><mass value='0.6'/><inertia ixx='0.001' iyy='0.001' izz='0.001' ixy='0' ixz='0' iyz='0'/></inertial>\
        <collision><geometry><box size='0.2 0.04 0.02'/></geometry></collision></link>\
        <joint name='turn' type='continuous'><parent link='base'/><child link='disc'/><origin xyz='0 0 0.3'/><axis xyz='0 1 0'/></joint>\
        <joint name='lift' type='prismatic'><parent link='base'/><child link='follower'/><origin xyz='0 0 0.4'/><axis xyz='0 0 1'/>\
        <limit lower='-1' upper='1' effort='9' velocity='9'/><dynamics damping='1'/></joint>";
    let text = |friction: f64| {
        format!(
            "[[robot]]\nurdf = \"robot.urdf\"\npositions = {{ lift = 0.02 }}\n\
             [[motion]]\njoint = \"turn\"\nposition = {{ formula = \"w*t\", w = 38 }}\n[[spring]]\njoint = \"lift\"\nstiffness = 110\nrest = -0.05\n\
             [contact]\npairs = \"all\"\nself_contact = true\nfriction = {friction}\nrestitution = 0.0\n"
        )
    };
    let run = |friction: f64, tolerance: f64| {
        let file = scene_of(&format!("cam_{friction}_{tolerance:e}"), urdf, &text(friction));
        report(&file, &[], &[], Some(0.6), tolerance)
    };
    let smooth = run(0.0, 1e-9);
    let (wanted, _) = joint(&smooth, "lift");
    assert!(releases(&smooth) >= 3, "it leaves in every turn: {:?}", smooth.events.counts);
    for (friction, tolerance) in [(0.02, 1e-6), (0.3, 1e-3), (0.3, 1e-6)] {
        let rubs = run(friction, tolerance);
        assert_eq!(releases(&rubs), releases(&smooth), "friction {friction}, tolerance {tolerance}");
        let (lift, _) = joint(&rubs, "lift");
        assert!(
            (lift - wanted).abs() < tolerance,
            "{lift} instead of {wanted} with friction {friction}, tolerance {tolerance}"
        );
    }
}

#[test]
fn a_box_leaves_a_vibrating_table_at_any_tolerance() {
    // The amplitude grows, and its acceleration is beyond that of gravity for a fifth of a period.
    let urdf = "<link name='base'/><link name='table'><inertial><mass value='5'/><inertia ixx='0.1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'/></inertial>\
        <collision><geometry><box size='1 1 0.05'/></geometry></collision></link>\
        <joint name='z' type='prismatic'><parent link='base'/><child link='table'/><origin xyz='0 0 0.5'/><axis xyz='0 0 1'/>\
        <limit lower='-1' upper='1' effort='9' velocity='9'/></joint>";
    for (amplitude, frequency) in [(0.05, 3.0), (0.012, 6.0)] {
        let text = format!(
            "[[robot]]\nurdf = \"robot.urdf\"\n[[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.1, 0.1, 0.1] }}\nmass = 1\n\
             pose.position = [0.2, 0, 0.575]\n[[motion]]\njoint = \"z\"\n\
             position = {{ formula = \"a*sin(2*pi*f*t)*t/(1+t)\", a = {amplitude}, f = {frequency} }}\n"
        );
        let file = scene_of(&format!("table_{frequency}"), urdf, &text);
        let [coarse, fine] = [1e-3, 1e-8].map(|tolerance| report(&file, &[], &[], Some(2.6), tolerance));
        let off = apart(&coarse, &fine);
        assert!(off < 1e-3, "{off} m at {frequency} Hz");
    }
}
