//! Friction of single geoms, excluded bodies that do not move, and pairs of geoms.

use crate::common::command;
use catena::mechanism::description::contact::ContactPair;
use catena::session::Model;

/// The model of a text in a folder of its own.
fn load(name: &str, text: &str) -> Model {
    let folder = command::folder(name);
    std::fs::write(folder.join("model.xml"), text).expect("written");
    Model::load(folder.join("model.xml")).expect("a model")
}

/// What touches what, with sliding, rolling and spinning friction.
fn pairs(model: &Model) -> Vec<(String, [f64; 3])> {
    let nonsmooth = &model.description().mechanism.nonsmooth;
    let name = |of: usize| nonsmooth.colliders[of].name.as_str();
    let of = |pair: ContactPair| {
        let values = [pair.friction, pair.moments.rolling, pair.moments.spinning];
        (format!("{} {}", name(pair.a), name(pair.b)), values)
    };
    nonsmooth.pairs.iter().map(of).collect()
}

fn said(model: &Model, line: &str) {
    assert!(model.warnings().iter().any(|warning| warning.contains(line)), "{line}: {:#?}", model.warnings());
}

#[test]
fn geoms_of_one_body_have_their_own_friction() {
    let text = "<mujoco><worldbody><geom name='floor' type='plane' size='5 5 .1' condim='6' friction='0.1 0 0'/>
      <body name='axle' pos='0 0 .1'><freejoint/>
       <geom type='sphere' size='.1' pos='0 .2 0' condim='6' friction='0.9 0.01 0.006'/>
       <geom type='sphere' size='.1' pos='0 -.2 0' condim='6' friction='0.2 0.01 0.002'/></body></worldbody></mujoco>";
    let model = load("mjcf_geom_friction", text);
    let wanted = [[0.9, 0.006, 0.01], [0.2, 0.002, 0.01]].map(|values| ("axle floor".to_string(), values));
    assert_eq!(pairs(&model), wanted);
    // A floor of a higher priority decides for all.
    let model =
        load("mjcf_geom_friction", &text.replace("condim='6' friction='0.1 0 0'", "priority='1' friction='0.1'"));
    assert!(pairs(&model).iter().all(|(_, values)| *values == [0.1, 0.0, 0.0]), "{:?}", pairs(&model));
    // One of a priority between those of the geoms has no counterpart.
    let between = text.replace("condim='6' friction='0.1 0 0'", "priority='1' friction='0.1'");
    let model = load("mjcf_geom_friction", &between.replace("0 -.2 0' condim='6'", "0 -.2 0' priority='2'"));
    assert!(pairs(&model).iter().all(|(_, values)| *values == [0.1, 0.0, 0.0]), "{:?}", pairs(&model));
    said(&model, "model.xml:2: friction of \"floor\" and \"axle\" differs by geom; the smallest is used");
}

#[test]
fn an_exclusion_may_name_a_body_that_does_not_move_or_the_world() {
    let text = "<mujoco><worldbody><geom name='floor' type='plane' size='9 9 .1' pos='0 0 -3'/>
      <body name='table' pos='0 0 .1'><geom name='top' type='box' size='.2 .2 .1'/><frame><geom name='rim' size='.1'/></frame></body>
      <body name='cube' pos='0 0 .301'><freejoint/><geom type='box' size='.2 .2 .1'/></body></worldbody>
     <contact><exclude body1='table' body2='cube'/></contact></mujoco>";
    let names = |model: &Model| pairs(model).into_iter().map(|(names, _)| names).collect::<Vec<_>>();
    assert_eq!(names(&load("mjcf_exclude", text)), ["cube floor"]);
    let world = text.replace("body1='table'", "body1='world'");
    assert_eq!(names(&load("mjcf_exclude", &world)), ["cube top", "cube rim"]);
    let folder = command::folder("mjcf_exclude");
    std::fs::write(folder.join("model.xml"), text.replace("body1='table'", "body1='desk'")).expect("written");
    let error = Model::load(folder.join("model.xml")).expect_err("no such body").to_string();
    assert!(error.contains("model.xml:4: <exclude body1=\"desk\">: there is no such body"), "{error}");
}

#[test]
fn a_pair_of_geoms_has_its_own_friction_and_touches_whatever_its_bits_say() {
    let text = "<mujoco><worldbody><geom name='floor' type='plane' size='9 9 .1'/>
      <body name='cube' pos='0 0 .1'><freejoint/><geom name='g' type='box' size='.2 .2 .1' contype='0' conaffinity='0'/></body>
      <body name='ball' pos='3 0 .1'><freejoint/><geom name='h' size='.1'/></body></worldbody>
     <contact><pair geom1='g' geom2='floor' friction='0.25 0.2 0.005 0.0001 0.0001' solref='0.1 1'/></contact></mujoco>";
    let model = load("mjcf_pair", text);
    let wanted = [("cube/cube floor", 0.2), ("ball/ball floor", 1.0)];
    assert_eq!(pairs(&model), wanted.map(|(names, sliding)| (names.to_string(), [sliding, 0.0, 0.0])));
    said(&model, "model.xml:4: its friction differs by direction; the smaller one is used");
    said(&model, "ignored: line 4: solref of <pair>");
}

#[test]
fn bits_of_contact_count_between_all_bodies_and_the_world() {
    let text = "<mujoco><worldbody><geom name='floor' type='plane' size='9 9 .1'/>
      <geom name='wall' type='box' size='.1 .1 .1' pos='1 0 0' contype='4' conaffinity='4'/>
      <body name='a' pos='0 0 .1'><freejoint/><geom size='.1' contype='2' conaffinity='1'/></body>
      <body name='b' pos='3 0 .1'><freejoint/><geom size='.1' contype='2' conaffinity='1'/><geom size='.1' pos='0 0 1' contype='4' conaffinity='4'/></body>
      </worldbody></mujoco>";
    let model = load("mjcf_bits", text);
    let names: Vec<String> = pairs(&model).into_iter().map(|(names, _)| names).collect();
    assert_eq!(names, ["a/a floor", "b/b floor", "b/b wall", "b/b floor", "b/b wall"]);
    said(&model, "model.xml:4: contype and conaffinity let some geoms of \"floor\" and \"b/b\" touch and some not");
}
