//! A body on three sprung legs: a foot begins to slide at the instant at which another foot stops.
//!
//! ```text
//!     |F_T| ≤ μ F_N      at every foot that sticks, also where the event leaves a residual of 1e-11 m/s in the slip that begins
//! ```
//!
//! The residual is along the line between both feet, whose distance the legs hardly change.

use crate::scene_files::{report, scene_of};

/// Legs: mass (kg), radius of the foot (m), place on the body (m), friction (N) and damping [N s/m] of its slide, stiffness of its spring [N/m].
type Leg = (f64, f64, [f64; 2], f64, f64, f64);

const LEGS: [Leg; 3] = [
    (
        0.05541375079567763,
        0.027492647558910753,
        [0.11464037869507271, 0.023641616532907164],
        1.7080990630538844,
        8.024209628659042,
        266.31564533816373,
    ),
    (
        0.2239059787246485,
        0.013100005097313334,
        [-0.08803155010357801, 0.05436684523314732],
        0.0,
        9.849849877499476,
        696.9657402938802,
    ),
    (
        0.09089704058055924,
        0.017898212945513393,
        [-0.02660882859149475, -0.07800846176605446],
        0.0,
        2.99345063499738,
        604.9692952536967,
    ),
];

#[test]
fn feet_that_stick_stay_in_their_cones_where_another_begins_to_slide_beside_a_stop() {
    let mut robot = String::from(
        "<link name='body'><inertial><origin xyz='-0.006076817982560181 0.004860361535227176 0'/><mass value='1.3762953018460982'/>\
         <inertia ixx='0.03' iyy='0.03' izz='0.03' ixy='0' ixz='0' iyz='0'/></inertial>\
         <collision><geometry><box size='0.3 0.2 0.05'/></geometry></collision></link>",
    );
    let mut text = String::from(
        "[scene]\ngravity = [4.208088588689982, 8.197426327589211, -3.366049915477247]\n\
         [[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\", normal = [0.0, 0.0, 1.0] }\nfriction = 0.553533471103492\nrestitution = 0.3\n\
         pose = { position = [0.0, 0.0, 0.0], rpy = [-1.2205319627586555, 0.011266325180390887, 2.6714437811982212] }\n\
         [[robot]]\nurdf = \"robot.urdf\"\nbase = \"floating\"\n\
         pose = { position = [-0.16363633299066369, -0.3187662892395074, 0.13089269705790627], rpy = [-1.4225672386462413, 0.13862908239260374, 2.792904948484729] }\n\
         velocity = { linear = [0.015726267840661324, -0.16325198074259822, -0.1393568247881284], angular = [0.5386219680049477, -0.8172727448902376, -0.3028933072771301] }\n",
    );
    for (leg, (mass, radius, [x, y], friction, damping, stiffness)) in LEGS.iter().enumerate() {
        robot += &format!(
            "<link name='l{leg}'><inertial><origin xyz='0 0 -0.1'/><mass value='{mass}'/>\
             <inertia ixx='0.0005' iyy='0.0005' izz='0.0005' ixy='0' ixz='0' iyz='0'/></inertial>\
             <collision><origin xyz='0 0 -0.2'/><geometry><sphere radius='{radius}'/></geometry></collision></link>\
             <joint name='p{leg}' type='prismatic'><parent link='body'/><child link='l{leg}'/><origin xyz='{x} {y} 0'/><axis xyz='0 0 1'/>\
             <limit lower='-0.05' upper='0.15' effort='100' velocity='100'/><dynamics friction='{friction}' damping='{damping}'/></joint>"
        );
        text += &format!("[[spring]]\njoint = \"p{leg}\"\nstiffness = {stiffness}\nrest = 0.0\n");
    }
    let file = scene_of("slips_beside_stops", &robot, &text);
    for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
        let found = report(&file, &[], &[], Some(1.0), tolerance);
        // The largest force is 24 N, and forces are solved to some 1e-12 of it.
        let outside = found.contact.max_cone_violation;
        assert!(outside < 1e-9, "{tolerance:e}: {outside:e} N outside a cone");
    }
}
