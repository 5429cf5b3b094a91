//! Friction and restitution of a pair: of the last [[contact.pair]], else of the obstacle, else of the link, else of [contact].

use super::{build, folder, read, refusal};
use catena::model::Model;

const SLIDERS: &str = "[[robot]]\nname = \"one\"\nurdf = \"foot.urdf\"\nbase = \"floating\"\n\
    [[body]]\nname = \"two\"\nshape = { type = \"sphere\", radius = 1 }\nmass = 1\npose = { position = [3, 0, 0] }\n";
const GROUND: &str =
    "[[obstacle]]\nname = \"ground\"\nshape = { type = \"half_space\" }\npose = { position = [0, 0, -3] }\n";
const FOOT: &str = "<robot name='foot'><link name='foot'><inertial><mass value='1'/>\
    <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>\
    <collision><geometry><sphere radius='1'/></geometry></collision></link><gazebo reference='foot'><mu1>0.7</mu1></gazebo></robot>";

/// Friction and restitution of (foot, two), (foot, ground) and (two, ground).
fn pairs(model: &Model) -> [(f64, f64); 3] {
    let pairs = &model.mechanism.nonsmooth.pairs;
    let all: Vec<(f64, f64)> = pairs.iter().map(|pair| (pair.friction, pair.restitution)).collect();
    all.try_into().expect("three pairs")
}

#[test]
fn the_nearest_that_says_friction_and_restitution_decides() {
    let folder = folder("surfaces");
    std::fs::write(folder.join("foot.urdf"), FOOT).unwrap();
    let contact = "[contact]\npairs = \"all\"\nfriction = 0.3\nrestitution = 0.1\n";
    let model = |rest: &str| build(&folder, &format!("{SLIDERS}{contact}{rest}")).0;
    assert_eq!(pairs(&model(GROUND)), [(0.7, 0.1), (0.7, 0.1), (0.3, 0.1)]);
    let of_ground = format!("{GROUND}friction = 0.9\n");
    assert_eq!(pairs(&model(&of_ground)), [(0.7, 0.1), (0.9, 0.1), (0.9, 0.1)]);
    let of_link = "[[link]]\nname = \"foot\"\nfriction = 0.2\nrestitution = 0.5\n";
    assert_eq!(pairs(&model(&format!("{GROUND}{of_link}"))), [(0.2, 0.5), (0.2, 0.5), (0.3, 0.1)]);
    // Of two links the smaller.
    let both = SLIDERS.replace("mass = 1\n", "mass = 1\nfriction = 0.4\nrestitution = 0.8\n");
    let (model, ..) = build(&folder, &format!("{both}{contact}{GROUND}{of_link}"));
    assert_eq!(pairs(&model), [(0.2, 0.5), (0.2, 0.5), (0.4, 0.8)]);
    // Key paths say the same.
    let mut set = read(&folder, &format!("{SLIDERS}{contact}{GROUND}")).unwrap();
    let numbers = [
        ("link.foot.friction", 0.2),
        ("link.foot.restitution", 0.5),
        ("body.two.friction", 0.4),
        ("body.two.restitution", 0.8),
    ];
    let numbers = numbers.map(|(key, number)| (set.parameter(key).unwrap(), number));
    set.set(&numbers).unwrap();
    assert_eq!(pairs(&Model::from_scene(&set).unwrap().0), pairs(&model));
    for (text, said) in [
        (
            "[[link]]\nname = \"foot\"\n",
            "scene.toml:10: link \"foot\": give its collision, friction, restitution or surface_velocity",
        ),
        (
            "[[link]]\nname = \"foot\"\nshape = 1\nfriction = 1\n",
            "scene.toml:13: link \"foot\": friction, restitution and surface_velocity are of the whole link",
        ),
        (
            "[[link]]\nname = \"foot\"\nfriction = -1\n",
            "scene.toml:12: link \"foot\": link.friction: -1 must not be negative",
        ),
    ] {
        let message = refusal(&folder, &format!("{SLIDERS}{text}"));
        assert!(message.starts_with(said) && message.lines().count() == 1, "{message}");
    }
}
