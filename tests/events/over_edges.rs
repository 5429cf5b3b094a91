//! Errors are estimated at edges, for a cylinder that rolls off a box, where its line of contact becomes the edge, and in steps of first order, for boxes
//! that tumble over each other. A ball that rolls over an edge keeps its contact, however large it is.

use crate::common::scratch;
use crate::runge_kutta::after;
use crate::scene_files::{apart, report};
use crate::tipping::OverEdge;

#[test]
fn a_can_that_rolls_over_an_edge_is_within_its_estimated_error() {
    let text = "[[body]]\nname = \"can\"\nshape = { type = \"cylinder\", radius = 0.05, length = 0.2 }\nmass = 1\nfriction = 3\n\
                pose = { position = [0, 0, 0.05], rpy = [\"90 deg\", 0, 0] }\nvelocity = { linear = [0.3, 0, 0], angular = [0, 6, 0] }\n\
                [[obstacle]]\nname = \"table\"\nfriction = 3\nshape = { type = \"box\", size = [1, 1, 0.5] }\n\
                pose = { position = [-0.3, 0, -0.25] }\n";
    let file = scratch("over_an_edge").join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-11] {
        let end = report(&file, &[], &[], Some(1.0), tolerance);
        let accuracy = end.accuracy.expect("an accuracy");
        // From the closed form until it tips, and an integration of its own of the pendulum about the edge and the slip that follows (±4e-13 m).
        let off = (end.links[0].1.position[0] - 0.320_107_740_462_5).abs();
        let told = if accuracy.reached { tolerance } else { accuracy.estimated };
        assert!(off <= told.max(1e-12), "{tolerance:e}: off by {off:e}, told {:e}", accuracy.estimated);
        // Estimates are orders of magnitude. A run that steps over the edge has an error of first order.
        assert!(
            off <= 3.0 * accuracy.estimated.max(1e-12),
            "{tolerance:e}: {off:e}, estimated {:e}",
            accuracy.estimated
        );
    }
}

#[test]
fn a_ball_that_rolls_over_an_edge_keeps_its_contact_at_every_size_and_tolerance() {
    for (size, tolerance) in [(1.0, 1e-3), (1.0, 1e-6), (1.0, 1e-8), (1e-3, 1e-6), (1e-3, 1e-8), (1e3, 1e-6)] {
        let (radius, speed) = (0.1 * size, 0.3 * f64::sqrt(size));
        let (over, rest) = (0.1 * size / speed, 0.08 * f64::sqrt(size));
        let text = format!(
            "[[obstacle]]\nname = \"table\"\nshape = {{ type = \"box\", size = [{}, {size}, {}] }}\n\
             pose = {{ position = [-{size}, 0, -{}] }}\nfriction = 1\n[[body]]\nname = \"ball\"\nmass = 1\nrestitution = 0.5\n\
             shape = {{ type = \"sphere\", radius = {radius} }}\npose = {{ position = [-{}, 0, {radius}] }}\n\
             velocity = {{ linear = [{speed}, 0, 0], angular = [0, {}, 0] }}\n",
            2.0 * size,
            0.5 * size,
            0.25 * size,
            0.1 * size,
            speed / radius
        );
        let file = scratch("ball_over_an_edge").join("scene.toml");
        std::fs::write(&file, text).expect("a scene");
        let end = report(&file, &[], &[], Some(over + rest), tolerance * size);
        let kinds: Vec<&str> = end.events.list.iter().map(|event| event.kind.as_ref()).collect();
        assert!(kinds.is_empty(), "size {size} at {tolerance:e}: {kinds:?}");
        // It falls about the edge by φ'' = 5/7 g/r sin φ.
        let slope = |&[angle, rate]: &[f64; 2]| [rate, 5.0 / 7.0 * 9.81 / radius * angle.sin()];
        let [angle, _] = after(slope, [0.0, speed / radius], rest, 2000);
        let at = end.links[0].1.position;
        let off = (at[0] - radius * angle.sin()).hypot(at[2] - radius * angle.cos()) / size;
        // Runge and Kutta's own error is some 1e-13 radius.
        assert!(off <= (1e-3 * tolerance).max(2e-13), "size {size} at {tolerance:e}: {off:e} of it off");
    }
}

