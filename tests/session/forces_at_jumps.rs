//! Contact forces at the instant at which the target of a motor jumps.

use crate::folder;
use catena::mechanism::motion::contact_point::ContactPoint;
use catena::session::{Model, Simulation};
use catena::simulation::{Observer, ObserverError, Sample};
use std::sync::{Arc, Mutex};

/// The forces of contacts at samples, with their times.
#[derive(Default)]
struct Forces {
    points: Vec<ContactPoint>,
    seen: Arc<Mutex<Vec<(f64, f64)>>>,
}

impl Observer for Forces {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let pressure = self.points.iter().map(|point| point.force.z).sum();
        self.seen.lock().expect("one thread at a time").push((sample.time, pressure));
        Ok(())
    }

    fn contacts(&mut self, points: &[ContactPoint]) {
        self.points = points.to_vec();
    }
}

#[test]
fn a_contact_presses_with_the_effort_after_a_jump_of_a_target_where_a_joint_leaves_its_limit_there() {
    let folder = folder("forces_at_jumps");
    let link = |name: &str, collision: &str| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"1\"/><inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>\
             </inertial>{collision}</link>"
        )
    };
    let slide = |name: &str, parent: &str, child: &str, upper: f64| {
        format!(
            "<joint name=\"{name}\" type=\"prismatic\"><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"0 0 1\"/>\
             <limit lower=\"-1\" upper=\"{upper}\" effort=\"1000\" velocity=\"100\"/></joint>"
        )
    };
    let ball = "<collision><geometry><sphere radius=\"0.1\"/></geometry></collision>";
    let urdf = [
        "<robot name=\"press\"><link name=\"base\"/>".to_string(),
        link("carriage", ""),
        link("foot", ball),
        slide("rail", "base", "carriage", 1.0),
        slide("leg", "carriage", "foot", 0.0),
        "</robot>".to_string(),
    ];
    std::fs::write(folder.join("press.urdf"), urdf.concat()).expect("a file");
    // Until 0.1 s the motor pulls the foot against its upper limit, then it pushes the carriage up from it.
    let scene = "[scene]\ngravity = [0, 0, -10]\n[[robot]]\nname = \"press\"\nurdf = \"press.urdf\"\npositions = { rail = 0.1 }\n\
        [[motor]]\njoint = \"leg\"\nkind = \"effort\"\ntarget = [[0, 500], [0.1, -15]]\ninterpolation = \"hold\"\n\
        [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n";
    std::fs::write(folder.join("press.toml"), scene).expect("a file");
    let model = Model::load(folder.join("press.toml")).expect("a scene");
    let forces = Forces::default();
    let seen = forces.seen.clone();
    let mut simulation = Simulation::new(&model).fixed(5, 0.02).duration(0.2).rate(100.0).observe(forces);
    simulation.run().expect("a run");
    let report = simulation.finish().expect("a report");
    // Forces are sums of numbers up to 500 N, with roundings of 1e-13 N.
    assert!(report.contact.max_cone_violation < 1e-10, "{:?}", report.contact);
    for &(time, pressure) in seen.lock().expect("the run has ended").iter() {
        // The floor carries both links; then the weight of the foot and the push of the motor.
        let right = if time < 0.0999 { 20.0 } else { 25.0 };
        assert!((pressure - right).abs() < 1e-9, "{pressure} N at {time} s, right {right} N");
    }
}
