//! Bodies on fixed obstacles side by side, whose tops are in one plane, against the same bodies on one plate.

use crate::scene_files::{apart, report, scene_of};

const HEAD: &str = "[[robot]]\nurdf = \"robot.urdf\"\nbase = \"floating\"\n";

fn link(name: &str, mass: f64, [x, y, z]: [f64; 3], shape: &str) -> String {
    let shape =
        if shape.is_empty() { String::new() } else { format!("<collision><geometry>{shape}</geometry></collision>") };
    format!(
        "<link name='{name}'><inertial><mass value='{mass}'/><inertia ixx='{x}' iyy='{y}' izz='{z}' ixy='0' ixz='0' iyz='0'/></inertial>\
         {shape}</link>"
    )
}

/// A plate with its top at z = 0 and this middle and size (m).
fn plate(name: &str, [x, y]: [f64; 2], [length, width]: [f64; 2]) -> String {
    format!(
        "[[obstacle]]\nname = \"{name}\"\nshape = {{ type = \"box\", size = [{length}, {width}, 0.2] }}\npose.position = [{x}, {y}, -0.1]\n"
    )
}

/// Tiles in rows, every other one of which is shifted (m).
fn tiles(size: [f64; 2], shift: f64) -> String {
    let [columns, rows] = size.map(|length| (2.5 / length) as usize + 1);
    let all = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let place = |row: usize, column: usize| {
        let shift = if row % 2 == 1 { shift } else { 0.0 };
        [size[0] * column as f64 - 1.25 + shift, size[1] * row as f64 - 1.25]
    };
    all.map(|(row, column)| plate(&format!("tile_{row}_{column}"), place(row, column), size)).collect()
}

fn one_plate() -> String {
    plate("plate", [0.0; 2], [6.0; 2])
}

#[test]
fn a_car_that_rolls_over_seams_between_boxes_keeps_its_track() {
    // Two driven wheels and a caster turn on tiles of half a metre, whose tops are in one plane. A wheel has both ends of its line of contact on one tile, and
    // then one on each: nothing slips there.
    let wheel = "<cylinder radius='0.068' length='0.047'/>";
    let side = |name: &str, y: f64| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='chassis'/><child link='{name}_wheel'/>\
             <origin xyz='0.05 {y} -0.051' rpy='-1.5707963267948966 0 0'/><axis xyz='0 0 1'/></joint>"
        )
    };
    let urdf = format!(
        "{}{}{}{}{}{}<joint name='swivel' type='spherical'><parent link='chassis'/><child link='caster'/><origin xyz='-0.279 0 -0.085'/></joint>",
        link("chassis", 26.3, [0.14, 1.1, 1.17], ""),
        link("left_wheel", 0.788, [0.001_06, 0.001_06, 0.001_83], wheel),
        link("right_wheel", 0.788, [0.001_06, 0.001_06, 0.001_83], wheel),
        link("caster", 0.1, [4.65e-5; 3], "<sphere radius='0.034'/>"),
        side("left", 0.152_331_321),
        side("right", -0.152_331_321)
    );
    let motor = |name: &str, rate: f64, kd: f64| {
        format!("[[motor]]\njoint = \"{name}\"\nkind = \"velocity\"\ntarget = {rate}\nkd = {kd}\nmax_effort = 15\n")
    };
    let drive = format!(
        "{HEAD}pose = {{ position = [0, 0, 0.119], rpy = [0, 0, -2.695656626] }}\n[contact]\nfriction = 0.8\n{}{}",
        motor("left", 3.576_629_479, 2.036),
        motor("right", -2.377_808_014, 0.725)
    );
    let places = (0..25).map(|tile| (tile / 5, tile % 5));
    let place = |(row, column)| [f64::from(row) * 0.5 - 1.0, f64::from(column) * 0.5 - 1.0];
    let floor: String = places.map(|of| plate(&format!("tile_{}_{}", of.0, of.1), place(of), [0.5; 2])).collect();
    let on = |name: &str, floor: &str, tolerance: f64| {
        let file = scene_of(name, &urdf, &format!("{drive}{floor}"));
        report(&file, &[], &[], Some(2.0), tolerance)
    };
    let whole = on("car_on_a_plate", &one_plate(), 1e-6);
    for tolerance in [1e-4, 1e-6, 1e-7] {
        let end = on("car_over_seams", &floor, tolerance);
        let off = apart(&whole, &end);
        let told = end.accuracy.as_ref().expect("an accuracy");
        // The coarse run is 1e-9 m off, and ones that slip falsely at the seams 6 mm to 2 cm.
        assert!(told.reached && off <= 1e-7, "{tolerance:e}: {off:e} m apart, {told:?}");
        assert!(end.energy.impacts.abs() <= 1e-12 && end.warnings.is_empty(), "{:?}, {:?}", end.energy, end.warnings);
    }
}

#[test]
fn boxes_cylinders_and_balls_on_tiles_move_as_on_one_plate() {
    let shapes = [
        ("<box size='0.2 0.15 0.1'/>", "0", 0.05),
        ("<cylinder radius='0.05' length='0.12'/>", "1.5707963267948966", 0.05),
        ("<capsule radius='0.05' length='0.12'/>", "1.5707963267948966", 0.05),
        ("<sphere radius='0.05'/>", "0", 0.05),
    ];
    let floors = [tiles([0.5; 2], 0.0), tiles([0.4, 0.2], 0.14)];
    // Flush plates that leave half of a floor free.
    let flush = (0..36).map(|of| {
        plate(&format!("flush_{of}"), [f64::from(of / 6) * 0.4 - 1.0, f64::from(of % 6) * 0.4 - 1.0], [0.2; 2])
    });
    let flush =
        format!("[[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\n{}", flush.collect::<String>());
    // Friction, yaw (rad), velocity [m/s], rate about the vertical [rad/s] and height of the drop (m).
    let starts = [
        (0.475, -0.17, [-1.34, -0.06], 5.9, 0.0),
        (0.26, -0.15, [1.09, 0.62], -0.08, 0.0),
        (0.4, 0.7, [0.6, -0.5], 3.0, 0.02),
    ];
    catena::events::check_certificates();
    let mut worst: Vec<(f64, String)> = Vec::new();
    for (number, (geometry, roll, height)) in shapes.into_iter().enumerate() {
        let urdf = link("body", 1.3, [0.004, 0.005, 0.0062], geometry);
        for (start, (friction, yaw, [x, y], rate, drop)) in starts.into_iter().enumerate() {
            let text = format!(
                "{HEAD}pose = {{ position = [0.03, -0.02, {}], rpy = [{roll}, 0, {yaw}] }}\nvelocity = {{ linear = [{x}, {y}, 0], angular = [0, 0, {rate}] }}\n\
                 [contact]\nfriction = {friction}\n",
                height + drop
            );
            let on = |floor: &str| {
                let file = scene_of(&format!("seams_{number}_{start}"), &urdf, &format!("{text}{floor}"));
                report(&file, &[], &[], Some(0.6), 1e-8)
            };
            let whole = on(&one_plate());
            for (of, floor) in floors.iter().chain([&flush]).enumerate() {
                let off = apart(&whole, &on(floor));
                worst.push((off, format!("{geometry}, start {start}, floor {of}")));
            }
        }
    }
    worst.sort_by(|one, other| other.0.total_cmp(&one.0));
    // Both keep to 1e-8 m. With points on seams they were 1e-5 to 4e-3 m apart.
    assert!(worst[0].0 <= 2e-8, "{:?}", &worst[..worst.len().min(8)]);
}
