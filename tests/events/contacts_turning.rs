//! A box that slides and turns on four corners: three corners would carry it, and friction asks how much each of the four does.
//!
//! As between rigid bodies with a foundation of equal springs that are as stiff as one likes the pressures lie on a plane over the place of the corners:
//!
//! ```text
//!     N_i = α + β X_i + γ Y_i,    f_i = −μ N_i u_i/|u_i|,    u_i = v + ω z × r_i
//!     Σ N_i = m g,                Σ r_i × (f_i + N_i z) = (0, 0, J dω/dt)            r_i = (X_i, Y_i, −h), turned by θ
//! ```
//!
//! which is here integrated on its own: α, β, γ from the first three equations, then the classical Runge–Kutta method for (x, y, θ, v, ω). A corner that such
//! a plane would pull is off the springs, and the plane is that of the others.

use crate::contacts::{over_floor, placed};
use crate::exact::near;
use crate::mechanisms::{GRAVITY, fixed, of_kind, run};
use crate::runge_kutta::after;
use crate::scene_files::{apart, report, scene_of};
use crate::turning::OnTable;
use catena::mechanism::description::contact::Shape;
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::state::State;
use catena::simulation::StepChoice;
use nalgebra::{Matrix3, Vector3};

const MASS: f64 = 1.3;
const HALF: [f64; 3] = [0.13, 0.085, 0.06];
const FRICTION: f64 = 0.3;

/// A box that is thrown, its middle so far from its centre of mass, in parts of its half sides.
fn thrown(middle: f64) -> (Mechanism, State) {
    let [a, b, _] = HALF;
    throw(vec![(Shape::Box { half: Vector3::from(HALF) }, Pose::translation(middle * a, middle * b, 0.0))])
}

/// The same on balls whose lowest points are its corners.
fn thrown_on_balls(middle: f64) -> (Mechanism, State) {
    let [a, b, c] = HALF;
    let radius = 0.02;
    let ball = |[x, y]: [f64; 2]| Pose::translation(a * (middle + x), b * (middle + y), radius - c);
    throw(CORNERS.map(|corner| (Shape::Sphere { radius }, ball(corner))).to_vec())
}

fn throw(shapes: Vec<(Shape, Pose)>) -> (Mechanism, State) {
    let [a, b, c] = HALF;
    let inertia = Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) * (MASS / 3.0);
    let mechanism = over_floor(MASS, inertia, shapes, Vector3::new(0.0, 0.0, -GRAVITY), FRICTION, 0.0);
    let start = placed(&mechanism, Vector3::new(0.0, 0.0, c), Vector3::new(0.6, 0.2, 0.0), Vector3::new(0.0, 0.0, 6.0));
    (mechanism, start)
}

/// The places of corners relative to the centre of mass, the friction of a unit of pressure at each, and the pressures there (N).
struct Carried {
    places: Vec<[f64; 2]>,
    drags: Vec<[f64; 2]>,
    pressures: Vec<f64>,
}

/// Those of these corners in a state, where the middle is so far from the centre of mass.
fn carried(state: [f64; 6], middle: f64, corners: &[[f64; 2]]) -> Carried {
    let [a, b, height] = HALF;
    let [_, _, angle, vx, vy, spin] = state;
    let (sine, cosine) = angle.sin_cos();
    let place = |[x, y]: [f64; 2]| [cosine * x - sine * y, sine * x + cosine * y];
    let places: Vec<[f64; 2]> = corners.iter().map(|[x, y]| place([a * (middle + x), b * (middle + y)])).collect();
    let drag = |&[x, y]: &[f64; 2]| {
        let (ux, uy) = (vx - spin * y, vy + spin * x);
        let speed = ux.hypot(uy);
        [-FRICTION * ux / speed, -FRICTION * uy / speed]
    };
    let drags: Vec<[f64; 2]> = places.iter().map(drag).collect();
    let mut matrix = Matrix3::zeros();
    for (&[x, y], &[dx, dy]) in places.iter().zip(&drags) {
        let of_a_unit = Vector3::new(1.0, y + height * dy, -height * dx - x);
        matrix += of_a_unit * Vector3::new(1.0, x, y).transpose();
    }
    let plane = matrix.lu().solve(&Vector3::new(MASS * GRAVITY, 0.0, 0.0)).expect("it stands on its corners");
    let pressures = places.iter().map(|[x, y]| plane.dot(&Vector3::new(1.0, *x, *y))).collect();
    Carried { places, drags, pressures }
}

