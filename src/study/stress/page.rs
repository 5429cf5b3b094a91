//! The page: all maps in one HTML file that needs no other file and no network.

use crate::chart::page::{STYLE, escape, inline};
use crate::stress::cell::{Ended, Verdict};
use crate::stress::map::Map;
use crate::stress::problem::BUDGET;
use std::collections::BTreeMap;
use std::fmt::Write;

/// The page of some maps; `pictures` are their SVG texts, `machine` is the processor.
pub fn page(maps: &[Map], pictures: &[String], machine: &str) -> String {
    let mut html = String::new();
    let _ = write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>catena: where which method fails</title>\n<style>{STYLE}</style></head>\n<body>\n\
         <h1>Where which method fails</h1>\n\
         <p>Every cell is a run to the end of a problem. Blue: it came to the right end, to 10⁻⁶ (dark) or 10⁻² (light) of the size of the \
         mechanism. Red, crossed: it came to a wrong end and said nothing; orange, upright: it warned that the steps were beyond its \
         limit of stability, that its energy does not balance, or until when its accuracy would hold. Yellow, barred: it stopped with an error. Grey, dotted: it was \
         cut after work of about {BUDGET} s of CPU time (more for large and long problems), or when that much was foreseeable. White: the method does not know such mechanisms. Right answers are runs with 9 \
         stages to rounding, two of which agree. catena {} on {}.</p>\n",
        env!("CARGO_PKG_VERSION"),
        escape(machine)
    );
    for (map, picture) in maps.iter().zip(pictures) {
        section(&mut html, map, picture);
    }
    html += "</body>\n</html>\n";
    html
}

fn section(html: &mut String, map: &Map, picture: &str) {
    let problem = &map.thinned.problem;
    let _ = writeln!(html, "<h2>{}</h2>\n<p>{}</p>", escape(problem.title), escape(problem.scene));
    let _ = writeln!(html, "{}", inline(picture));
    *html += "<table>\n<thead><tr><th>method</th>";
    for verdict in Verdict::ALL {
        let _ = write!(html, "<th>{}</th>", verdict.word());
    }
    *html += "</tr></thead>\n<tbody>\n";
    for method in map.methods {
        let _ = write!(html, "<tr><td>{}</td>", escape(&method.label()));
        for verdict in Verdict::ALL {
            let _ = write!(html, "<td>{}</td>", map.count(method, verdict));
        }
        *html += "</tr>\n";
    }
    *html += "</tbody>\n</table>\n<details><summary>Right answers</summary>\n<table><thead><tr>";
    let _ = writeln!(html, "<th>{}</th><th class=\"text\">answer</th></tr></thead><tbody>", escape(problem.axis));
    for (answer, &place) in map.answers.iter().zip(&map.thinned.places) {
        let words = answer.refusal.map_or_else(|| answer.source.clone(), |reason| format!("none: {reason}"));
        let label = escape(problem.difficulties[place]);
        let _ = writeln!(html, "<tr><td>{label}</td><td class=\"text\">{}</td></tr>", escape(&words));
    }
    *html += "</tbody></table></details>\n<details><summary>Errors and warnings</summary>\n<table><thead><tr><th>method</th>\
              <th>cells</th><th class=\"text\">kind</th><th class=\"text\">for instance</th></tr></thead><tbody>\n";
    for ((method, kind), (count, example)) in messages(map) {
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td>{count}</td><td class=\"text\">{}</td><td class=\"text\">{}</td></tr>",
            escape(&method),
            escape(&kind),
            escape(&example)
        );
    }
    *html += "</tbody></table></details>\n";
}

/// For each method and kind: the number of cells, and the words of the first.
fn messages(map: &Map) -> BTreeMap<(String, String), (usize, String)> {
    let mut all = BTreeMap::new();
    let difficulties = &map.thinned.problem.difficulties;
    let mut add = |id: String, kind: &str, words: String| {
        all.entry((id, kind.to_string())).or_insert((0, words)).0 += 1;
    };
    for cell in &map.cells {
        let place = || format!("{}, {}: ", difficulties[cell.place], cell.setting);
        match &cell.ended {
            Ended::Failed(failure) => add(cell.method.id(), failure.name, place() + &failure.message),
            Ended::NotApplicable(reason) => add(cell.method.id(), "not applicable", (*reason).to_string()),
            Ended::Survived | Ended::TimedOut { .. } => {}
        }
        if let Some(warning) = &cell.warning {
            add(cell.method.id(), "warning", place() + warning);
        }
    }
    all
}
