//! A cylinder that rolls off the edge of a box: its line of contact becomes the edge, in a step of first order where no other can be made.

use crate::common::scratch;
use crate::scene_files::report;

#[test]
fn a_step_of_first_order_at_an_edge_is_in_the_estimated_error() {
    let text = "[[body]]\nname = \"can\"\nshape = { type = \"cylinder\", radius = 0.05, length = 0.2 }\nmass = 1\nfriction = 3\n\
                pose = { position = [0, 0, 0.05], rpy = [\"90 deg\", 0, 0] }\nvelocity = { linear = [0.3, 0, 0], angular = [0, 6, 0] }\n\
                [[obstacle]]\nname = \"table\"\nfriction = 3\nshape = { type = \"box\", size = [1, 1, 0.5] }\n\
                pose = { position = [-0.3, 0, -0.25] }\n";
    let file = scratch("over_an_edge").join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    let mut steps = 0;
    for tolerance in [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-11] {
        let end = report(&file, &[], &[], Some(1.0), tolerance);
        let accuracy = end.accuracy.expect("an accuracy");
        // From the closed form until it tips, and an integration of its own of the pendulum about the edge and the slip that follows (±4e-13 m).
        let off = (end.links[0].1.position[0] - 0.320_107_740_462_5).abs();
        let told = if accuracy.reached { tolerance } else { accuracy.estimated };
        assert!(off <= told.max(1e-12), "{tolerance:e}: off by {off:e}, told {:e}", accuracy.estimated);
        steps += end.method.first_order_steps;
    }
    assert!(steps > 0, "the scene shows nothing any more");
}