/// What (x, y, θ, v_x, v_y, ω) change by in time, while these corners slide, where the middle is so far from the centre of mass.
fn rates(state: [f64; 6], middle: f64, corners: &[[f64; 2]]) -> [f64; 6] {
    let [a, b, _] = HALF;
    let [_, _, _, vx, vy, spin] = state;
    let Carried { places, drags, pressures } = carried(state, middle, corners);
    let mut sum = [0.0; 3];
    for ((&[x, y], &[dx, dy]), &pressure) in places.iter().zip(&drags).zip(&pressures) {
        assert!(pressure > 0.0, "{pressure} N");
        sum[0] += pressure * dx;
        sum[1] += pressure * dy;
        sum[2] += pressure * (x * dy - y * dx);
    }
    [vx, vy, spin, sum[0] / MASS, sum[1] / MASS, sum[2] / (MASS / 3.0 * (a * a + b * b))]
}

/// The pressure that the plane over all four corners has at the last (N).
fn pressure_at_last(state: [f64; 6], middle: f64) -> f64 {
    carried(state, middle, &CORNERS).pressures[3]
}

/// The signs of the corners; the last is the one that the centre of mass can be far from.
const CORNERS: [[f64; 2]; 4] = [[1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];

/// The motion after a time (s), by the method of fourth order: with steps ten times as long it is 6e-11 off, so its error is some 1e-14.
fn reference(until: f64, middle: f64, corners: &[[f64; 2]]) -> [f64; 6] {
    after(|state| rates(*state, middle, corners), [0.0, 0.0, 0.0, 0.6, 0.2, 6.0], until, 40_000)
}

/// How far a run is from the reference after a time (s): the largest difference of places (m), and of (v, ω).
fn errors(stages: usize, step: f64, until: f64) -> [f64; 2] {
    let (mechanism, start) = thrown(0.0);
    off(&run(&mechanism, &start, until, fixed(stages, step)).state, reference(until, 0.0, &CORNERS))
}

/// The same of a state.
fn off(State { position, velocity, .. }: &State, exact: [f64; 6]) -> [f64; 2] {
    let off = |found: &[f64], exact: &[f64]| {
        found.iter().zip(exact).map(|(found, exact)| (found - exact).abs()).fold(0.0, f64::max)
    };
    [off(&position[..2], &exact[..2]), off(&[velocity[0], velocity[1], velocity[5]], &exact[3..])]
}

#[test]
fn the_pressures_of_a_box_that_slides_and_turns_lie_on_a_plane() {
    for (stages, step) in [(9, 0.05), (5, 0.01), (3, 5e-4), (3, 5e-5)] {
        // Four hundred steps show what the shortest do.
        let [place, rate] = errors(stages, step, f64::min(0.1, 400.0 * step));
        println!("{stages} stages, {step} s: {place:e} m, {rate:e} m/s");
        // Steps with contacts are iterated to 1e-12 m, which are 1e-10 m/s in one of 10 ms. Compliances that differ from corner to corner make it 1e-2,
        // and roundings of gaps, divided by ε, 1e-6 in the shortest steps.
        assert!(place < 1e-11, "{stages} stages, {step} s: {place:e} m");
        assert!(rate < 1e-9, "{stages} stages, {step} s: {rate:e} m/s");
    }
}

#[test]
fn a_corner_that_the_plane_would_pull_does_not_press() {
    // The centre of mass is over three of the corners, and so far from the fourth that the plane would pull there with a tenth of the weight.
    const MIDDLE: f64 = 0.7;
    let exact = reference(0.1, MIDDLE, &CORNERS[..3]);
    // The four corners of a box are one pair with the floor, four balls are four: the last of them touches without pressing.
    for (mechanism, start) in [thrown(MIDDLE), thrown_on_balls(MIDDLE)] {
        for steps in [fixed(9, 0.02), fixed(5, 0.01), StepChoice::Tolerance(1e-9)] {
            let done = run(&mechanism, &start, 0.1, steps);
            let [place, rate] = off(&done.state, exact);
            println!("{steps:?}: {place:e} m, {rate:e} m/s, {:?}, {:?}", done.summary.contact, done.events);
            // Steps with contacts are iterated to 1e-12 m, as above. With a fourth corner that pulls it is 0.9 mm off.
            assert!(place < 1e-11 && rate < 1e-9, "{steps:?}: {place:e} m, {rate:e} m/s");
            assert!(done.summary.contact.cone_violation < 1e-10, "{steps:?}: {:?}", done.summary.contact);
            // A ball is let go where the run begins, and no rounding of its gap is an impact.
            assert!(done.events.iter().all(|event| event.kind == EventKind::Release), "{:?}", done.events);
            assert!(done.events.len() <= 1, "{:?}", done.events);
        }
    }
}

#[test]
fn a_corner_that_the_plane_pulls_for_a_while_presses_again() {
    // The slip turns relative to the box: the plane pulls the last corner until some time, and presses it from then on.
    const MIDDLE: f64 = 0.5;
    let springs = |state: &[f64; 6]| {
        let pressed = pressure_at_last(*state, MIDDLE) > 0.0;
        rates(*state, MIDDLE, if pressed { &CORNERS } else { &CORNERS[..3] })
    };
    let start = [0.0, 0.0, 0.0, -0.6, 0.2, 6.0];
    let until = 0.15;
    let exact = after(springs, start, until, 60_000);
    let first = pressure_at_last(start, MIDDLE);
    assert!(first < -0.1 && pressure_at_last(exact, MIDDLE) > 0.1, "{first} N, {} N", pressure_at_last(exact, MIDDLE));
    for (mechanism, mut start) in [thrown(MIDDLE), thrown_on_balls(MIDDLE)] {
        start.velocity[0] = -0.6;
        for steps in [fixed(9, 0.02), StepChoice::Tolerance(1e-6), StepChoice::Tolerance(1e-9)] {
            let done = run(&mechanism, &start, until, steps);
            let [place, rate] = off(&done.state, exact);
            println!("{steps:?}: {place:e} m, {rate:e} m/s, {:?}", done.events);
            // Pressures within 1e-9 of the load count as none, which makes 1e-9 m/s² while the plane passes through zero.
            assert!(place < 1e-10 && rate < 1e-9, "{steps:?}: {place:e} m, {rate:e} m/s");
        }
    }
}

#[test]
fn a_craft_whose_corners_clatter_slides_on_all_four_at_every_tolerance() {
    // It lands upside down at 1.66 s on corner after corner. The last three blows were within 1e-7 s, and the fourth corner was left open at zero or
    // not, as roundings would have it: runs ended 5.6e-3 m apart, and told 1e-7 m.
    let rotor = |x: f64, y: f64, rest: &str| {
        format!("[[load]]\nlink = \"q\"\nposition = [{x}, {y}, 0]\nforce = [0, 0, 1]\nframe = \"link\"\n{rest}\n")
    };
    let text = "[[body]]\nname = \"q\"\nshape = { type = \"box\", size = [0.42, 0.42, 0.07] }\nmass = 1.37\n\
        pose = { position = [0, 0, 0.035] }\n"
        .to_owned()
        + &rotor(0.2, 0.2, "factor = { formula = \"a+b*sin(w*t)\", a = 3.62, b = 0.21, w = 3.7 }")
        + &rotor(-0.2, 0.2, "factor = { formula = \"a+b*cos(w*t)\", a = 3.60, b = 0.23, w = 4.1 }")
        + &rotor(-0.2, -0.2, "factor = 3.615")
        + &rotor(0.2, -0.2, "factor = 3.601\nuntil = 1.7")
        + "[[drag]]\nlink = \"q\"\nlinear = 0.11\nquadratic = 0.07\nangular = 0.003\n\
           [[obstacle]]\nname = \"ground\"\nshape = { type = \"half_space\" }\nfriction = 0.6\n";
    let file = scene_of("clattering_craft", "<link name='base'/>", &text);
    let run = |tolerance: f64| report(&file, &[], &[], Some(4.0), tolerance);
    let fine = run(1e-8);
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7] {
        let done = run(tolerance);
        let off = apart(&done, &fine);
        println!("{tolerance:e}: {off:e}, told {:?}", done.accuracy);
        assert!(off <= tolerance, "{tolerance:e}: {off:e}");
    }
}

