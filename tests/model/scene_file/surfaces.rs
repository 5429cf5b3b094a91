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
            "scene.toml:10: link \"foot\": give its collision, friction, restitution, rolling_friction, spinning_friction or surface_velocity",
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

#[test]
fn lengths_of_rolling_and_spinning_friction_come_from_the_same_places_and_have_key_paths() {
    let folder = folder("lengths");
    std::fs::write(folder.join("foot.urdf"), FOOT).unwrap();
    let lengths = |text: &str, numbers: &[(&str, f64)]| {
        let mut scene = read(&folder, text).unwrap();
        let numbers: Vec<_> = numbers.iter().map(|(key, number)| (scene.parameter(key).unwrap(), *number)).collect();
        scene.set(&numbers).unwrap();
        let (model, _) = Model::from_scene(&scene).unwrap();
        let of =
            |pair: catena::mechanism::description::contact::ContactPair| [pair.moments.rolling, pair.moments.spinning];
        <[[f64; 2]; 3]>::try_from(model.mechanism.nonsmooth.pairs.iter().map(of).collect::<Vec<_>>())
            .expect("three pairs")
    };
    let contact = "[contact]\npairs = \"all\"\nrolling_friction = 0.03\nspinning_friction = 0.01\n";
    let pair = "[[contact.pair]]\na = \"two\"\nb = \"ground\"\nspinning_friction = 0.04\n";
    let link = "[[link]]\nname = \"foot\"\nrolling_friction = 0.02\n";
    let plain = format!("{SLIDERS}{contact}{GROUND}");
    assert_eq!(lengths(&plain, &[]), [[0.03, 0.01]; 3]);
    let all = format!("{SLIDERS}{contact}{pair}{GROUND}spinning_friction = 0.005\n{link}");
    assert_eq!(lengths(&all, &[]), [[0.02, 0.01], [0.02, 0.005], [0.03, 0.04]]);
    let set = [
        ("contact.pair.1.spinning_friction", 0.06),
        ("contact.rolling_friction", 0.05),
        ("obstacle.ground.rolling_friction", 0.07),
        ("link.foot.spinning_friction", 0.08),
    ];
    assert_eq!(lengths(&all, &set), [[0.02, 0.08], [0.07, 0.005], [0.07, 0.06]]);
    let set = [("body.two.rolling_friction", 0.01)];
    assert_eq!(lengths(&plain, &set), [[0.01, 0.01], [0.03, 0.01], [0.01, 0.01]]);
    let negative = refusal(&folder, &format!("{SLIDERS}{GROUND}rolling_friction = -1\n"));
    assert!(negative.contains("rolling_friction: -1 must not be negative"), "{negative}");
}

#[test]
fn a_shape_of_a_link_has_its_own_friction_over_that_of_its_link() {
    let folder = folder("shapes_of_a_link");
    let second = "<collision><origin xyz='0 3 0'/><geometry><sphere radius='1'/></geometry></collision></link>";
    std::fs::write(folder.join("foot.urdf"), FOOT.replace("</link>", second)).unwrap();
    let robot = "[[robot]]\nname = \"one\"\nurdf = \"foot.urdf\"\nbase = \"floating\"\n";
    let own = "[[link]]\nname = \"foot\"\nshape = 2\nfriction = 0.2\nrestitution = 0.5\nrolling_friction = 0.01\n";
    let mut scene = read(&folder, &format!("{robot}{GROUND}{own}")).unwrap();
    let of = |scene: &catena::scene::Scene| {
        let (model, _) = Model::from_scene(scene).unwrap();
        let pairs = model.mechanism.nonsmooth.pairs.iter();
        pairs.map(|pair| (pair.friction, pair.restitution, pair.moments.rolling)).collect::<Vec<_>>()
    };
    assert_eq!(of(&scene), [(0.7, 0.0, 0.0), (0.2, 0.5, 0.01)]);
    let keys = [("link.foot.friction", 0.6), ("link.foot.collision.2.friction", 0.1)];
    let numbers = keys.map(|(key, number)| (scene.parameter(key).unwrap(), number));
    scene.set(&numbers).unwrap();
    assert_eq!(of(&scene), [(0.6, 0.0, 0.0), (0.1, 0.5, 0.01)]);
    // A key without effect is not there.
    let both = format!("{robot}{GROUND}{own}[[link]]\nname = \"foot\"\nshape = 1\nfriction = 0.3\n");
    assert!(read(&folder, &both).unwrap().parameter("link.foot.friction").is_err());
}

#[test]
fn the_link_of_the_documentation_is_a_scene_when_copied() {
    let folder = folder("documented_link");
    let document = include_str!("../../../doc/scene_files.md");
    let table = &document[document.find("\n[[link]]\n").expect("a table [[link]]") + 1..];
    let table = &table[..table.find("\n\n").expect("its end")];
    let second = "<collision><origin xyz='0 3 0'/><geometry><sphere radius='1'/></geometry></collision></link>";
    std::fs::write(folder.join("foot.urdf"), FOOT.replace("</link>", second).replace("'foot'", "'hand'")).unwrap();
    let robot = "[[robot]]\nname = \"one\"\nurdf = \"foot.urdf\"\nbase = \"floating\"\n";
    let (model, ..) = build(&folder, &format!("{robot}{GROUND}{table}\n"));
    let friction: Vec<f64> = model.mechanism.nonsmooth.pairs.iter().map(|pair| pair.friction).collect();
    assert_eq!(friction, [0.7, 0.8]);
}
