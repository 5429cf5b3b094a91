//! The part of `catena model` about contact: shapes, obstacles, which of them may touch and how, and which never do.

use crate::cli::tables::table::{Table, number, triple};
use catena::mechanism::description::contact::{Collider, ContactPair, MomentLengths, Shape};
use catena::mechanism::description::joint::wxyz_from_rotation;
use catena::mechanism::ground::words::counted;
use catena::model::{Model, Owner, RopeRecord, Wheel};
use catena::scene::Touching;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Rows of a table of pairs for people; `--json` has them all.
const ROWS: usize = 40;

/// Shapes, obstacles and pairs as an entry of the JSON report.
pub fn as_json(model: &Model) -> Vec<(&'static str, Value)> {
    let nonsmooth = &model.mechanism.nonsmooth;
    let contact = &model.contact;
    let name = |collider: usize| nonsmooth.colliders[collider].name.as_str();
    let touching = nonsmooth.colliders.iter().zip(&contact.owners).filter(|(_, owner)| !is_rope(owner));
    let shapes = touching.map(|(collider, owner)| {
        let body = collider.body.map_or("world", |body| model.mechanism.bodies[body].name.as_str());
        let mut value = json!({
            "name": collider.name,
            "obstacle": matches!(owner, Owner::Obstacle(_)),
            "body": body,
            "position": collider.pose.translation.vector.as_slice(),
            "orientation": wxyz_from_rotation(collider.pose.rotation.matrix()),
        });
        if collider.surface_velocity.iter().any(|rate| *rate != 0.0) {
            value["surface_velocity"] = json!(collider.surface_velocity.as_slice());
        }
        for (key, part) in shape_json(&collider.shape) {
            value[key] = part;
        }
        value
    });
    let of_shapes = nonsmooth.pairs.iter().filter(|pair| !is_rope(&contact.owners[pair.a]));
    let pairs = of_shapes.map(|pair| {
        let ContactPair { a, b, friction, restitution, moments: MomentLengths { rolling, spinning }, .. } = pair;
        let mut value = json!({"a": name(a), "b": name(b), "friction": friction, "restitution": restitution});
        for (key, length) in [("rolling_friction", rolling), ("spinning_friction", spinning)] {
            if length > 0.0 {
                value[key] = json!(length);
            }
        }
        value
    });
    let left_out = contact.left_out.iter().map(|left| {
        let because = left.because;
        json!({"a": name(left.pair.a), "b": name(left.pair.b), "rule": because.name(), "reason": because.reason()})
    });
    let wheels = contact.wheels.iter().map(|wheel| {
        let Wheel { collider, angle, moved, .. } = *wheel;
        json!({"name": name(collider), "joint": joint_of(model, collider), "angle": angle, "moved": moved})
    });
    let contact = json!({
        "touching": contact.settings.touching().name(),
        "shapes": shapes.collect::<Value>(),
        "pairs": pairs.collect::<Value>(),
        "wheels": wheels.collect::<Value>(),
        "never_touch": left_out.collect::<Value>(),
    });
    let ropes = model.contact.ropes.iter().map(|rope| {
        let RopeRecord { name, links, length, restitution, .. } = rope;
        let mut value =
            json!({"name": name, "a": links.first(), "b": links.last(), "length": length, "restitution": restitution});
        if links.len() > 2 {
            value["through"] = json!(links[1..links.len() - 1]);
        }
        value
    });
    vec![("contact", contact), ("ropes", ropes.collect())]
}

/// The name of the joint by which the body of a collider hangs on others.
fn joint_of(model: &Model, collider: usize) -> &str {
    let mechanism = &model.mechanism;
    mechanism.nonsmooth.colliders[collider].body.map_or("", |body| &mechanism.bodies[body].joint.name)
}

/// Whether a collider is an end of a rope.
fn is_rope(owner: &Owner) -> bool {
    matches!(owner, Owner::Rope(_) | Owner::RopeEnd(_))
}

/// The reason why the collision shapes of a model have no contacts, if so.
pub fn write_note(model: &Model, text: &mut String) {
    let links = model.robots.iter().flat_map(|placed| &placed.robot.links);
    let touching = links.filter(|link| !link.collisions.is_empty()).count();
    if touching > 0 && model.mechanism.nonsmooth.colliders.is_empty() {
        let why = match model.contact.settings.touching() {
            Touching::None => "contact is left out",
            _ => "there is no obstacle (--floor gives one)",
        };
        let links = counted(touching, "link", "links");
        let _ = writeln!(text, "\nthe collision shapes of {links} touch nothing: {why}");
    }
}

