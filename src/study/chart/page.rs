//! The page: everything in one HTML file that needs no other file and no network.

use crate::chart::measure::SceneChart;
use crate::chart::method::Method;
use crate::chart::ratio::{Comparison, LEVELS};
use crate::chart::report::{Report, seconds, trust, words};
use crate::chart::table::Measurement;
use std::fmt::Write;

pub(crate) const STYLE: &str = "
body { font: 16px/1.5 sans-serif; color: #1e1e1e; max-width: 1320px; margin: 2em auto; padding: 0 1em; }
h1, h2 { font-weight: 600; line-height: 1.2; } h2 { margin-top: 2.5em; }
svg { width: 100%; height: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 1em 0; }
th, td { padding: .2em .9em .2em 0; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child, td.text, th.text { text-align: left; }
thead th { border-bottom: 2px solid #1e1e1e; } details { margin: 1em 0; } .small { color: #5a5a5a; font-size: 14px; }
";

/// The page of a report; `pictures` are the SVG texts of each scene.
pub fn page(report: &Report, pictures: &[Vec<String>]) -> String {
    let mut html = String::new();
    let _ = write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>catena: speed against accuracy</title>\n<style>{STYLE}</style></head>\n<body>\n\
         <h1>Speed against accuracy</h1>\n\
         <p>CPU seconds of the integration loop per simulated second, against the distance of the end of the run from a \
         reference. One thread; the fastest of several repetitions. catena {} on {}.</p>\n",
        env!("CARGO_PKG_VERSION"),
        escape(&report.machine)
    );
    ratios(&mut html, report);
    html += METHOD_NOTE;
    for (chart, pictures) in report.scenes.iter().zip(pictures) {
        scene(&mut html, chart, pictures, &report.foreign);
    }
    html += "</body>\n</html>\n";
    html
}

const METHOD_NOTE: &str = "<p class=\"small\">Ratio: cost of the cheaper of RK4 and DOP853 (articulated-body algorithm in \
joint coordinates) over the cheapest of catena, both at the same error, interpolated on logarithmic axes along the \
runs that no other run of the method beats; nothing is extrapolated. “?”: the level lies below what both references \
vouch for. A run from a tolerance that estimates its error is held against two runs of a rival, the second at a tenth of the error; one without against one. Error: largest distance over all bodies of the centre of mass and of three points on the body axes at \
the radius √(tr J / 2m).</p>\n";

fn ratios(html: &mut String, report: &Report) {
    *html += "<table>\n<thead><tr><th>scene</th><th>error [m]</th><th class=\"text\">best of RK4, DOP853</th>\
              <th class=\"text\">best of catena</th><th>ratio</th><th>tolerance with estimate, over two runs</th><th>tolerance without, over one run</th></tr></thead>\n<tbody>\n";
    for chart in &report.scenes {
        for level in LEVELS {
            let comparison = Comparison::of(chart, level);
            let doubt = if level < chart.reference.vouched() { " ?" } else { "" };
            let ratio = |ratio: Option<f64>| ratio.map_or("–".to_string(), |ratio| format!("{ratio:.2}{doubt}"));
            let _ = writeln!(
                html,
                "<tr><td>{}</td><td>{level:.0e}</td><td class=\"text\">{}</td><td class=\"text\">{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
                escape(&chart.name),
                words(comparison.rival),
                words(comparison.ours),
                ratio(comparison.ratio()),
                ratio(comparison.tolerance_ratio()),
                ratio(comparison.unestimated_ratio()),
            );
        }
    }
    *html += "</tbody>\n</table>\n";
}

fn scene(html: &mut String, chart: &SceneChart, pictures: &[String], foreign: &[Measurement]) {
    let _ = writeln!(html, "<h2>{}</h2>\n<p>{}.</p>", escape(&chart.name), escape(&trust(chart)));
    for picture in pictures {
        let _ = writeln!(html, "{}", inline(picture));
    }
    let _ = write!(
        html,
        "<details><summary>Reference runs</summary>\n<table><thead><tr><th>run</th><th>distance from the reference [m]</th></tr></thead><tbody>\n"
    );
    for (name, distance) in &chart.reference.runs {
        let _ = writeln!(html, "<tr><td>{}</td><td>{distance:.1e}</td></tr>", escape(name));
    }
    *html += "</tbody></table></details>\n<details><summary>All measurements</summary>\n<table>\n<thead><tr><th>method</th>\
              <th class=\"text\">setting</th><th>error [m]</th><th>CPU per simulated second</th><th>steps</th>\
              <th>iterations or evaluations</th><th>thrown away</th><th>energy error</th><th class=\"text\">ended</th></tr></thead>\n<tbody>\n";
    let others = foreign.iter().filter(|one| one.scene == chart.name);
    for one in chart.measurements.iter().chain(others) {
        let number = |value: f64| if value.is_finite() { format!("{value:.2e}") } else { String::new() };
        let count = |value: Option<usize>| value.map_or(String::new(), |count| count.to_string());
        let cost = one.cpu_seconds_per_simulated_second;
        let name = Method::from_id(&one.method).map_or(one.method.clone(), |method| {
            if method.is_ours() { format!("catena, {}", method.label()) } else { method.label() }
        });
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td class=\"text\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"text\">{}</td></tr>",
            escape(&name),
            escape(&one.setting),
            number(one.error),
            if cost.is_finite() { seconds(cost) } else { String::new() },
            count(one.steps),
            count(one.iterations),
            count(one.rejected_steps),
            number(one.energy_error),
            escape(&one.ended.to_string()),
        );
    }
    *html += "</tbody>\n</table></details>\n";
}

pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The text of an SVG file as an element of a page, as wide as the page.
pub(crate) fn inline(picture: &str) -> String {
    // A declaration in front of the element belongs to a file of its own only, and so does its size.
    let start = picture.find("<svg").unwrap_or(0);
    let element = &picture[start..];
    let sized = element.strip_prefix("<svg width=\"").and_then(|rest| rest.split_once("height=\""));
    match sized.and_then(|(_, rest)| rest.split_once('"')) {
        Some((_, rest)) => format!("<svg{rest}"),
        None => element.to_string(),
    }
}
