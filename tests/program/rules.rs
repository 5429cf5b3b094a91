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

const WHEEL: &str = "<robot name='r'><link name='base'/>\
    <link name='wheel'><inertial><mass value='1'/><inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial>\
    <collision><origin rpy='1.57 0 0'/><geometry><cylinder radius='0.3' length='0.8'/></geometry></collision></link>\
    <joint name='axle' type='continuous'><parent link='base'/><child link='wheel'/><axis xyz='0 1 0'/></joint></robot>";

#[test]
fn a_wheel_that_was_turned_onto_its_axle_is_told_and_stays_as_it_is_written_where_the_rule_is_switched_off() {
    let folder = folder("wheels");
    std::fs::write(folder.join("wheel.urdf"), WHEEL).expect("written");
    let catena = |verb: &str, more: &[&str]| {
        let output = run(&folder, &[&[verb, "wheel.urdf", "--floor=-0.5"], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout).to_string()
    };
    let json = |text: String| serde_json::from_str::<serde_json::Value>(&text).expect("one JSON object");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    // π/2 − 1.57 = 7.963e-4 rad, at √(0.3² + 0.4²) = 0.5 m from the middle.
    let (angle, moved) = (7.9632679e-4, 3.98163e-4);
    let model = json(catena("model", &["--json"]));
    let wheel = &model["contact"]["wheels"][0];
    assert_eq!((&wheel["name"], &wheel["joint"]), (&"wheel".into(), &"axle".into()));
    assert!(
        (number(&wheel["angle"]) - angle).abs() < 1e-10 && (number(&wheel["moved"]) - moved).abs() < 1e-8,
        "{wheel}"
    );
    for part in ["turned", "onto the axis of", "8.0e-4", "4.0e-4", "--keep wheels", "1 shape, turned onto the axis"] {
        let text = catena("model", &[]);
        assert!(text.contains(part), "{part:?} in {text}");
    }
    let roll = |model: &serde_json::Value| {
        let shapes = model["contact"]["shapes"].as_array().expect("shapes");
        2.0 * number(&shapes[0]["orientation"][1]).asin()
    };
    assert!((roll(&model) - std::f64::consts::FRAC_PI_2).abs() < 1e-15, "{}", roll(&model));
    let kept = json(catena("model", &["--json", "--keep", "wheels"]));
    assert!((roll(&kept) - 1.57).abs() < 1e-15, "{}", roll(&kept));
    assert_eq!(kept["contact"]["wheels"], serde_json::json!([]));
    let told = json(catena("simulate", &["--json", "--no-log", "--duration", "0.1"]));
    assert_eq!(told["model"]["wheels"]["shapes"], 1);
    let lines = catena("simulate", &["--duration", "0.1", "-o", "kept.mcap", "--keep", "wheels"]);
    assert!(!lines.contains("turned onto"), "{lines}");
    // Its log says how it was made.
    let again = run(&folder, &["replay", "kept.mcap"]);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    let lines = catena("simulate", &["--no-log", "--duration", "0.1"]);
    assert!(
        lines.contains("1 shape was turned onto the axes of their joints, by up to 8.0e-4 rad and 4.0e-4 m"),
        "{lines}"
    );
}