#[test]
fn boxes_that_tumble_over_each_other_in_steps_over_events_tell_that_their_end_is_not_known() {
    let mut text = "[[obstacle]]\nname = \"floor\"\nfriction = 0.5\nshape = { type = \"half_space\" }\n".to_owned();
    for (number, [x, y, z, roll, pitch]) in [
        [-0.010, 0.002, 0.2, 0.370, 0.604],
        [0.195, 0.0066, 0.2, 0.014, 0.838],
        [0.0104, 0.1898, 0.2, 0.234, 0.973],
        [0.2033, 0.2101, 0.2, 0.503, 0.119],
        [-0.0059, -0.0133, 0.45, 0.830, 0.421],
        [0.1864, -0.0142, 0.45, 0.287, 0.696],
        [0.0069, 0.2064, 0.45, 0.645, 0.350],
        [0.2127, 0.1812, 0.45, 0.871, 0.112],
    ]
    .into_iter()
    .enumerate()
    {
        text += &format!(
            "[[body]]\nname = \"b{number}\"\nshape = {{ type = \"box\", size = [0.1, 0.1, 0.1] }}\nmass = 1\nfriction = 0.5\n\
             pose = {{ position = [{x}, {y}, {z}], rpy = [{roll}, {pitch}, 0.2] }}\n"
        );
    }
    let file = scratch("tumbling_boxes").join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    let [coarse, fine] = [1e-3, 2e-4].map(|tolerance| report(&file, &[], &[], Some(1.5), tolerance));
    let off = apart(&coarse, &fine);
    let told = coarse.accuracy.expect("an accuracy");
    assert!(coarse.method.crowd.time_share * coarse.duration > 0.3, "the scene shows nothing any more");
    assert!(off > 1e-3 && !told.reached, "{off:e} apart, told {:e}", told.estimated);
    assert!(told.estimated > off / 3.0, "{off:e} apart, told {:e}", told.estimated);
    assert!(told.holds_until < 0.5, "{}", told.holds_until);
}

#[test]
fn a_box_that_comes_down_on_the_edge_of_a_table_and_then_flat_overlaps_by_roundings() {
    // Edge across edge twice, with the centre of mass over the table: the face that both edges of the box have comes down next.
    let tilts = [
        (-0.0804, 0.0643, 0.0624, 0.4252),
        (-0.069, 0.0437, 0.0811, 0.0641),
        (-0.09, -0.05, 0.07, 0.3),
        (-0.06, 0.02, 0.05, 0.6),
    ];
    for (x, roll, pitch, friction) in tilts {
        let text = format!(
            "[[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.3, 0.2, 0.1] }}\nmass = 1\n\
             pose = {{ position = [{x}, 0, 1.3], rpy = [{roll}, {pitch}, 0] }}\n[[obstacle]]\nname = \"table\"\n\
             shape = {{ type = \"box\", size = [1, 1, 1] }}\npose = {{ position = [-0.5, 0, 0.5] }}\n[[obstacle]]\nname = \"floor\"\n\
             shape = {{ type = \"half_space\" }}\n[contact]\nfriction = {friction}\nrestitution = 0\n"
        );
        let file = scratch("box_on_an_edge").join("scene.toml");
        std::fs::write(&file, text).expect("a scene");
        for tolerance in [1e-4, 1e-7] {
            let end = report(&file, &[], &[], Some(0.5), tolerance);
            // Shapes never overlap by more than roundings of a metre.
            let overlap = end.contact.max_penetration;
            assert!(overlap <= 1e-12, "{x} at {tolerance:e}: {overlap:e} m");
        }
    }
}

/// The scene of a box that slides over the edge of a table.
fn slides_off(over: &OverEdge) -> String {
    let OverEdge { size: [length, depth, height], friction, speed, from } = over;
    format!(
        "[contact]\nfriction = {friction}\n[[body]]\nname = \"box\"\nmass = 1.4\n\
         shape = {{ type = \"box\", size = [{length}, {depth}, {height}] }}\npose = {{ position = [{from}, 0, {}] }}\n\
         velocity = {{ linear = [{speed}, 0, 0] }}\n[[obstacle]]\nname = \"table\"\n\
         shape = {{ type = \"box\", size = [1, 1, 0.05] }}\npose = {{ position = [-0.5, 0, -0.025] }}\n",
        height / 2.0
    )
}

