//! A can under a convex body that slips on its upper end and tips it: each event adds a point of a rim. The scene is seed 79 of
//! `benches/random_scenes.py`.

use crate::loose::{DOWN, loose, on_floor, resting};
use crate::mechanisms::{fixed, run_within};
use catena::mechanism::description::contact::Shape;
use nalgebra::Vector3;
use std::sync::Arc;

#[test]
fn points_of_rims_that_events_have_added_do_not_pile_up() {
    let can = Shape::Cylinder { radius: 0.08875516739889681, half: 0.5 * 0.27545946698537305 };
    let corners = [
        [0.129693651245, 0.094295676544, -0.048784864818],
        [0.019085814739, -0.070063607181, -0.068293535133],
        [0.194028225144, -0.018811262842, 0.034885434805],
        [-0.144561699404, -0.108677460727, -0.039599916256],
        [-0.131358937437, 0.085521967891, 0.050336359402],
        [-0.017928193827, -0.022532280296, 0.072309262144],
        [-0.190211289648, -0.102174257889, -0.009597776540],
        [0.024738621382, -0.080831279696, 0.066562145100],
        [-0.077938222221, -0.191499429887, 0.002423608301],
        [-0.032792381597, 0.064680765790, -0.068406841049],
        [0.140484729468, -0.022068933018, 0.055986260224],
        [-0.007544713668, -0.156862259942, -0.046808520375],
    ];
    let hull = Shape::Hull(Arc::new(corners.map(Vector3::from).to_vec()));
    // The body lands on the can at 0.071 s, clatters, slips and rocks on it.
    for friction in [0.08, 0.11, 0.15] {
        let shapes = [(1.8575340878607336, can.clone()), (0.9413339811987538, hull.clone())];
        let mut mechanism = loose(DOWN, &shapes);
        mechanism.bodies[1].inertia = Vector3::new(0.008886606860979874, 0.010290680705115868, 0.017171138519045788);
        on_floor(&mut mechanism, friction, 0.0);
        let start = resting(
            &mechanism,
            &[
                Vector3::new(0.013044584382648272, -0.01963737156541128, 0.14772973349268653),
                Vector3::new(-0.028998005873337354, 0.01898653237777985, 0.36845221832692066),
            ],
        );
        // A chaotic clatter: 500 to 1200 steps for fourteen frictions between 0.05 and 0.2.
        let finished = run_within(1200, &mechanism, &start, 0.1798, fixed(5, 0.01));
        let (summary, points) = (&finished.summary, finished.contacts.len());
        println!("{friction}: {} steps, {} points, {:?}", summary.steps, points, summary.contact);
        // Four of each of two rims, and those that the loads need.
        assert!((4..=24).contains(&points), "{friction}: {points}");
        assert!(summary.contact.penetration <= 1e-12, "{friction}: {:?}", summary.contact);
        assert!(summary.contact.cone_violation <= 1e-9, "{friction}: {:?}", summary.contact);
    }
}
