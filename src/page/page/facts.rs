//! The text of a page: for a run the facts of its log, for a model its size.

use crate::mechanism::ground::words::{counted, decimals, rounded};
use crate::model::Model;
use crate::output::inspection::summary::{Summary, short};

/// A label and a text.
pub(super) type Fact = (&'static str, String);

/// The facts of a run.
pub(super) fn of_run(summary: &Summary, model: &Model) -> Vec<Fact> {
    let entry = |name: &str| summary.simulation.get(name).map(String::as_str).filter(|text| !text.is_empty());
    let mut facts = vec![("state", summary.state())];
    let asked = entry("duration").and_then(|text| text.parse::<f64>().ok()).filter(|asked| *asked > summary.duration);
    let of = asked.map_or(String::new(), |asked| format!(" of {asked} s that were asked for"));
    facts.push((
        "time",
        format!("0 to {} s{of}, {}", summary.duration, counted(summary.samples as usize, "sample", "samples")),
    ));
    facts.extend(size(model));
    if let Some(method) = entry("method") {
        let words = [
            ("", "stages", " stages"),
            ("order ", "order", ""),
            ("tolerance ", "tolerance", " m"),
            ("step ", "step", " s"),
        ];
        let words =
            words.iter().filter_map(|(before, name, after)| Some(format!(", {before}{}{after}", short(entry(name)?))));
        facts.push(("method", std::iter::once(method.to_string()).chain(words).collect()));
    }
    if let Some(error) = summary.estimated_error {
        facts.push(("accuracy", format!("estimated error of positions {error:.0e} m (order of magnitude)")));
    }
    if let Some(solver) = &summary.solver {
        let (steps, iterations, rejected) = (solver.steps, solver.iterations, solver.rejected_steps);
        facts.push(("steps", format!("{steps}, {iterations} iterations, {rejected} rejected")));
    }
    if let Some(events) = &summary.events {
        facts.push(("events", events.counts.words()));
    }
    if let Some(energy) = &summary.energy {
        facts.push((
            "energy",
            format!(
                "{} J at the start, {} J at the end; largest error {:.1e} of the largest kinetic energy",
                decimals(energy.initial),
                decimals(energy.r#final),
                energy.max_relative_error
            ),
        ));
        let parts = [
            (energy.dissipated, "taken by dampers"),
            (energy.friction, "taken by dry friction"),
            (energy.impacts, "lost in impacts"),
            (energy.work, "put in by motors and loads"),
        ];
        let parts = parts.iter().filter(|(value, _)| *value != 0.0);
        let words: Vec<String> = parts.map(|(value, what)| format!("{} J {what}", rounded(*value))).collect();
        if !words.is_empty() {
            facts.push(("balance", words.join(", ")));
        }
    }
    if let Some(constraint) = &summary.constraint {
        facts.push((
            "constraints",
            format!("largest error {:.1e} m, {:.1e} m/s", constraint.max_position, constraint.max_velocity),
        ));
    }
    if let Some(contact) = &summary.contact {
        facts.push(("contacts", contact.words()));
    }
    if let Some(version) = entry("version") {
        facts.push(("made by", format!("catena {version}: {}", entry("command_line").unwrap_or("?"))));
    }
    facts
}

/// The facts of a model that has not run.
pub(super) fn of_model(model: &Model) -> Vec<Fact> {
    let mut facts = size(model);
    let mechanism = &model.mechanism;
    let [x, y, z] = mechanism.gravity.into();
    facts.push(("mass", format!("{} kg move", rounded(mechanism.total_mass()))));
    facts.push(("gravity", format!("{x}, {y}, {z} m/s²")));
    facts
}

fn size(model: &Model) -> Vec<Fact> {
    let mechanism = &model.mechanism;
    let mut words = vec![
        counted(model.links.len(), "link", "links"),
        counted(mechanism.bodies.len(), "moving body", "moving bodies"),
    ];
    if !mechanism.loops.is_empty() {
        words.push(counted(mechanism.loops.len(), "closed loop", "closed loops"));
    }
    if !mechanism.mimics.is_empty() {
        words.push(counted(mechanism.mimics.len(), "joint follows another", "joints follow others"));
    }
    vec![("model", words.join(", "))]
}
