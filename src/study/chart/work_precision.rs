//! The work–precision picture: CPU seconds per simulated second against the error at the end.

use crate::chart::measure::SceneChart;
use crate::chart::method::Method;
use crate::chart::ratio::{Comparison, LEVELS, Reach};
use crate::chart::table::Measurement;
use crate::drawing::axis::power_of_ten;
use crate::drawing::picture::{Band, Panel, Picture, Scale, Series};
use crate::drawing::style::look;

/// Smaller errors are drawn here: below the resolution of a double at one metre.
const LEAST_ERROR: f64 = 1e-16;
/// A larger error is no answer any more [m].
const MOST_ERROR: f64 = 10.0;

/// The picture of a scene; `foreign` are the measurements of other programs, of which the ones of this scene are drawn.
pub fn work_precision_picture(chart: &SceneChart, foreign: &[Measurement]) -> Picture {
    let own = |ours: bool| -> Vec<Series> {
        Method::WITH_EVENTS
            .iter()
            .filter(|method| method.is_ours() == ours)
            .filter_map(|method| series(&chart.measurements, &method.id(), method.label(), 0))
            .collect()
    };
    let here: Vec<Measurement> = foreign.iter().filter(|one| one.scene == chart.name).cloned().collect();
    let mut names: Vec<&str> = Vec::new();
    for measurement in &here {
        if !names.contains(&measurement.method.as_str()) {
            names.push(&measurement.method);
        }
    }
    let others = names.iter().enumerate();
    let others = others.filter_map(|(number, name)| series(&here, name, (*name).to_string(), number)).collect();
    let (freedoms, bodies) = chart.size;
    let plural = if bodies == 1 { "body" } else { "bodies" };
    Picture {
        title: format!("{}: what accuracy costs", chart.name),
        subtitle: format!(
            "{bodies} {plural}, {freedoms} degrees of freedom, {} s simulated · lower and further left is better{}",
            chart.duration,
            match (chart.has_contacts, chart.has_events) {
                (true, _) => " · steps end at events; the comparators know no contacts",
                (false, true) => " · steps end at events; Euler and RK4 are regularised",
                (false, false) => "",
            }
        ),
        x: Scale::Log {
            label: "error at the end: largest distance of any body [m]".to_string(),
            least: LEAST_ERROR,
            most: MOST_ERROR,
        },
        y: Scale::Log { label: "CPU seconds per simulated second".to_string(), least: 1e-12, most: 1e12 },
        bands: bands(chart),
        panels: vec![
            Panel { heading: "catena".to_string(), series: own(true) },
            Panel { heading: "joint coordinates".to_string(), series: own(false) },
            Panel { heading: "other programs".to_string(), series: others },
        ],
        notes: notes(chart),
        marks: Vec::new(),
    }
}

fn series(measurements: &[Measurement], id: &str, label: String, foreign: usize) -> Option<Series> {
    let runs = measurements.iter().filter(|one| one.method == id).filter_map(Measurement::point);
    let points: Vec<(f64, f64)> = runs.map(|(error, cost)| (error.max(LEAST_ERROR), cost)).collect();
    // The first rungs may be so coarse that a finer one beats them in both; they would only fold the curve back.
    let beaten =
        |place: usize| points[place + 1..].iter().any(|one| one.0 < points[place].0 && one.1 <= points[place].1);
    let first = (0..points.len()).find(|&place| !beaten(place)).unwrap_or(0);
    let points = points[first..].to_vec();
    (!points.is_empty()).then(|| Series { label, look: look(id, foreign), points, markers_every: 1 })
}

fn bands(chart: &SceneChart) -> Vec<Band> {
    let reference = &chart.reference;
    let mut bands = vec![Band {
        below: reference.floor(),
        strength: 0.12,
        label: format!("noise of the reference,\n{:.0e} m", reference.floor()),
    }];
    if reference.vouched() > 2.0 * reference.floor() {
        let label = match reference.agreement {
            Some(agreement) => format!("the two references\nagree to {agreement:.0e} m"),
            None => "only one reference".to_string(),
        };
        bands.insert(0, Band { below: reference.vouched(), strength: 0.06, label });
    }
    bands
}

fn notes(chart: &SceneChart) -> Vec<String> {
    if chart.has_contacts {
        return Vec::new();
    }
    let mut notes = vec!["speed-up over the better of".to_string(), "RK4 and DOP853 at equal error".to_string()];
    let mut doubtful = false;
    for level in LEVELS {
        let comparison = Comparison::of(chart, level);
        let floor = |best: Option<crate::chart::ratio::Best>| match best.map(|best| best.reach) {
            Some(Reach::Floor(floor)) => format!("floor {floor:.0e}"),
            _ => "no run".to_string(),
        };
        let reached =
            |best: Option<crate::chart::ratio::Best>| matches!(best.map(|best| best.reach), Some(Reach::Cost(_)));
        let words = match comparison.ratio() {
            Some(ratio) => format!("{ratio:.2} ×"),
            None if reached(comparison.ours) => format!("they: {}", floor(comparison.rival)),
            None if reached(comparison.rival) => format!("catena: {}", floor(comparison.ours)),
            None => "nobody".to_string(),
        };
        let mark = if level < chart.reference.vouched() { " ?" } else { "" };
        doubtful |= level < chart.reference.vouched();
        notes.push(format!("   {} m:  {words}{mark}", power_of_ten(level.log10().round() as i32)));
    }
    if doubtful {
        notes.push("? the references differ by more".to_string());
    }
    notes
}
