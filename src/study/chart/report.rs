//! The files of a chart: for every scene two pictures as SVG and PNG, for all of them one CSV, one page and one text table.

use crate::chart::measure::SceneChart;
use crate::chart::ratio::{Best, Comparison, LEVELS, Reach};
use crate::chart::table::Measurement;

/// The suffix that turns the name of a scene's first picture into the name of its second.
pub const ENERGY: &str = "_energy";

/// The measured scenes, and the input with which other programs measure them.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The scenes, in the order of the input.
    pub scenes: Vec<SceneChart>,
    /// Measurements of other programs.
    pub foreign: Vec<Measurement>,
    /// The processor, for the page.
    pub machine: String,
}

impl Report {
    /// Everything that was measured, other programs last.
    pub fn measurements(&self) -> Vec<Measurement> {
        let own = self.scenes.iter().flat_map(|chart| &chart.measurements);
        let known = |one: &&Measurement| self.scenes.iter().any(|chart| chart.name == one.scene);
        own.chain(self.foreign.iter().filter(known)).cloned().collect()
    }

    /// The ratios as text for a terminal.
    pub fn summary(&self) -> String {
        let mut text = format!(
            "{:<24} {:>7}  {:>26}  {:>26}  {:>7}  {:>9}  {:>11}\n",
            "scene", "error", "best of RK4, DOP853", "best of catena", "ratio", "tolerance", "no estimate"
        );
        for chart in &self.scenes {
            for level in LEVELS {
                let comparison = Comparison::of(chart, level);
                let ratio = |ratio: Option<f64>| ratio.map_or("-".to_string(), |ratio| format!("{ratio:.2}"));
                text += &format!(
                    "{:<24} {level:>7.0e}  {:>26}  {:>26}  {:>7}  {:>9}  {:>11}\n",
                    chart.name,
                    words(comparison.rival),
                    words(comparison.ours),
                    ratio(comparison.ratio()),
                    ratio(comparison.tolerance_ratio()),
                    ratio(comparison.unestimated_ratio()),
                );
            }
            text += &format!("{:<24} {}\n", "", trust(chart));
        }
        text
    }
}

/// Method and cost, or the reason why there is no method.
pub fn words(best: Option<Best>) -> String {
    match best {
        None => "no run".to_string(),
        Some(Best { method, reach: Reach::Cost(cost) }) => format!("{}, {} /s", method.id(), seconds(cost)),
        Some(Best { reach: Reach::Floor(floor), .. }) => format!("not reached: floor {floor:.0e}"),
        Some(Best { reach: Reach::Nothing, .. }) => "no run".to_string(),
    }
}

/// How far the reference can be trusted.
pub fn trust(chart: &SceneChart) -> String {
    let reference = &chart.reference;
    let both = match reference.agreement {
        Some(agreement) => format!("the two formulations agree to {agreement:.1e} m"),
        None => "only one formulation reached the end".to_string(),
    };
    let cut = if chart.interrupted {
        "; interrupted"
    } else if chart.out_of_budget {
        "; the budget ran out"
    } else {
        ""
    };
    format!("{both}; reference: {}, scatter {:.1e} m{cut}", reference.source, reference.scatter)
}

/// A time with a unit that suits its size.
pub fn seconds(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{s:.2} s"),
        s if s >= 1e-3 => format!("{:.3} ms", 1e3 * s),
        s => format!("{:.2} µs", 1e6 * s),
    }
}