#[test]
fn order_is_kept_while_a_box_slides_and_turns() {
    for (stages, longest) in [(3, 0.02), (4, 0.04), (5, 0.05)] {
        let errors = [0, 1, 2].map(|halved| errors(stages, longest * 0.5_f64.powi(halved), 0.1)[0]);
        println!("{stages} stages: {errors:?}");
        for pair in errors.windows(2) {
            let slope = (pair[0] / pair[1]).log2();
            // Each step is iterated to 1e-12 m.
            assert!(slope > (2 * stages - 2) as f64 - 0.6 || pair[1] < 1e-11, "{stages} stages: {errors:?}");
        }
    }
}

#[test]
fn a_box_comes_to_rest_in_one_place_whatever_the_steps() {
    let (mechanism, start) = thrown(0.0);
    let place = |steps| {
        let finished = run(&mechanism, &start, 0.5, steps);
        assert_eq!(finished.state.velocity, vec![0.0; 6], "{:?}", finished.events);
        let stop = of_kind(&finished, EventKind::Stick).last().expect("it stops").time;
        [finished.state.position[0], finished.state.position[1], stop]
    };
    let exact = place(StepChoice::Tolerance(1e-10));
    // Where it lies to the tolerance, or to what given steps of this order leave; the instant at which the last creep of 1e-10 of the speed ends, less well.
    for (steps, most, late) in [
        (StepChoice::Tolerance(1e-6), 1e-6, 1e-6),
        (StepChoice::Tolerance(1e-8), 1e-8, 1e-6),
        (fixed(5, 0.01), 1e-7, 1e-5),
        (fixed(9, 0.02), 1e-7, 1e-5),
    ] {
        let found = place(steps);
        println!("{:e} m, {:e} m, {:e} s", found[0] - exact[0], found[1] - exact[1], found[2] - exact[2]);
        for (index, bound) in [most, most, late].into_iter().enumerate() {
            near(found[index], exact[index], bound);
        }
    }
}

