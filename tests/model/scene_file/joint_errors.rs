//! What is wrong with a motor or a setting of a joint is said in one line, with file, line and key or joint.

use super::{LIMBED, TWO, folder, refusal};

#[test]
fn wrong_motors_are_refused_with_file_line_and_key() {
    let folder = folder("motor_errors");
    for (name, text) in [
        ("gap.csv", "time,value\n0,1\n\n2,1\n"),
        ("missing.csv", "0,1\n1\n"),
        ("words.csv", "0,1\n1,one\n"),
        ("order.csv", "t,q\n0,1\n2,1\n1,1\n"),
        ("twice.csv", "0,1\n1,2\n1,3\n"),
        ("nan.csv", "0,1\n1,nan\n"),
        ("infinite.csv", "0,1\ninf,1\n"),
        ("empty.csv", "time,value\n"),
        ("steep.csv", "0,1e308\n1,-1e308\n"),
    ] {
        std::fs::write(folder.join(name), text).expect("written");
    }
    std::fs::write(folder.join("bytes.csv"), b"0,1\n\xff").expect("written");
    let scene = |keys: &str| format!("{LIMBED}[[motor]]\n{keys}");
    let effort = |target: &str| scene(&format!("joint = \"hinge\"\nkind = \"effort\"\ntarget = {target}"));
    let on = |joint: &str| scene(&format!("joint = \"{joint}\"\nkind = \"effort\"\ntarget = 1"));
    let position = |keys: &str| scene(&format!("joint = \"hinge\"\nkind = \"position\"\ntarget = 1\n{keys}"));
    let velocity = |keys: &str| scene(&format!("joint = \"hinge\"\nkind = \"velocity\"\ntarget = 1\n{keys}"));
    let with = |keys: &str| effort(&format!("1\n{keys}"));
    let closing =
        "[[loop]]\nname = \"rope\"\ntype = \"distance\"\na = { link = \"link1\" }\nb = { link = \"link3\" }\n";
    // Lines 1 and 2 are the robot, line 3 is [[motor]], line 4 its joint, 5 its kind and 6 its target.
    let cases: Vec<(String, &[&str])> = vec![
        (scene("kind = \"effort\"\ntarget = 1"), &["scene.toml:3: motor: missing field `joint`"]),
        (scene("joint = \"hinge\"\ntarget = 1"), &["scene.toml:3: motor on \"hinge\": motor: missing field `kind`"]),
        (
            scene("joint = \"hinge\"\nkind = \"effort\""),
            &["scene.toml:3: motor on \"hinge\": motor: missing field `target`"],
        ),
        (
            on("hinge").replace("effort", "torque"),
            &["scene.toml:5: motor on \"hinge\": motor.kind: unknown variant `torque`", "`position`"],
        ),
        (with("ki = 1"), &["scene.toml:7: motor on \"hinge\": motor.ki: unknown field"]),
        // Its joint.
        (on("knee"), &["scene.toml:4: motor on \"knee\": ", "there is no joint \"knee\"; there are \""]),
        (on("ball"), &["scene.toml:4: motor on \"ball\": ", "several degrees of freedom", "turns about or slides"]),
        (on("sheet"), &["scene.toml:4: motor on \"sheet\": ", "several degrees of freedom"]),
        (on("free"), &["scene.toml:4: motor on \"free\": ", "several degrees of freedom"]),
        (on("weld"), &["scene.toml:4: motor on \"weld\": ", "is fixed"]),
        (on("cap"), &["scene.toml:4: motor on \"cap\": ", "it moves no mass"]),
        (on("closure"), &["scene.toml:4: motor on \"closure\": ", "closes a loop"]),
        (format!("{}\n{closing}", on("rope")), &["scene.toml:4: motor on \"rope\": ", "closes a loop"]),
        (
            format!("{}\n[[motor]]\njoint = \"limbs/hinge\"\nkind = \"effort\"\ntarget = 2", on("hinge")),
            &["scene.toml:8: motor on \"limbs/hinge\": ", "the motor of line 4", "one motor for each joint"],
        ),
        (
            format!("{TWO}[[motor]]\njoint = \"hinge\"\nkind = \"effort\"\ntarget = 1"),
            &["scene.toml:8: motor on \"hinge\": ", "robot/name"],
        ),
        // Its numbers.
        (position("kp = -1"), &["scene.toml:7: motor on \"hinge\": motor.kp: -1 must not be negative"]),
        (position("kp = nan"), &["scene.toml:7: motor on \"hinge\": motor.kp: NaN is not finite"]),
        (position("kp = 1\nkd = -2"), &["scene.toml:8: motor on \"hinge\": motor.kd: -2 must not be negative"]),
        (position("kp = 1\nkd = inf"), &["scene.toml:8: motor on \"hinge\": motor.kd: inf is not finite"]),
        (velocity("kd = -3"), &["scene.toml:7: motor on \"hinge\": motor.kd: -3 must not be negative"]),
        (with("max_effort = -1"), &["scene.toml:7: motor on \"hinge\": motor.max_effort: -1 must not be negative"]),
        (with("max_effort = nan"), &["scene.toml:7: motor on \"hinge\": motor.max_effort: NaN is not a number"]),
        (with("period = -0.1"), &["scene.toml:7: motor on \"hinge\": motor.period: -0.1 must not be negative"]),
        (with("period = inf"), &["scene.toml:7: motor on \"hinge\": motor.period: inf is not finite"]),
        (
            with("interpolation = \"smooth\""),
            &["scene.toml:7: motor on \"hinge\": motor.interpolation: unknown variant `smooth`", "`cubic`"],
        ),
        // Keys that its kind has not, or lacks.
        (position("kd = 1"), &["scene.toml:3: motor on \"hinge\": ", "needs its kp"]),
        (velocity(""), &["scene.toml:3: motor on \"hinge\": ", "needs its kd"]),
        (velocity("kd = 1\nkp = 1"), &["scene.toml:8: motor on \"hinge\": ", "has a kd, no kp"]),
        (with("kp = 1"), &["scene.toml:7: motor on \"hinge\": ", "neither kp nor kd"]),
        (with("kd = 1"), &["scene.toml:7: motor on \"hinge\": ", "neither kp nor kd"]),
        // Its target.
        (effort("nan"), &["scene.toml:6: motor on \"hinge\": motor.target: NaN is not finite"]),
        (effort("-inf"), &["scene.toml:6: motor on \"hinge\": motor.target: -inf is not finite"]),
        (
            effort("true"),
            &[
                "scene.toml:6: motor on \"hinge\": motor.target: ",
                "a number, a list of [time, value], the name of a CSV",
            ],
        ),
        (effort("[]"), &["scene.toml:6: motor on \"hinge\": ", "no values"]),
        (effort("[1, 2]"), &["scene.toml:6: motor on \"hinge\": motor.target: "]),
        (effort("[[0, 1],\n[1]]"), &["scene.toml:7: motor on \"hinge\": ", "1 numbers; give [time, value]"]),
        (effort("[[0, 1],\n[1, 2, 3]]"), &["scene.toml:7: motor on \"hinge\": ", "3 numbers"]),
        (effort("[[0, 1],\n[1, nan]]"), &["scene.toml:7: motor on \"hinge\": ", "not finite"]),
        (
            effort("[[0, 1],\n[2, 1],\n[1, 3]]"),
            &["scene.toml:8: motor on \"hinge\": ", "1 s of entry 3 is not after 2 s"],
        ),
        (effort("[[0, 1],\n[0, 2]]"), &["scene.toml:7: motor on \"hinge\": ", "0 s of entry 2 is not after 0 s"]),
        // Its CSV file.
        (effort("\"none.csv\""), &["scene.toml:6: motor on \"hinge\": none.csv: cannot be read: "]),
        (effort("\"\""), &["scene.toml:6: motor on \"hinge\": ", "cannot be read"]),
        (effort("\"gap.csv\""), &["gap.csv:3: motor on \"hinge\": the line is empty"]),
        (effort("\"missing.csv\""), &["missing.csv:2: motor on \"hinge\": \"1\" is one column"]),
        (effort("\"words.csv\""), &["words.csv:2: motor on \"hinge\": the value \"one\" is not a number"]),
        (effort("\"order.csv\""), &["order.csv:4: motor on \"hinge\": ", "1 s of entry 3 is not after 2 s"]),
        (effort("\"twice.csv\""), &["twice.csv:3: motor on \"hinge\": ", "1 s of entry 3 is not after 1 s"]),
        (effort("\"nan.csv\""), &["nan.csv:2: motor on \"hinge\": ", "not finite"]),
        (effort("\"infinite.csv\""), &["infinite.csv:2: motor on \"hinge\": ", "not finite"]),
        (effort("\"empty.csv\""), &["empty.csv: motor on \"hinge\": ", "no values"]),
        (effort("\"steep.csv\""), &["steep.csv:2: motor on \"hinge\": ", "rate is infinite"]),
        (effort("\"bytes.csv\""), &["bytes.csv:2: is not a text file"]),
    ];
    check(&folder, cases);
}

