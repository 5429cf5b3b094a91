//! Derivatives of floating and ball joints are those of q and v as results have them: at the origin of the link, about the axes of the parent.

use crate::folder;
use crate::sensitivity_events::derivatives;
use catena::prelude::*;
use catena::session::{Backward, Lost, Samples, Sensitivity};
use nalgebra::{DVector, Quaternion, UnitQuaternion};

/// A link with this centre of mass, and these moments xx, yy, zz and xy of 2 kg.
fn link(at: [f64; 3], [xx, yy, zz, xy]: [f64; 4]) -> String {
    let [x, y, z] = at;
    format!(
        "<link name='link'><inertial><origin xyz='{x} {y} {z}'/><mass value='2'/>\
         <inertia ixx='{xx}' iyy='{yy}' izz='{zz}' ixy='{xy}' ixz='0' iyz='0'/></inertial>\
         <collision><origin xyz='0.2 0 -0.05'/><geometry><sphere radius='0.03'/></geometry></collision></link>"
    )
}

/// The link afloat, or on a ball joint; a scene adds what follows.
fn scene_of(name: &str, link: &str, on_ball: bool, rest: &str) -> Model {
    let joint = if on_ball {
        "<link name='world_link'/><joint name='ball' type='spherical'><origin xyz='0 0 1' rpy='0.4 -0.2 0.9'/>\
         <parent link='world_link'/><child link='link'/></joint>"
    } else {
        ""
    };
    let write = |name: &str, text: &str| {
        let path = folder("frames").join(name);
        std::fs::write(&path, text).expect("a file");
        path
    };
    let urdf = write(&format!("{name}.urdf"), &format!("<robot name='one'>{link}{joint}</robot>"));
    let base =
        if on_ball { "" } else { "base = \"floating\"\npose = { position = [0, 0, 0.3], rpy = [0.2, 0.1, -0.5] }" };
    let text = format!("[[robot]]\nname = \"one\"\nurdf = {urdf:?}\n{base}\n{rest}");
    Model::load(write(&format!("{name}.toml"), &text)).expect("a model")
}

/// The quaternion of q.
fn turn_of(q: &[f64]) -> UnitQuaternion<f64> {
    let wxyz = &q[q.len() - 4..];
    UnitQuaternion::from_quaternion(Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3]))
}

/// q moved by a slight motion along v.
fn moved(q: &[f64], motion: &[f64]) -> Vec<f64> {
    let (mut moved, slides) = (q.to_vec(), q.len() - 4);
    moved.iter_mut().zip(&motion[..slides]).for_each(|(place, by)| *place += by);
    let by = nalgebra::Vector3::from_column_slice(&motion[slides..]);
    let turned = UnitQuaternion::from_scaled_axis(by) * turn_of(q);
    moved[slides..].copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
    moved
}

/// The motion along v from one q to another.
fn between(from: &[f64], to: &[f64]) -> Vec<f64> {
    let slides = from.len() - 4;
    let turn = (turn_of(to) * turn_of(from).inverse()).scaled_axis();
    to[..slides].iter().zip(from).map(|(to, from)| to - from).chain(turn.iter().copied()).collect()
}

/// A run of these stages, step and length (s).
type Made = (usize, f64, f64);

/// q and v at the end of a run, from q and v and under efforts.
fn ended(model: &Model, [q, v, efforts]: [&[f64]; 3], (stages, step, time): Made) -> (Vec<f64>, Vec<f64>) {
    let mut run = Simulation::new(model).fixed(stages, step).without_figures().duration(time);
    run = run.start_from(q, v).expect("a start");
    run.set_efforts(efforts).expect("efforts");
    run.run().expect("a run");
    run.coordinates().expect("coordinates")
}