#[test]
fn a_box_that_turns_over_the_edge_of_a_table_has_every_corner_of_its_patch_and_shares_its_load_as_springs_do_inside_steps()
 {
    // Corners pass the edge both ways. Crossings move along the sides, so that stages share the load otherwise: runs at 1e-3 to 1e-6 m were 1.7e-3 m off, and told
    // 4e-6 m of the first.
    let [x, angle, vx, vy, spin] = [-0.0266, -1.2415, -0.0837, -0.0438, 8.7507];
    let (size, friction) = ([0.2778, 0.1921, 0.0383], 0.2327);
    let text = format!(
        "[[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = {size:?} }}\nmass = 1\n\
         pose = {{ position = [{x}, 0, {}], rpy = [0, 0, {angle}] }}\n\
         velocity = {{ linear = [{vx}, {vy}, 0], angular = [0, 0, {spin}] }}\n\
         [[obstacle]]\nname = \"table\"\nshape = {{ type = \"box\", size = [1, 1, 0.1] }}\npose = {{ position = [-0.5, 0, -0.05] }}\n\
         [contact]\nfriction = {friction}\nrestitution = 0\n",
        0.5 * size[2]
    );
    let file = scene_of("turns_over_an_edge", "<link name='base'/>", &text);
    let (on, begins) = (OnTable { size, friction }, [x, 0.0, angle, vx, vy, spin]);
    for until in [0.0167, 0.1, 0.2] {
        let right = on.after(begins, until);
        for tolerance in [1e-3, 1e-6] {
            let run = report(&file, &[], &[], Some(until), tolerance);
            let (_, link) = run.links.iter().find(|(name, _)| name == "box").expect("a link");
            let [w, _, _, z] = link.orientation;
            let turned = (2.0 * z.atan2(w) - right[2]).rem_euclid(std::f64::consts::TAU);
            let turned = turned.min(std::f64::consts::TAU - turned);
            let off = (link.position[0] - right[0]).hypot(link.position[1] - right[1]);
            let spins = (link.angular_velocity[2] - right[5]).abs();
            println!(
                "{until} s at {tolerance:e}: {off:e} m, {turned:e} rad, {spins:e} rad/s, {} points",
                on.points(&right)
            );
            assert!(run.accuracy.as_ref().expect("an accuracy").reached, "{:?}", run.warnings);
            let points = run.contact.points.len();
            assert_eq!(points, on.points(&right), "{until} s at {tolerance:e}");
            // Contacts go on 1.2e-11 of the size beyond their borders, where forces jump.
            assert!(
                off <= 1e-8 && turned <= 1e-7 && spins <= 1e-6,
                "{until} s at {tolerance:e}: {off:e} {turned:e} {spins:e}"
            );
        }
    }
}