#[test]
fn wrong_settings_of_joints_are_refused_with_file_line_and_key() {
    let folder = folder("joint_errors");
    let scene = |keys: &str| format!("{LIMBED}[[joint]]\n{keys}");
    let hinge = |keys: &str| scene(&format!("name = \"hinge\"\n{keys}"));
    let on = |joint: &str| scene(&format!("name = \"{joint}\"\nfriction = 1"));
    // Lines 1 and 2 are the robot, line 3 is [[joint]] and line 4 its name.
    let cases: Vec<(String, &[&str])> = vec![
        (scene("friction = 1"), &["scene.toml:3: joint: missing field `name`"]),
        (hinge(""), &["scene.toml:3: joint \"hinge\": give its limit, restitution, friction, damping or armature"]),
        (hinge("stiffness = 1"), &["scene.toml:5: joint \"hinge\": joint.stiffness: unknown field"]),
        (
            hinge("limit = [1, -1]"),
            &["scene.toml:5: joint \"hinge\": joint.limit: ", "lower limit 1 is above the upper limit -1"],
        ),
        (hinge("limit = [nan, 1]"), &["scene.toml:5: joint \"hinge\": joint.limit: ", "NaN"]),
        (
            hinge("limit = [inf, inf]"),
            &["scene.toml:5: joint \"hinge\": joint.limit: ", "no position is between inf and inf"],
        ),
        (hinge("limit = [1]"), &["scene.toml:5: joint \"hinge\": joint.limit: ", "give [lower, upper]"]),
        (hinge("limit = 1"), &["scene.toml:5: joint \"hinge\": joint.limit: ", "[lower, upper] or \"none\""]),
        (hinge("limit = \"off\""), &["scene.toml:5: joint \"hinge\": joint.limit: ", "\"none\""]),
        (hinge("restitution = 1.5"), &["scene.toml:5: joint \"hinge\": joint.restitution: 1.5 must be from 0 to 1"]),
        (hinge("restitution = -0.1"), &["scene.toml:5: joint \"hinge\": joint.restitution: -0.1 must be from 0 to 1"]),
        (hinge("restitution = nan"), &["scene.toml:5: joint \"hinge\": joint.restitution: NaN must be from 0 to 1"]),
        (hinge("limit = \"none\"\nrestitution = 0.5"), &["scene.toml:6: joint \"hinge\": ", "no restitution"]),
        (hinge("friction = -1"), &["scene.toml:5: joint \"hinge\": joint.friction: -1 must not be negative"]),
        (hinge("damping = -1"), &["scene.toml:5: joint \"hinge\": joint.damping: -1 must not be negative"]),
        (hinge("damping = nan"), &["scene.toml:5: joint \"hinge\": joint.damping: NaN is not finite"]),
        (on("knee"), &["scene.toml:4: joint \"knee\": ", "there is no joint \"knee\"; there are \""]),
        (on("ball"), &["scene.toml:4: joint \"ball\": ", "several degrees of freedom"]),
        (on("weld"), &["scene.toml:4: joint \"weld\": ", "is fixed"]),
        (on("cap"), &["scene.toml:4: joint \"cap\": ", "it moves no mass"]),
        (on("closure"), &["scene.toml:4: joint \"closure\": ", "closes a loop"]),
        (
            format!("{}\n[[joint]]\nname = \"hinge\"\ndamping = 2", hinge("friction = 1")),
            &["scene.toml:7: joint \"hinge\": ", "the [[joint]] of line 4"],
        ),
    ];
    check(&folder, cases);
}

#[track_caller]
fn check(folder: &std::path::Path, cases: Vec<(String, &[&str])>) {
    for (text, parts) in cases {
        let message = refusal(folder, &text);
        assert!(message.lines().count() == 1, "{message}");
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?} of\n{text}");
        }
    }
}
