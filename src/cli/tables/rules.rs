//! The part of `catena model` about simplifications: the rules, what each of them saves, and the islands.

use crate::cli::tables::table::Table;
use catena::instant::holding::locked::locked_bodies;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::ground::words::counted;
use catena::mechanism::structure::islands::Island;
use catena::mechanism::structure::special_bodies::{
    pivoted_bodies, point_bodies, sliding_bodies, spherical_bodies, tumbling_bodies,
};
use catena::model::{Model, ReductionRule};
use catena::simulation::parallel::partition::Plan;
use catena::stepping::trees::other_tree::other_tree;
use serde_json::{Value, json};

/// The effect of a rule here.
struct Applied {
    name: &'static str,
    condition: &'static str,
    /// How many links, islands or bodies it is about.
    count: usize,
    /// The saving in words; empty without an effect.
    saved: String,
    /// How to switch it off, if that is possible.
    switch: Option<Rule>,
}

/// Every rule, in the order in which they are tried.
fn applied(model: &Model, cut: usize, plan: &Plan, kept: &[Rule]) -> Vec<Applied> {
    let reduction = |rule: ReductionRule| {
        let count = model.reductions.iter().filter(|reduction| reduction.rule == rule).count();
        let links = counted(count, "link is no body", "links are no bodies");
        let saved = if count > 0 { links } else { String::new() };
        Applied { name: rule.name(), condition: rule.reason(), count, saved, switch: None }
    };
    let bodies_in_space = |applies: fn(&Mechanism) -> Vec<bool>| -> usize {
        plan.spatial(kept).map(|island| counted_true(&applies(&island.mechanism))).sum()
    };
    let optional = |rule: Rule| {
        let count = match rule {
            Rule::Wheels => model.contact.wheels.len(),
            Rule::Islands if plan.islands.len() > 1 => plan.islands.len(),
            Rule::Islands => 0,
            Rule::Sleep => plan.sleeping(),
            Rule::Locked => locked_bodies(&model.mechanism).len(),
            Rule::Tree => cut,
            Rule::Planar => plan.planar().map(|island| island.mechanism.bodies.len()).sum(),
            Rule::Translation => bodies_in_space(sliding_bodies),
            Rule::Points => bodies_in_space(point_bodies),
            Rule::Spheres => bodies_in_space(spherical_bodies),
            Rule::Pivots => bodies_in_space(pivoted_bodies),
            Rule::Tumblers => bodies_in_space(tumbling_bodies),
            Rule::Crowds => model.mechanism.nonsmooth.pairs.len(),
        };
        let saved = match rule {
            rule if kept.contains(&rule) => "switched off".to_string(),
            _ if count == 0 => String::new(),
            Rule::Wheels => format!("{}, {}", counted(count, "shape", "shapes"), rule.saving()),
            Rule::Islands => format!("{count} islands, {}", rule.saving()),
            Rule::Sleep => {
                let sleeping = plan.islands.iter().filter(|(_, asleep)| *asleep);
                let bodies = sleeping.map(|(island, _)| island.mechanism.bodies.len()).sum();
                format!("{}, {}", counted(bodies, "body", "bodies"), rule.saving())
            }
            Rule::Locked => format!("{}, {}", counted(count, "joint", "joints"), rule.saving()),
            Rule::Tree => {
                let cut = counted(count, "other joint is cut", "other joints are cut");
                format!("{cut}, {}", rule.saving())
            }
            Rule::Crowds => format!("{}, {}", counted(count, "pair", "pairs"), rule.saving()),
            Rule::Planar | Rule::Translation | Rule::Points | Rule::Spheres | Rule::Pivots | Rule::Tumblers => {
                format!("{}, {}", counted(count, "body", "bodies"), rule.saving())
            }
        };
        Applied { name: rule.name(), condition: rule.condition(), count, saved, switch: Some(rule) }
    };
    ReductionRule::ALL.into_iter().map(reduction).chain(Rule::ALL.into_iter().map(optional)).collect()
}