/// Shapes, obstacles and pairs as tables for people.
pub fn tables(model: &Model) -> [Table; 6] {
    let colliders = &model.mechanism.nonsmooth.colliders;
    let contact = &model.contact;
    let shapes = [("Shapes", "shape of", false), ("Obstacles", "obstacle", true)].map(|(title, first, is_obstacle)| {
        let mut table = Table::new(title, &[first, "shape", "size [m]", "fixed in", "at [m]"]);
        let of_kind = |owner: &Owner| !is_rope(owner) && matches!(owner, Owner::Obstacle(_)) == is_obstacle;
        for (collider, _) in colliders.iter().zip(&contact.owners).filter(|(_, owner)| of_kind(owner)) {
            let Collider { name, body, pose, shape, .. } = collider;
            let (kind, size) = shape_text(collider, shape);
            let body = body.map_or("world", |body| model.mechanism.bodies[body].name.as_str());
            table.row(vec![name.clone(), kind.to_string(), size, body.to_string(), triple(&pose.translation.vector)]);
        }
        table
    });
    let name = |collider: usize| colliders[collider].name.clone();
    let may = model.mechanism.nonsmooth.pairs.iter().filter(|pair| !is_rope(&contact.owners[pair.a]));
    let turns = model.mechanism.nonsmooth.pairs.runs().iter().any(|run| !run.first.moments.are_zero());
    let may = may.map(|pair| {
        let mut row = vec![name(pair.a), name(pair.b), number(pair.friction), number(pair.restitution)];
        row.extend([pair.moments.rolling, pair.moments.spinning].map(number).into_iter().filter(|_| turns));
        row
    });
    let heads = ["may touch", "with", "friction", "restitution", "rolling friction [m]", "spinning friction [m]"];
    let heads = &heads[..if turns { 6 } else { 4 }];
    let never = contact.left_out.iter();
    let never = never.map(|left| vec![name(left.pair.a), name(left.pair.b), left.because.reason()]);
    let mut wheels = Table::new(
        "Shapes that were turned onto the axes of their joints",
        &["turned", "onto the axis of", "by [rad]", "moved by up to [m]"],
    );
    for &Wheel { collider, angle, moved, .. } in &contact.wheels {
        let (angle, moved) = (format!("{angle:.1e}"), format!("{moved:.1e}"));
        wheels.row(vec![name(collider), joint_of(model, collider).to_string(), angle, moved]);
    }
    let [shapes, obstacles] = shapes;
    let is_reeved = contact.ropes.iter().any(|rope| rope.links.len() > 2);
    let mut ropes = match is_reeved {
        true => Table::new("Ropes", &["rope", "from", "through", "to", "length [m]", "restitution"]),
        false => Table::new("Ropes", &["rope", "from", "to", "length [m]", "restitution"]),
    };
    for RopeRecord { name, links, length, restitution, .. } in &contact.ropes {
        let [first, through @ .., last] = &links[..] else { continue };
        let mut row = vec![name.clone(), first.clone(), last.clone(), number(*length), number(*restitution)];
        if is_reeved {
            row.insert(2, through.join(", "));
        }
        ropes.row(row);
    }
    [
        ropes,
        shapes,
        wheels,
        obstacles,
        pairs(Table::new("Pairs that may touch", heads), may),
        pairs(Table::new("Pairs that never touch", &["never touches", "with", "because"]), never),
    ]
}

/// A table of pairs, those that say the same (shapes of one link) once.
fn pairs(mut table: Table, rows: impl Iterator<Item = Vec<String>>) -> Table {
    let (mut told, mut last, mut more): (Vec<Vec<String>>, Vec<String>, usize) = Default::default();
    for row in rows.filter(|row| !row.is_empty()) {
        if row != last {
            more += usize::from(told.len() == ROWS);
            if told.len() < ROWS {
                told.push(row.clone());
            }
            last = row;
        }
    }
    let width = told.first().map_or(0, Vec::len);
    if more > 0 {
        let mut last = vec![String::new(); width];
        last[0] = format!("and {}, which --json lists", counted(more, "more pair", "more pairs"));
        told.push(last);
    }
    told.into_iter().for_each(|row| table.row(row));
    table
}

/// The words for a shape, for people: its kind and its size.
fn shape_text(collider: &Collider, shape: &Shape) -> (&'static str, String) {
    let round = |radius: f64, half: f64| format!("radius {}, length {}", number(radius), number(2.0 * half));
    match shape {
        Shape::HalfSpace => {
            let normal = collider.pose.rotation.matrix().column(2).into_owned();
            ("half space", format!("normal {}", triple(&normal)))
        }
        Shape::Sphere { radius } => ("sphere", format!("radius {}", number(*radius))),
        Shape::Capsule { radius, half } => ("capsule", round(*radius, *half)),
        Shape::Cylinder { radius, half } => ("cylinder", round(*radius, *half)),
        Shape::Box { half } => ("box", triple(&(2.0 * half))),
        Shape::Hollow { radius } => ("rope", format!("length {}", number(*radius))),
        Shape::Point => ("point", String::new()),
        Shape::Ellipsoid { radii } => ("ellipsoid", format!("radii {}", triple(radii))),
        Shape::Hull(points) => ("hull", counted(points.len(), "point", "points")),
        Shape::Mesh(surface) => ("mesh", counted(surface.triangles.len(), "triangle", "triangles")),
    }
}

/// The shape as entries of its JSON object.
fn shape_json(shape: &Shape) -> Vec<(&'static str, Value)> {
    let of = |kind: &str| ("shape", json!(kind));
    match shape {
        Shape::HalfSpace => vec![of("half_space")],
        Shape::Sphere { radius } => vec![of("sphere"), ("radius", json!(radius))],
        Shape::Capsule { radius, half } => {
            vec![of("capsule"), ("radius", json!(radius)), ("length", json!(2.0 * half))]
        }
        Shape::Cylinder { radius, half } => {
            vec![of("cylinder"), ("radius", json!(radius)), ("length", json!(2.0 * half))]
        }
        Shape::Box { half } => vec![of("box"), ("size", json!((2.0 * half).as_slice()))],
        Shape::Hollow { radius } => vec![of("rope"), ("length", json!(radius))],
        Shape::Point => vec![of("point")],
        Shape::Ellipsoid { radii } => vec![of("ellipsoid"), ("radii", json!(radii.as_slice()))],
        Shape::Hull(points) => vec![of("hull"), ("points", json!(points.len()))],
        Shape::Mesh(surface) => {
            vec![of("mesh"), ("vertices", json!(surface.vertices.len())), ("triangles", json!(surface.triangles.len()))]
        }
    }
}
