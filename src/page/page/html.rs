//! The file of a page: its parts put together, without any reference to other files.
//!
//! | part in `assets/`       | what it is                                                       |
//! |-------------------------|------------------------------------------------------------------|
//! | `page.html`, `page.css` | frame and look                                                   |
//! | `three.min.js`          | three.js r187 with its orbit controls, as `assets/README.md` says how it was bundled; MIT |
//! | `uplot.min.js`, `.css`  | uPlot 1.6.32; MIT                                                |
//! | all other `.js`         | ours, in the order of [`SCRIPTS`]; each begins with what it does |

/// Our scripts, each of which uses those before it alone.
const SCRIPTS: [&str; 18] = [
    include_str!("assets/packed.js"),
    include_str!("assets/theme.js"),
    include_str!("assets/poses.js"),
    include_str!("assets/surfaces.js"),
    include_str!("assets/view.js"),
    include_str!("assets/robot.js"),
    include_str!("assets/obstacles.js"),
    include_str!("assets/collision_shapes.js"),
    include_str!("assets/forces.js"),
    include_str!("assets/arrows.js"),
    include_str!("assets/trails.js"),
    include_str!("assets/curves.js"),
    include_str!("assets/phase.js"),
    include_str!("assets/timeline.js"),
    include_str!("assets/second.js"),
    include_str!("assets/panels.js"),
    include_str!("assets/joints.js"),
    include_str!("assets/main.js"),
];

/// A page with this title, header (JSON) and packed arrays (base64).
pub(super) fn page(title: &str, header: &str, packed: &str) -> String {
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    // In a script element only this could end it.
    let header = header.replace('<', "\\u003c");
    let style = [include_str!("assets/uplot.min.css"), include_str!("assets/page.css")].concat();
    let parts = [
        ("{{title}}", title.as_str()),
        ("{{style}}", style.as_str()),
        ("{{header}}", header.as_str()),
        ("{{packed}}", packed),
        ("{{three}}", include_str!("assets/three.min.js")),
        ("{{uplot}}", include_str!("assets/uplot.min.js")),
    ];
    let scripts = SCRIPTS.concat();
    let mut text = String::with_capacity(packed.len() + 1_000_000);
    let mut rest = include_str!("assets/page.html");
    for (mark, part) in parts.into_iter().chain([("{{scripts}}", scripts.as_str())]) {
        // The template has each mark once, in this order.
        let (before, after) = rest.split_once(mark).unwrap_or((rest, ""));
        text.push_str(before);
        text.push_str(part);
        rest = after;
    }
    text.push_str(rest);
    text
}