/// All derivatives at the end of a run from q and v are the differences of runs of order eight over this width.
fn agrees_with_runs(model: &Model, v: &[f64], keys: &[&str], made: Made, (width, bound): (f64, f64)) -> Sensitivity {
    let (q, _) = model.start().expect("a start");
    let run = Simulation::new(model).fixed(made.0, made.1).without_figures().duration(made.2);
    let run = run.start_from(&q, v).expect("a start").sensitivity(keys).expect("derivatives");
    let still = vec![0.0; v.len()];
    let here = ended(model, [&q, v, &still], made);
    for (column, key) in run.keys.iter().enumerate() {
        let freedom = |name: &str| run.freedoms.iter().position(|own| own == name).expect("a freedom");
        let unit = |name: &str, by: f64| -> Vec<f64> {
            let own = freedom(name);
            (0..v.len()).map(|row| if row == own { by } else { 0.0 }).collect()
        };
        let sum = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a + b).collect::<Vec<f64>>();
        let number = model.params().expect("numbers").into_iter().find(|(own, _)| own.ends_with(key.as_str()));
        let at = |by: f64| {
            if let Some(name) = key.strip_prefix("start.q.") {
                ended(model, [&moved(&q, &unit(name, by)), v, &still], made)
            } else if let Some(name) = key.strip_prefix("start.v.") {
                ended(model, [&q, &sum(v, &unit(name, by)), &still], made)
            } else if let Some(name) = key.strip_prefix("effort.") {
                ended(model, [&q, v, &unit(name, by)], made)
            } else {
                let value = number.as_ref().and_then(|(_, value)| *value).expect("a value");
                let model = model.with_params([(key.as_str(), value + by)]).expect("another number");
                ended(&model, [&q, v, &still], made)
            }
        };
        let of = |(q, v): (Vec<f64>, Vec<f64>)| DVector::from_vec([between(&here.0, &q), v].concat());
        let pair = |k: f64| of(at(k * width)) - of(at(-k * width));
        let wanted = (pair(1.0) * 672.0 - pair(2.0) * 168.0 + pair(3.0) * 32.0 - pair(4.0) * 3.0) / (840.0 * width);
        let [dq, dv] = [&run.dq, &run.dv].map(|of| of.last().expect("steps").column(column).into_owned());
        let found = DVector::from_iterator(2 * v.len(), dq.iter().chain(dv.iter()).copied());
        let off = (&found - &wanted).amax() / wanted.amax().max(1.0);
        println!("{key}: off by {off:e}");
        assert!(off < bound, "{key}: {found} and {wanted}");
    }
    run
}

const KEYS: [&str; 11] = [
    "start.q",
    "start.v",
    "link.link.mass",
    "link.link.center_of_mass.x",
    "link.link.center_of_mass.z",
    "link.link.inertia.ixx",
    "link.link.inertia.ixy",
    "link.link.inertia.izz",
    "gravity.z",
    "effort.",
    "link.link.inertia.yaw",
];

/// The keys with all efforts of a joint.
fn keys(joint: &str) -> Vec<String> {
    KEYS.iter().map(|key| if *key == "effort." { format!("effort.{joint}") } else { (*key).to_string() }).collect()
}

fn joint_of(model: &Model) -> String {
    model.joint_names()[0].to_string()
}

#[test]
fn derivatives_of_a_floating_link_are_those_of_the_q_and_v_that_its_runs_report() {
    let model = scene_of("floating", &link([0.03, 0.02, 0.05], [0.03, 0.04, 0.05, 0.004]), false, "");
    let keys = keys(&joint_of(&model));
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    let v = [0.3, -0.2, 0.5, 1.0, 2.0, -3.0];
    // Differences of order eight: moments of inertia of 0.03 vary by a tenth at most, and runs are solved to 1e-14.
    let run = agrees_with_runs(&model, &v, &keys, (8, 0.02, 0.3), (1e-3, 2e-9));
    assert_eq!(run.freedoms.len(), 6);
}