/// The joints that a run cuts in place of loops of the file, with those loops, island by island.
fn joints_cut(plan: &Plan, kept: &[Rule]) -> Vec<(String, String)> {
    let of_island = |island: &Island| {
        let mechanism = &island.mechanism;
        let names = other_tree(mechanism, &[], kept).map(|(tree, _)| {
            let joints = tree.cut_joints().map(|body| mechanism.bodies[body].joint.name.clone());
            let loops = tree.hung_loops().map(|closing| mechanism.loops[closing].name.clone());
            joints.zip(loops).collect()
        });
        names.unwrap_or_default()
    };
    let awake = plan.islands.iter().filter(|(_, asleep)| !asleep);
    awake.flat_map(|(island, _)| -> Vec<(String, String)> { of_island(island) }).collect()
}

/// The rules and islands as entries of the JSON report.
pub fn as_json(model: &Model, plan: &Plan, kept: &[Rule]) -> Vec<(&'static str, Value)> {
    let cut = joints_cut(plan, kept);
    let rules = applied(model, cut.len(), plan, kept).into_iter().map(|rule| {
        json!({
            "name": rule.name,
            "condition": rule.condition,
            "count": rule.count,
            "optional": rule.switch.is_some(),
            "kept": rule.switch.is_some_and(|switch| kept.contains(&switch)),
        })
    });
    let islands = plan.islands.iter().map(|(island, asleep)| {
        json!({
            "roots": island.roots().collect::<Vec<_>>(),
            "bodies": island.mechanism.bodies.len(),
            "asleep": asleep,
        })
    });
    let (cut, hung): (Vec<String>, Vec<String>) = cut.into_iter().unzip();
    let tree = json!({ "cut_joints": cut, "joined_loops": hung });
    vec![("rules", rules.collect()), ("islands", islands.collect()), ("spanning_tree", tree)]
}

/// The rules, the islands if there are several, and the joints that are cut in place of loops, as tables for people.
pub fn tables(model: &Model, plan: &Plan, kept: &[Rule]) -> [Table; 3] {
    let mut islands = Table::new("Islands", &["island", "bodies", "hangs on the world by", "state"]);
    if plan.islands.len() > 1 {
        for (number, (island, asleep)) in plan.islands.iter().enumerate() {
            islands.row(vec![
                (number + 1).to_string(),
                island.mechanism.bodies.len().to_string(),
                roots(island),
                if *asleep { "at rest" } else { "moves" }.to_string(),
            ]);
        }
    }
    let mut rules =
        Table::new("Rules that make the model smaller", &["rule", "applies where", "here", "switched off by"]);
    let joints = joints_cut(plan, kept);
    for rule in applied(model, joints.len(), plan, kept) {
        rules.row(vec![
            rule.name.to_string(),
            rule.condition.to_string(),
            if rule.saved.is_empty() { "–".to_string() } else { rule.saved },
            rule.switch.map_or_else(String::new, |rule| format!("--keep {}", rule.name())),
        ]);
    }
    let mut cut = Table::new("Joints that are cut in place of loops", &["joint that is cut", "loop that is not"]);
    joints.into_iter().for_each(|(joint, closing)| cut.row(vec![joint, closing]));
    [islands, rules, cut]
}

fn counted_true(of_bodies: &[bool]) -> usize {
    of_bodies.iter().filter(|&&applies| applies).count()
}

/// The bodies of an island that hang on the world, the first few by name.
fn roots(island: &Island) -> String {
    const NAMED: usize = 3;
    let names: Vec<&str> = island.roots().collect();
    let mut text = names.iter().take(NAMED).copied().collect::<Vec<_>>().join(", ");
    if names.len() > NAMED {
        text += &format!(" and {} more", names.len() - NAMED);
    }
    text
}
