//! The layout for Lichtblick shows the scene the right way up, and curves of numbers that are in the log.

use super::{log, messages, of_topic};
use std::collections::HashMap;

fn layout() -> serde_json::Value {
    let layout = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/viewer/lichtblick.json"));
    serde_json::from_str(&layout.expect("the layout")).expect("JSON")
}

/// What the viewer's own settings would do: hide the scene, and lay STL and OBJ meshes on their sides.
#[test]
fn the_layout_for_lichtblick_shows_the_scene_with_meshes_the_right_way_up() {
    let layout = layout();
    let view = &layout["configById"]["3D!catena"];
    assert_eq!(view["topics"]["/visual_markers"]["visible"], true);
    assert_eq!((&view["scene"]["meshUpAxis"], &view["scene"]["ignoreColladaUpAxis"]), (&"z_up".into(), &true.into()));
    assert_eq!(view["followTf"], "world");
    // Where something touches, the forces are seen, and collision shapes can be switched on.
    assert_eq!(view["topics"]["/contact_forces"]["visible"], true);
    assert_eq!(view["topics"]["/collision_shapes"]["visible"], false);
}

/// The types of the fields of a message by their names, from the definition of another that uses it; that itself without a name.
fn fields<'d>(definition: &'d str, message: Option<&str>) -> HashMap<&'d str, &'d str> {
    let separator = format!("{}\n", "=".repeat(80));
    let is_it = |part: &&str| message.is_none_or(|name| part.starts_with(&format!("MSG: {name}\n")));
    let part = definition.split(&separator[..]).find(is_it).unwrap_or_else(|| panic!("no {message:?} in {definition}"));
    part.lines()
        .filter(|line| !line.starts_with("MSG: "))
        .filter_map(|line| line.split_once(' '))
        .map(|(a, b)| (b, a))
        .collect()
}

/// A range of indices would be drawn as one curve, from joint to joint and back.
#[test]
fn every_curve_of_the_layout_is_one_number_of_a_message_of_the_log() {
    let bytes = log("layout", 0.1);
    let messages = messages(&bytes);
    let layout = layout();
    let panels = layout["configById"].as_object().expect("panels");
    let mut arrangement = vec![&layout["layout"]];
    let mut shown = 0;
    while let Some(part) = arrangement.pop() {
        match part.as_str() {
            Some(name) => {
                assert!(panels.contains_key(name), "{name}");
                shown += 1;
            }
            None => arrangement.extend([&part["first"], &part["second"]]),
        }
    }
    assert_eq!(shown, panels.len());
    let paths = panels.iter().filter(|(name, _)| name.starts_with("Plot!"));
    let mut paths = paths.flat_map(|(_, panel)| panel["paths"].as_array().expect("curves")).peekable();
    assert!(paths.peek().is_some());
    for path in paths {
        let path = path["value"].as_str().expect("a path");
        let (topic, names) = path.split_once('.').expect("a topic and fields");
        let channel = &of_topic(&messages, topic).first().unwrap_or_else(|| panic!("{path}: no such topic")).channel;
        let schema = channel.schema.as_ref().expect("a schema");
        let definition = std::str::from_utf8(&schema.data).expect("UTF-8");
        let mut kind = fields(definition, None);
        let mut names = names.split('.').peekable();
        while let Some(name) = names.next() {
            let (name, index) = name.split_once('[').map_or((name, None), |(name, index)| (name, Some(index)));
            let found = kind.get(name).unwrap_or_else(|| panic!("{path}: no field {name}"));
            let index = index.map(|index| index.trim_end_matches(']').parse::<usize>().expect("one index"));
            assert_eq!(index.is_some(), found.ends_with("[]"), "{path}: {name}");
            let found = found.trim_end_matches("[]");
            if names.peek().is_some() {
                kind = fields(definition, Some(found));
            } else {
                assert_eq!(found, "float64", "{path}");
            }
        }
    }
}