#[test]
fn derivatives_of_a_ball_joint_are_those_of_the_q_and_v_that_its_runs_report() {
    let model = scene_of("ball", &link([0.03, 0.02, -0.15], [0.03, 0.04, 0.05, 0.004]), true, "");
    let keys = keys(&joint_of(&model));
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    agrees_with_runs(&model, &[1.0, 2.0, -3.0], &keys, (8, 0.02, 0.3), (1e-3, 2e-9));
}

#[test]
fn moments_that_are_equal_have_derivatives_although_their_axes_have_none() {
    // The principal axes jump by an eighth of a turn with the least product of inertia.
    for (name, moments) in [("disc", [0.03, 0.03, 0.05, 0.0]), ("ball", [0.03; 4]), ("rod", [0.03, 0.04, 0.05, 0.001])]
    {
        let mut moments = moments;
        moments[3] = if name == "rod" { 0.001 } else { 0.0 };
        let model =
            scene_of(&format!("equal_{name}"), &link([0.0; 3], moments), false, "[scene]\ngravity = [0, 0, 0]\n");
        let keys = ["link.link.inertia.ixy", "link.link.inertia.ixx", "link.link.inertia.yaw"];
        let v = [0.0, 0.0, 0.0, 1.0, 2.0, 3.0];
        let run = agrees_with_runs(&model, &v, &keys, (8, 0.02, 0.5), (1e-4, 1e-8));
        // The start does not depend on the inertia: roundings of 3 rad/s in eight models, over a width of 4e-6.
        assert!(run.dq[0].amax() < 1e-9 && run.dv[0].amax() < 1e-9, "{} {}", run.dq[0], run.dv[0]);
    }
}

#[test]
fn an_impact_of_a_floating_link_has_the_derivatives_of_the_q_and_v_of_its_runs() {
    let floor =
        "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\nfriction = 0.0\nrestitution = 0.4\n";
    let model = scene_of("falls", &link([0.01, 0.02, 0.05], [0.03, 0.04, 0.05, 0.001]), false, floor);
    let keys =
        ["start.q", "link.link.mass", "link.link.center_of_mass.x", "link.link.inertia.ixy", "floor.restitution"];
    let run = agrees_with_runs(&model, &[0.0; 6], &keys, (8, 0.02, 0.26), (1e-4, 1e-8));
    assert_eq!(run.events.len(), 1);
}

#[test]
fn gradients_of_floating_links_are_their_forward_derivatives() {
    let floor =
        "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\nfriction = 0.0\nrestitution = 0.4\n";
    let model = scene_of("back", &link([0.01, 0.02, 0.05], [0.03, 0.04, 0.05, 0.001]), false, floor);
    let keys = ["start.q", "start.v", "link.link.center_of_mass.y", "link.link.inertia.ixy", "floor.restitution"];
    let forward = derivatives(&model, 5, 0.02, 0.26, &keys);
    // All of the start and of the end, with weights that differ.
    let weights = |seed: f64| -> Vec<f64> { (0..6).map(|row| (seed + 1.7 * row as f64).sin()).collect() };
    let loss = |_: &Samples| Lost {
        value: 0.0,
        by_q: vec![weights(1.0), weights(2.0)],
        by_v: vec![weights(3.0), weights(4.0)],
        by_events: vec![catena::session::EventLost { event: 0, time: 0.3, by_q: weights(5.0), by_v: weights(6.0) }],
    };
    let asked = Backward { keys: &keys, times: &[0.0, 0.26], every: 1 };
    let back = Simulation::new(&model).fixed(5, 0.02).duration(0.26).without_figures().gradient(&asked, loss);
    let back = back.expect("a gradient");
    let event = &forward.events[0];
    let ends = [(&forward.dq, 1.0), (&forward.dv, 3.0)].map(|(of, seed)| {
        let (first, last) = (of.first().expect("a start"), of.last().expect("an end"));
        first.tr_mul(&DVector::from_vec(weights(seed))) + last.tr_mul(&DVector::from_vec(weights(seed + 1.0)))
    });
    let of_event =
        event.dq.tr_mul(&DVector::from_vec(weights(5.0))) + event.dv.tr_mul(&DVector::from_vec(weights(6.0)));
    let wanted = &ends[0] + &ends[1] + of_event + DVector::from_vec(event.by.clone()) * 0.3;
    let found = DVector::from_vec(back.by);
    // The same products in another order, over one impact.
    assert!((&found - &wanted).amax() < 1e-11 * wanted.amax(), "{found} {wanted}");
}

