//! Pendula and chains of rods that swing in a plane go where the published ones go.

#![allow(clippy::excessive_precision, reason = "reference values stand as their source prints them")]

use super::{Method, assert_close, visit};
use crate::models::{self, ChainAnswer, Model, body, frame, gravity};
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::state::State;
use nalgebra::{Translation3, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// The angle of a link from hanging, in the plane of x and z, compared without whole turns.
fn assert_angle(body: &BodyState, expected: f64, bound: f64, what: &str) {
    let down = body.rotation * Vector3::new(0.0, 0.0, -1.0);
    let difference = down.x.atan2(-down.z) - expected;
    assert_close(difference - TAU * (difference / TAU).round(), 0.0, bound, what);
}

// "A01 planar simple pendulum", IFToMM benchmark library (lim.ii.udc.es/IFToMM): time, x, y and their rates of a point
// of 1 kg on a rod of 1 m without mass, released at (−1, 0). Wanted there: energy errors below 5e-5 J over 10 s.
const SIMPLE_PENDULUM: [(f64, [f64; 4]); 11] = [
    (1.0, [0.98629175113187528, -0.16501085312554117, 0.29690551591631581, 1.7746436411126556]),
    (2.0, [-0.79356619534332173, -0.60848393044379157, -2.1024378744361258, 2.7419353930105093]),
    (3.0, [0.1766517899228382, -0.98427340973789257, 4.3253686745387423, 0.77629255334339975]),
    (4.0, [0.57756362824863139, -0.81634567146783887, -3.2670865745707705, -2.3114600122992459]),
    (5.0, [-0.9423054350437573, -0.3347543384140006, 0.85790425688594907, -2.4149286543704886]),
    (6.0, [0.99949753993935275, -0.031696492789927061, -0.024995758323387511, -0.78820073623678366]),
    (7.0, [-0.99861877917547981, -0.052540782998298716, -0.053345072842738699, 1.0139055506456327]),
    (8.0, [0.91985798310773847, -0.39225156585151255, 1.0881694534505062, 2.5518352146218031]),
    (9.0, [-0.49837370905755896, -0.86696230951536268, -3.5756074003064944, 2.0554396686755001]),
    (9.99, [-0.31643646991303231, -0.94861370457577654, 4.0924519914940207, -1.3651511202403046]),
    (10.0, [-0.27508746257611688, -0.96141920509912504, 4.1755981009517287, -1.1947490545604753]),
];

#[test]
fn the_simple_pendulum_of_iftomm_is_met_to_ten_digits_and_more() {
    let hinge = Joint::new("hinge", JointKind::Revolute, Pose::identity(), Translation3::new(1.0, 0.0, 0.0).into());
    let point = body("point", None, 1.0, Vector3::zeros(), hinge);
    let mechanism = Mechanism::new("simple pendulum", Vector3::new(0.0, -9.81, 0.0), vec![point]).unwrap();
    let state = State::zero(&mechanism);
    let model = Model { mechanism, state };
    let times = SIMPLE_PENDULUM.map(|(time, _)| time);
    // The errors of the comparator's steps, 1e-13, become phase, which grows for ten seconds; speeds reach 4.4 m/s. The largest
    // kinetic energy is 9.81 J, so that energies are hundreds of thousands of times better than the 5e-5 J that are asked for.
    for (method, bound, energy) in [(Method::Scheme(0.05), 1e-11, 1e-13), (Method::Comparator, 1e-10, 1e-12)] {
        let summary = visit(&model, method, &times, |index, bodies| {
            let (time, expected) = SIMPLE_PENDULUM[index];
            let found = [bodies[0].position.x, bodies[0].position.y, bodies[0].velocity.x, bodies[0].velocity.y];
            for (found, expected) in found.into_iter().zip(expected) {
                assert_close(found, expected, bound, &format!("{method:?}, t = {time}"));
            }
        });
        println!("{method:?}: energy {:.1e}", summary.max_relative_energy_error);
        assert!(summary.max_relative_energy_error < energy, "{method:?}: {:.1e}", summary.max_relative_energy_error);
    }
}

/// `n` links of `length` hinged about y in one plane, with the inertia about y that is given, at absolute `angles` from
/// hanging, at rest. The centre of mass is at `centre` below each link's own hinge.
fn planar_chain(name: &str, inertia: f64, length: f64, centre: f64, angles: &[f64]) -> Model {
    let bodies = (0..angles.len()).map(|index| {
        let hinge_on_parent = if index == 0 { 0.0 } else { centre - length };
        let at = |z: f64| frame(Vector3::new(0.0, 0.0, z), Vector3::y());
        let joint = Joint::new(&format!("joint{index}"), JointKind::Revolute, at(hinge_on_parent), at(centre));
        // The inertias about the other axes never act.
        body(&format!("link{index}"), index.checked_sub(1), 1.0, Vector3::new(inertia, inertia, 0.5 * inertia), joint)
    });
    let mechanism = Mechanism::new(name, gravity(), bodies.collect()).unwrap();
    let mut state = State::zero(&mechanism);
    // Turning about y takes "down" to negative x.
    let mut above = 0.0;
    for (position, angle) in state.position.iter_mut().zip(angles) {
        *position = -(angle - above);
        above = *angle;
    }
    Model { mechanism, state }
}

/// The scheme and the comparator, and how far they may be off after ten seconds of motions that magnify an error of the start at
/// most sevenfold: rounding, and the error of the steps of the comparator.
const METHODS: [(Method, f64); 2] = [(Method::Scheme(0.01), 1e-11), (Method::Comparator, 1e-10)];

fn check_chain(model: &Model, tip: f64, answers: &[ChainAnswer]) {
    let times: Vec<f64> = answers.iter().map(|answer| answer.0).collect();
    for (method, bound) in METHODS {
        visit(model, method, &times, |index, bodies| {
            let (time, [x, z, first, last]) = answers[index];
            let what = format!("{}, {method:?}, t = {time}", model.mechanism.name);
            let end = bodies[bodies.len() - 1];
            let found = end.position + end.rotation * Vector3::new(0.0, 0.0, -tip);
            assert_close(found.x, x, bound, &what);
            assert_close(found.z, z, bound, &what);
            assert_angle(&bodies[0], first, bound, &what);
            assert_angle(&end, last, bound, &what);
        });
    }
}

// "Chains and double pendula", model wafr, ConstrainedDynamics.jl as models::PLANAR_CHAIN: the inertia of ConstrainedDynamics' cylinders of radius
// 0.05 m, (r² + h²/6)/2.
const WAFR_CHAIN: [(usize, [ChainAnswer; 3]); 2] = [
    (
        2,
        [
            (1.0, [-1.3015496876503547, -1.5040279925430937, -0.60843709329636153, -0.81826921954582155]),
            (2.0, [0.83406517141010106, -1.7752300615209091, 0.24245028818256115, 0.63600113570152073]),
            (3.0, [0.11532083836514852, -1.9954794058718262, 0.023212575218989926, 0.092241096364453018]),
        ],
    ),
    (
        5,
        [
            (1.0, [-0.21274758555683421, -4.9916142794760505, -0.052692506230200047, 0.018369762931917243]),
            (2.0, [-3.6367457486990138, -3.3937849826224493, -0.68697609761708789, -0.88615108750882643]),
            (3.0, [0.71897703839699123, -4.9444562136688237, 0.10601758393391458, 0.11085636468046317]),
        ],
    ),
];

#[test]
fn planar_chains_are_met_over_ten_seconds() {
    for (count, answers) in models::PLANAR_CHAIN {
        check_chain(&models::planar_chain(count), 0.5, &answers);
    }
    for (count, answers) in WAFR_CHAIN {
        let inertia = 0.5 * (0.05_f64.powi(2) + 1.0 / 6.0);
        let model = planar_chain(&format!("wafr {count}"), inertia, 1.0, 0.5, &vec![FRAC_PI_4; count]);
        check_chain(&model, 0.5, &answers);
    }
}

// Two cubes of 0.1 m and 1 kg, each 1 m below its hinge, the second hinge at the first cube. ConstrainedDynamics.jl,
// WAFR2020_experiments 01energy_1.jl and MSD2023_experiments physical_accuracy/energy_conservation/cd.jl. Time, tip,
// angle and rate of the first link, angle and rate of the last.
const WAFR_CUBES: [(f64, [f64; 6]); 5] = [
    (
        1.0,
        [
            -1.223732773166923,
            -1.5252818805322259,
            -0.88746866741482644,
            2.0623629528679861,
            -0.46481424815937489,
            -6.0827775828495803,
        ],
    ),
    (
        2.0,
        [
            -0.19794280908220221,
            -1.0247145171773817,
            0.83098444681308414,
            0.038464379379879503,
            -1.2126214310887,
            3.7169784725915016,
        ],
    ),
    (
        3.0,
        [
            0.23868449314533785,
            -0.20973639300988076,
            -0.56138521494980587,
            0.93686532625917152,
            2.2611139273950336,
            0.5184715224470019,
        ],
    ),
    (
        5.0,
        [
            -0.086495958818719354,
            -1.3133213755994206,
            -0.91829148198736288,
            2.9816712362131748,
            0.78676050526827424,
            1.0488095031192828,
        ],
    ),
    (
        10.0,
        [
            -0.68677622253027004,
            -0.38578884706413957,
            0.10698658035968588,
            -1.718424016218792,
            -2.2249571803404335,
            0.53242836161356843,
        ],
    ),
];

const MSD_CUBES: [(f64, [f64; 6]); 3] = [
    (
        1.0,
        [
            -1.443437437842372,
            -1.3217088062477336,
            -0.62201205655369918,
            -3.9074459061226143,
            -1.0367724461176429,
            -1.3331716201161972,
        ],
    ),
    (
        2.0,
        [
            -1.4391630727189264,
            -1.1280019315214842,
            -0.48893057195334599,
            3.078677057590554,
            -1.3231051265967753,
            2.9060915598581132,
        ],
    ),
    (
        3.0,
        [
            1.8814511535512848,
            -0.21949903159951137,
            1.7813585906596994,
            0.33615757359091875,
            1.1279545877430526,
            -0.49152239268498116,
        ],
    ),
];

#[test]
fn double_pendula_of_two_cubes_are_met() {
    let inertia = 0.1 * 0.1 / 6.0;
    let start = |name, angles: [f64; 2]| planar_chain(name, inertia, 1.0, 1.0, &angles);
    for (model, answers) in [
        (start("wafr cubes", [FRAC_PI_2, 0.0]), &WAFR_CUBES[..]),
        (start("msd cubes", [FRAC_PI_2, FRAC_PI_2]), &MSD_CUBES[..]),
    ] {
        let times: Vec<f64> = answers.iter().map(|answer| answer.0).collect();
        for (method, bound) in METHODS {
            visit(&model, method, &times, |index, bodies| {
                let (time, [x, z, first, first_rate, last, last_rate]) = answers[index];
                let what = format!("{}, {method:?}, t = {time}", model.mechanism.name);
                assert_close(bodies[1].position.x, x, bound, &what);
                assert_close(bodies[1].position.z, z, bound, &what);
                assert_angle(&bodies[0], first, bound, &what);
                assert_angle(&bodies[1], last, bound, &what);
                assert_close(-bodies[0].angular_velocity.y, first_rate, bound, &what);
                assert_close(-bodies[1].angular_velocity.y, last_rate, bound, &what);
            });
        }
    }
}