#[test]
fn a_plank_on_two_rollers_that_turn_inwards_swings_as_the_closed_form_and_does_not_turn() {
    // The rate of a roller beside its own contacts is rounding, and was taken for a motion: pressures of the four points were shared at random.
    let (friction, half, thick, radius, from, duration) = (0.4, 0.2, 0.02, 0.05, 0.03, 1.5);
    let roller = format!(
        "<link name='base'/>{}",
        [("left", -half), ("right", half)].map(|(name, place)| format!(
            "<link name='{name}'><inertial><mass value='1'/><inertia ixx='0.002' iyy='0.002' izz='0.002' ixy='0' ixz='0' iyz='0'/></inertial>\
             <collision><origin rpy='1.5707963267948966 0 0'/><geometry><cylinder radius='{radius}' length='0.3'/></geometry></collision></link>\
             <joint name='{name}_turns' type='continuous'><parent link='base'/><child link='{name}'/><origin xyz='{place} 0 {}'/><axis xyz='0 1 0'/></joint>",
            -radius
        )).concat()
    );
    let text = format!(
        "[[robot]]\nurdf = \"robot.urdf\"\nvelocities = {{ left_turns = 100.0, right_turns = -100.0 }}\n\
         [[motion]]\njoint = \"left_turns\"\nposition = {{ formula = \"100*t\" }}\n[[motion]]\njoint = \"right_turns\"\nposition = {{ formula = \"-100*t\" }}\n\
         [[body]]\nname = \"plank\"\nshape = {{ type = \"box\", size = [1.2, 0.15, {thick}] }}\nmass = 1.2\npose = {{ position = [{from}, 0, {}] }}\n\
         [contact]\nfriction = {friction}\nrestitution = 0\n",
        0.5 * thick
    );
    let file = scene_of("plank_on_rollers", &roller, &text);
    // Friction at the lower face, h/2 below the centre, takes μ h/2 from the distance of each roller.
    let rate = (friction * GRAVITY / (half - 0.5 * friction * thick)).sqrt();
    for tolerance in [1e-3, 1e-6] {
        let run = report(&file, &[], &[], Some(duration), tolerance);
        let (_, link) = run.links.iter().find(|(name, _)| name == "plank").expect("a link");
        let off = (link.position[0] - from * (rate * duration).cos()).abs();
        println!("{tolerance:e}: off by {off:e} m, turned by {:e}", link.orientation[3]);
        assert!(run.accuracy.as_ref().expect("an accuracy").reached, "{:?}", run.warnings);
        // A turn grows at some 4/s from roundings.
        assert!(off <= tolerance && link.orientation[3].abs() <= 1e-9, "{off:e} {:?}", link.orientation);
    }
}
