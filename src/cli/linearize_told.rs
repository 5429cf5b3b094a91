//! Linear equations as text and as JSON.

use crate::cli::linearize_asked::LinearizeArgs;
use crate::cli::tables::table::{Table, number};
use catena::mechanism::ground::words::counted;
use catena::session::{EigenvalueSlopes, Linear, Mode};
use nalgebra::DMatrix;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::fmt::Write as _;

pub(crate) fn as_text(linear: &Linear, slopes: &[EigenvalueSlopes]) -> String {
    let mut text = String::new();
    let at = match linear.iterations {
        Some(iterations) => {
            format!("about the equilibrium, found in {}", counted(iterations, "iteration", "iterations"))
        }
        None => format!("about t = {} s", number(linear.time)),
    };
    // Writing into a String cannot fail.
    let _ =
        writeln!(text, "{}: {}", counted(linear.names.len(), "independent coordinate", "independent coordinates"), at);
    if linear.velocities.len() < linear.names.len() {
        let count = counted(linear.velocities.len(), "of their velocities is", "of their velocities are");
        let _ = writeln!(text, "{count} independent, because contacts roll");
    }
    if linear.iterations.is_none() && linear.largest_acceleration > 0.0 {
        let _ =
            writeln!(text, "not an equilibrium: joints accelerate by up to {}", number(linear.largest_acceleration));
    }
    for (joint, reason) in &linear.stuck {
        let _ = writeln!(text, "{joint} is stuck: {reason}");
    }
    for joint in &linear.saturated {
        let _ = writeln!(text, "the motor of {joint} is at its bound");
    }
    if linear.sticking_contacts > 0 {
        let _ = writeln!(text, "{}", counted(linear.sticking_contacts, "contact sticks", "contacts stick"));
    }
    if linear.rolling_contacts > 0 {
        let _ = writeln!(text, "{}", counted(linear.rolling_contacts, "contact rolls", "contacts roll"));
    }
    if linear.sliding_contacts > 0 {
        let _ = writeln!(text, "{}", counted(linear.sliding_contacts, "contact slides", "contacts slide"));
    }
    let head = ["mode", "frequency [Hz]", "damping ratio", "time constant [s]", "stable", "largest parts"];
    let mut table = Table::new("Modes", &head);
    for (index, mode) in linear.modes.iter().enumerate() {
        table.row(vec![
            (index + 1).to_string(),
            number(mode.frequency),
            mode.damping_ratio.map_or(String::new(), number),
            mode.time_constant.map_or(String::new(), number),
            mode.stability.word().to_string(),
            largest_parts(linear, mode),
        ]);
    }
    table.write(&mut text);
    if !slopes.is_empty() {
        let head: Vec<String> = slopes.iter().map(|of| format!("d frequency/d {} [Hz per unit]", of.key)).collect();
        let head: Vec<&str> = std::iter::once("mode").chain(head.iter().map(String::as_str)).collect();
        let mut table = Table::new("Derivatives of frequencies", &head);
        for mode in 0..linear.modes.len() {
            let own = slopes.iter().map(|of| of.by[mode].map_or("none".into(), |by| number(by.im / TAU)));
            table.row(std::iter::once((mode + 1).to_string()).chain(own).collect());
        }
        table.write(&mut text);
    }
    text
}

/// The three largest parts of a mode.
fn largest_parts(linear: &Linear, mode: &Mode) -> String {
    const SHOWN: usize = 3;
    const LEAST: f64 = 0.1;
    let mut parts: Vec<usize> = (0..mode.shape.len()).collect();
    parts.sort_by(|&one, &other| mode.shape[other].norm().total_cmp(&mode.shape[one].norm()));
    let largest = parts.first().map_or(0.0, |&part| mode.shape[part].norm());
    let shown = parts.iter().take(SHOWN).filter(|&&part| mode.shape[part].norm() >= LEAST * largest);
    let worded = shown.map(|&part| {
        let value = mode.shape[part];
        let sign = if value.re < 0.0 { -1.0 } else { 1.0 };
        format!("{} {:.2}", linear.freedoms[part], sign * value.norm())
    });
    worded.collect::<Vec<_>>().join(", ")
}

pub(crate) fn as_json(args: &LinearizeArgs, linear: &Linear, slopes: &[EigenvalueSlopes]) -> Value {
    let modes: Vec<Value> = linear
        .modes
        .iter()
        .map(|mode| {
            json!({
                "eigenvalue": [mode.eigenvalue.re, mode.eigenvalue.im],
                "frequency": mode.frequency,
                "damping_ratio": mode.damping_ratio,
                "time_constant": mode.time_constant,
                "stable": mode.stability.word(),
                "shape": mode.shape.iter().map(|entry| [entry.re, entry.im]).collect::<Vec<_>>(),
            })
        })
        .collect();
    let stuck: Vec<Value> =
        linear.stuck.iter().map(|(joint, reason)| json!({ "joint": joint, "reason": reason })).collect();
    let mut report = json!({
        "catena": env!("CARGO_PKG_VERSION"),
        "input": args.input.input.display().to_string(),
        "time": linear.time,
        "equilibrium": linear.iterations.is_some(),
        "iterations": linear.iterations,
        "largest_acceleration": linear.largest_acceleration,
        "q": linear.q,
        "v": linear.v,
        "coordinates": linear.names,
        "units": linear.units,
        "velocities": linear.velocities,
        "A": rows(&linear.a),
        "freedoms": linear.freedoms,
        "B": rows(&linear.b),
        "targets": linear.targets,
        "B_targets": rows(&linear.b_targets),
        "inertia": rows(&linear.inertia),
        "damping": rows(&linear.damping),
        "stiffness": rows(&linear.stiffness),
        "modes": modes,
        "stuck": stuck,
        "saturated": linear.saturated,
        "sticking_contacts": linear.sticking_contacts,
        "rolling_contacts": linear.rolling_contacts,
        "sliding_contacts": linear.sliding_contacts,
    });
    if !slopes.is_empty() {
        let of = |of: &EigenvalueSlopes| {
            let by =
                of.by.iter().map(|by| by.map(|by| json!({ "eigenvalue": [by.re, by.im], "frequency": by.im / TAU })));
            json!({ "key": of.key, "modes": by.collect::<Vec<Option<Value>>>() })
        };
        report["by"] = slopes.iter().map(of).collect();
    }
    if let Some(step) = args.discrete {
        let (a, [b, b_targets]) = linear.discrete(step);
        report["discrete"] = json!({ "step": step, "A": rows(&a), "B": rows(&b), "B_targets": rows(&b_targets) });
    }
    report
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}
