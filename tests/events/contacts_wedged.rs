//! A ball that is wedged in below a box until its contact slips: forces grow by 10 kN in half a millisecond, and the slip begins without an acceleration.
//! The scene is seed 388 of `benches/random_scenes.py`.

use crate::loose::{DOWN, cuboid, loose, on_floor, resting, slope};
use crate::mechanisms::{fixed, of_kind, run};
use catena::mechanism::description::contact::Shape;
use catena::mechanism::motion::event::EventKind;
use nalgebra::Vector3;

#[test]
fn a_slip_that_begins_where_forces_grow_steeply_stays_a_slip_and_no_force_leaves_its_cone() {
    let cylinder = Shape::Cylinder { radius: 0.06662376745713584, half: 0.08698834553401476 };
    let ball = Shape::Sphere { radius: 0.14293713189468893 };
    let upright = cuboid(0.14085868880743518, 0.06017568441145023, 0.23160793421452075);
    let mut mechanism =
        loose(DOWN, &[(1.6029505448300339, cylinder), (2.8454817984543976, ball), (0.43677473932916655, upright)]);
    on_floor(&mut mechanism, 0.5, 0.0);
    slope(&mut mechanism, Vector3::new(0.10561121004923893, -0.11602261946047733, 0.9876158281869852));
    let start = resting(
        &mechanism,
        &[
            Vector3::new(-0.024562071886165524, 0.02711560157877621, 0.5969883455340148),
            Vector3::new(-0.02934689366885967, 0.02718456130966082, 0.8279138229627185),
            Vector3::new(0.024758072435227693, -0.002029124826606974, 1.2124588890719283),
        ],
    );
    for step in [2.5e-3, 6e-4] {
        let finished = run(&mechanism, &start, 0.33, fixed(5, step));
        let slips = of_kind(&finished, EventKind::Slip);
        println!("{step}: {} steps, {:?}, slips {slips:?}", finished.summary.steps, finished.summary.contact);
        assert!(slips.iter().any(|slip| (0.3271..0.3272).contains(&slip.time)), "{step}: {slips:?}");
        // 13 kN press, of which 1e-12 N are roundings. 1.3e-9 N is what was left where the slip was taken back, and the contact held on beyond its cone.
        assert!(finished.summary.contact.cone_violation <= 1e-10, "{step}: {:?}", finished.summary.contact);
    }
}