#[test]
fn boxes_that_slide_over_an_edge_begin_to_tip_where_their_moment_about_it_ends() {
    for (over, tolerances) in [
        (OverEdge { size: [0.295, 0.158, 0.1448], friction: 0.1341, speed: 1.1616, from: -0.2 }, [1e-6, 1e-9]),
        (OverEdge { size: [0.171, 0.12, 0.0608], friction: 0.0936, speed: 1.9666, from: -0.2 }, [1e-6, 1e-8]),
        (OverEdge { size: [0.2923, 0.1945, 0.0698], friction: 0.102, speed: 1.6611, from: -0.2 }, [1e-6, 1e-10]),
        (OverEdge { size: [0.2805, 0.1555, 0.084], friction: 0.1, speed: 1.11, from: -0.2 }, [1e-6, 1e-8]),
        (OverEdge { size: [0.25, 0.2, 0.1], friction: 0.17, speed: 1.4, from: -0.22 }, [1e-7, 1e-10]),
    ] {
        let file = scratch("box_over_an_edge").join("scene.toml");
        std::fs::write(&file, slides_off(&over)).expect("a scene");
        let [x, z] = over.place();
        for tolerance in tolerances {
            let end = report(&file, &[], &[], Some(over.tips() + over.rest()), tolerance);
            let at = end.links[0].1.position;
            let off = (at[0] - x).hypot(at[2] - z);
            // 3e-7 to 3e-6 m where the contacts behind parted up to 0.7 ms late, at 1e-8 m, too; the rest is Runge and Kutta's.
            assert!(off <= (0.1 * tolerance).max(5e-11), "{:?} at {tolerance:e}: {off:e} m off", over.size);
        }
    }
}

#[test]
fn a_chain_that_folds_onto_itself_and_sticks_there_ends_its_run() {
    // It moves in a plane. Nothing but roundings answers to the tangent across it of a contact between its links.
    let (arm, half) = (0.102_728_961_977_603_34, 0.051_364_480_988_801_67);
    let link = |number: usize| {
        format!(
            "<link name='l{number}'><inertial><origin xyz='{half} 0 0'/><mass value='0.1'/>\
             <inertia ixx='1e-05' iyy='0.0001' izz='0.0001' ixy='0' ixz='0' iyz='0'/></inertial>\
             <collision><origin xyz='{half} 0 0' rpy='0 1.5707963267948966 0'/>\
             <geometry><capsule radius='0.01' length='0.08072896197760333'/></geometry></collision></link>"
        )
    };
    let joint = |number: usize| {
        format!(
            "<joint name='j{number}' type='continuous'><parent link='l{}'/><child link='l{number}'/>\
             <origin xyz='{arm} 0 0'/><axis xyz='0 1 0'/></joint>",
            number - 1
        )
    };
    let parts: String = (0..4).map(link).chain((1..4).map(joint)).collect();
    let folder = scratch("folding_chain");
    std::fs::write(folder.join("chain.urdf"), format!("<robot name='chain'>{parts}</robot>")).expect("a robot");
    let text = "[[robot]]\nname = \"ch\"\nurdf = \"chain.urdf\"\nbase = \"floating\"\n\
                pose = { position = [-0.1537932089336736, 0.0, 0.5167782997836649] }\n\
                [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\", normal = [0, 0, 1] }\n\
                friction = 0.5700090830679909\nrestitution = 0.35886235256200005\n\
                [[obstacle]]\nname = \"drum\"\nshape = { type = \"cylinder\", radius = 0.1, length = 0.6 }\n\
                pose = { position = [0, 0, 0.4], rpy = [1.5707963267948966, 0, 0] }\n\
                friction = 0.5700090830679909\nrestitution = 0.35886235256200005\n";
    let file = folder.join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    for tolerance in [1e-3, 1e-4, 1e-5] {
        let end = report(&file, &[], &[], Some(1.2), tolerance);
        // In the plane, above the floor.
        for (name, pose) in &end.links {
            assert!(pose.position[1].abs() < 1e-9 && pose.position[2] > 0.0, "{tolerance:e}, {name}: {pose:?}");
        }
    }
}