#[test]
fn linear_equations_of_floating_and_ball_joints_are_the_derivatives_of_forward_dynamics() {
    let moments = [0.03, 0.04, 0.05, 0.004];
    for (name, on_ball, v, efforts) in [
        ("linear_floating", false, vec![0.3, -0.2, 0.5, 1.0, 2.0, -3.0], vec![0.7, 1.1, -0.4, 0.2, -0.1, 0.3]),
        ("linear_ball", true, vec![1.0, 2.0, -3.0], vec![0.2, -0.1, 0.3]),
    ] {
        let model = scene_of(name, &link([0.03, 0.02, 0.05], moments), on_ball, "");
        let (q, n) = (model.start().expect("a start").0, v.len());
        let linear = model.linearize(&q, &v, &efforts).expect("linear equations");
        let unit =
            |column: usize, by: f64| -> Vec<f64> { (0..n).map(|row| if row == column { by } else { 0.0 }).collect() };
        let sum = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a + b).collect::<Vec<f64>>();
        let difference = |of: &dyn Fn(f64) -> DVector<f64>| {
            let h = 2e-3;
            let pair = |k: f64| of(k * h) - of(-k * h);
            (pair(1.0) * 45.0 - pair(2.0) * 9.0 + pair(3.0)) / (60.0 * h)
        };
        let a = |q: &[f64], v: &[f64], tau: &[f64]| model.forward_dynamics(q, v, tau).expect("accelerations");
        for column in 0..n {
            let found = |row: usize, of: usize| linear.a.view((row, of + column), (n, 1)).into_owned();
            let wanted = [
                difference(&|by| a(&moved(&q, &unit(column, by)), &v, &efforts)),
                difference(&|by| a(&q, &sum(&v, &unit(column, by)), &efforts)),
                difference(&|by| a(&q, &v, &sum(&efforts, &unit(column, by)))),
            ];
            let rows = [found(n, 0), found(n, n), linear.b.view((n, column), (n, 1)).into_owned()];
            for (which, (found, wanted)) in rows.iter().zip(&wanted).enumerate() {
                // Differences of order six over 2e-3 of functions with angles, and roundings over 2e-3.
                assert!(
                    (found - wanted).amax() < 1e-9 * wanted.amax().max(1.0),
                    "{name} {which} {column}: {found} {wanted}"
                );
            }
            // The motion of a moved start along v for a short time: d/dt of the motion that is between.
            let h = 1e-3;
            let apart = |by: f64, time: f64| {
                let go = |q: &[f64]| moved(q, &v.iter().map(|rate| rate * time).collect::<Vec<f64>>());
                DVector::from_vec(between(&go(&q), &go(&moved(&q, &unit(column, by)))))
            };
            let slope = |time: f64| (apart(h, time) - apart(-h, time)) / (2.0 * h);
            let rate = (slope(h) - slope(-h)) / (2.0 * h);
            // Differences of order two, of angles times rates of 3 rad/s.
            assert!((found(0, 0) - &rate).amax() < 1e-4, "{name} {column}: {} {rate}", found(0, 0));
            assert_eq!(found(0, n), DVector::from_vec(unit(column, 1.0)), "{name}: velocities are their own");
        }
        let mass = model.mass_matrix(&q).expect("a mass matrix");
        assert!((&linear.inertia - &mass).amax() < 1e-13, "{name}: {} {mass}", linear.inertia);
    }
}
