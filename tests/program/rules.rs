//! Rules on the command line: each is named with its condition and with what it saves, and is switched off by its name.

use crate::common::command::{self, folder, run, text};

const SCENE: &str = r#"
[scene]
name = "three"
[[robot]]
name = "slow"
urdf = "pendulum.urdf"
positions = { hinge = 0.5 }
[[robot]]
name = "fast"
urdf = "pendulum.urdf"
pose = { position = [0, 2, 0] }
velocities = { hinge = 9.0 }
[[robot]]
name = "still"
urdf = "pendulum.urdf"
pose = { position = [0, 4, 0] }
[simulation]
duration = 2.0
"#;

/// Runs the command line in a folder with the scene; returns exit code, standard output and standard error.
fn catena(test: &str, arguments: &[&str]) -> (Option<i32>, String, String) {
    let folder = command::folder(test);
    std::fs::write(folder.join("scene.toml"), SCENE).expect("written");
    let output = command::run(&folder, arguments);
    (output.status.code(), command::text(&output.stdout).to_string(), command::text(&output.stderr).to_string())
}

fn report(test: &str, arguments: &[&str]) -> serde_json::Value {
    let (code, out, err) = catena(test, arguments);
    assert_eq!(code, Some(0), "{err}");
    serde_json::from_str(&out).expect("one JSON object")
}

#[test]
fn the_report_says_which_islands_there_are_and_what_each_cost() {
    let apart = report("report", &["simulate", "scene.toml", "--json"]);
    assert_eq!((&apart["model"]["islands"], &apart["model"]["sleeping_islands"]), (&3.into(), &1.into()));
    let all = apart["islands"].as_array().expect("an array");
    assert_eq!(all.iter().map(|one| one["asleep"] == true).collect::<Vec<_>>(), [false, true], "small ones together");
    assert_eq!(all[0]["roots"], serde_json::json!(["slow/rod", "fast/rod"]));
    assert_eq!(all[1]["roots"][0], "still/rod");
    assert!(all[0]["steps"].as_u64() > Some(0) && all[1]["steps"] == 0, "{apart}");
    let together = report("report", &["simulate", "scene.toml", "--json", "--keep", "islands", "--keep", "sleep"]);
    assert_eq!((&together["model"]["islands"], together.get("islands")), (&1.into(), None));
    for joint in ["slow/hinge", "fast/hinge", "still/hinge"] {
        let position = |report: &serde_json::Value| report["joints"][joint]["position"].as_f64().expect("an angle");
        // Both are within the default tolerance of 1e-6 m, on rods of 0.6 m at most.
        assert!((position(&apart) - position(&together)).abs() < 4e-6, "{joint}");
    }
    let (_, text, _) = catena("report", &["simulate", "scene.toml", "--no-log"]);
    assert!(text.contains("islands     3, of which 1 at rest in equilibrium: not simulated"), "{text}");
}

#[test]
fn the_model_verb_shows_every_rule_with_its_condition_and_what_it_saves() {
    let (code, text, _) = catena("model", &["model", "scene.toml"]);
    assert_eq!(code, Some(0));
    for part in
        ["fixed_base", "3 links are no bodies", "3 islands", "--keep islands", "1 body, not simulated", "at rest"]
    {
        assert!(text.contains(part), "{part:?} in {text}");
    }
    let json = report("model", &["model", "scene.toml", "--json", "--keep", "sleep"]);
    let rules = json["rules"].as_array().expect("an array");
    let kept = |name: &str| rules.iter().find(|rule| rule["name"] == name).map(|rule| rule["kept"] == true);
    assert_eq!((kept("islands"), kept("sleep"), kept("fixed_base")), (Some(false), Some(true), Some(false)));
    assert_eq!(json["model"]["sleeping_islands"], 0);
}

#[test]
fn the_help_names_every_rule_that_can_be_switched_off() {
    let folder = folder("rules");
    let help = run(&folder, &["simulate", "--help"]);
    for rule in catena::mechanism::description::rules::Rule::ALL {
        assert!(text(&help.stdout).contains(rule.name()), "{} is missing: {}", rule.name(), text(&help.stdout));
    }
}

#[test]
fn a_rule_that_does_not_exist_is_refused_with_the_list() {
    for verb in ["simulate", "model"] {
        for name in ["planet", "fixed_base", ""] {
            let (code, out, err) = catena("unknown", &[verb, "scene.toml", "--keep", name]);
            assert_eq!((code, out.as_str()), (Some(2), ""), "{err}");
            assert!(err.contains("islands, sleep") && err.trim_end().lines().count() == 1, "{err}");
        }
    }
}
