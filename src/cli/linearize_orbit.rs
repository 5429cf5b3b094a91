//! The multipliers of a motion that comes back.

use crate::cli::linearize_asked::LinearizeArgs;
use crate::cli::tables::table::{Table, number};
use crate::cli::terminal::printing::{Failure, print, print_json};
use catena::session::Simulation;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Tolerance of the run of an orbit (m): multipliers are as accurate as its motion.
const OF_ORBIT: f64 = 1e-9;

pub(crate) fn print_orbit(args: &LinearizeArgs, run: Simulation) -> Result<(), Failure> {
    let found = run.tolerance(OF_ORBIT).multipliers()?;
    let turn = |value: &nalgebra::Complex<f64>| value.arg() / std::f64::consts::TAU;
    let growth = |value: &nalgebra::Complex<f64>| value.norm().ln() / found.period;
    if args.json {
        let value = |value: &nalgebra::Complex<f64>| json!({ "multiplier": [value.re, value.im], "size": value.norm(), "turn": turn(value), "growth": growth(value) });
        return print_json(&json!({
            "catena": env!("CARGO_PKG_VERSION"),
            "input": args.input.input.display().to_string(),
            "time": found.begin,
            "period": found.period,
            "apart": found.apart,
            "multipliers": found.values.iter().map(value).collect::<Vec<Value>>(),
            "warnings": found.warnings,
        }));
    }
    let mut text = String::new();
    // Writing into a String cannot fail.
    let from = if found.begin == 0.0 { String::new() } else { format!(" from t = {} s on", number(found.begin)) };
    let (period, apart) = (number(found.period), number(found.apart));
    let _ = writeln!(text, "motion of {period} s{from}, whose end is {apart} from its start");
    let mut table = Table::new("Multipliers", &["real", "imaginary", "size", "turn", "growth [1/s]"]);
    for value in &found.values {
        let columns = [value.re, value.im, value.norm(), turn(value), growth(value)];
        table.row(columns.map(number).to_vec());
    }
    table.write(&mut text);
    for warning in &found.warnings {
        let _ = writeln!(text, "warning: {warning}");
    }
    print(text)
}
