//! What is wrong in a scene file is said in one line, with file, line and key.

use super::{ONE, TWO, folder, refusal};

#[test]
fn what_is_wrong_is_said_with_file_line_and_key() {
    let folder = folder("errors");
    let ends = |a: &str, b: &str| format!("a = {{ {a} }}\nb = {{ {b} }}\n");
    let both = ends("link = \"lower\", axis = [0, 1, 0]", "link = \"world\", axis = [0, 1, 0]");
    let closing = |kind: &str, rest: &str| format!("{ONE}[[loop]]\nname = \"c\"\ntype = \"{kind}\"\n{rest}");
    // Lines 1 and 2 are the robot in most of them.
    let cases: Vec<(String, &[&str])> = vec![
        (String::new(), &["scene.toml:1: ", "no [[robot]]"]),
        ("[scene]\nname = \"x".into(), &["scene.toml:2: "]),
        ("[robot]\nurdf = \"double.urdf\"".into(), &["scene.toml:1: robot: ", "write [[robot]]"]),
        (format!("{ONE}bas = \"fixed\""), &["scene.toml:3: robot.bas: unknown field", "`base`"]),
        (format!("{ONE}[scen]\n"), &["scene.toml:3: scen: unknown field"]),
        (format!("{ONE}[simulation]\nsteps = 3"), &["scene.toml:4: simulation.steps: unknown field"]),
        (format!("{ONE}pose = {{ positon = [0, 0, 0] }}"), &["scene.toml:3: robot.pose.positon: unknown field"]),
        (format!("{ONE}pose = {{ position = [0, 0] }}"), &["scene.toml:3: robot.pose.position: ", "length 2"]),
        (
            format!("{ONE}pose = {{ position = [0, nan, 0] }}"),
            &["scene.toml:3: robot.pose.position: NaN is not finite"],
        ),
        (
            format!("{ONE}positions = {{ elbow = -.5 }}"),
            &["scene.toml:3: ", "a number needs a digit before its point, such as -0.5"],
        ),
        (format!("{ONE}positions = {{ elbow = inf }}"), &["scene.toml:3: robot.positions.elbow: inf is not finite"]),
        (format!("{ONE}positions = {{ elbow = \"up\" }}"), &["scene.toml:3: robot.positions.elbow: "]),
        (format!("{ONE}positions = {{ knee = 1 }}"), &["scene.toml:3: ", "no joint \"knee\"", "\"elbow\""]),
        (format!("{ONE}\npositions = {{ elbow = [1, 2] }}"), &["scene.toml:4: ", "\"elbow\" needs one number"]),
        (format!("{ONE}velocities = {{ tilt = 1 }}"), &["scene.toml:3: ", "\"tilt\" does not move"]),
        (format!("{ONE}base = \"flying\""), &["scene.toml:3: robot.base: ", "`fixed` or `floating`"]),
        (format!("{ONE}velocity = {{ linear = [1, 0, 0] }}"), &["scene.toml:3: robot \"double\": ", "floating"]),
        ("[[robot]]\nname = \"a\"".into(), &["scene.toml:1: robot \"a\": robot: missing field `urdf`"]),
        ("[[robot]]\nurdf = \"none.urdf\"".into(), &["scene.toml:2: robot.urdf: ", "none.urdf"]),
        ("[[robot]]\nurdf = \"ball.urdf\"\nname = \"a/b\"".into(), &["scene.toml:3: robot \"a/b\": "]),
        (format!("{ONE}{ONE}"), &["scene.toml:3: robot \"double\": ", "taken on line 1"]),
        (format!("{ONE}[simulation]\nduration = 0"), &["scene.toml:4: simulation.duration: 0 must be greater"]),
        (format!("{ONE}[simulation]\nstages = 3"), &["scene.toml:4: ", "needs a step"]),
        (format!("{ONE}[simulation]\nstep = 0.1"), &["scene.toml:4: ", "needs stages"]),
        (format!("{ONE}[simulation]\nstages = 17\nstep = 0.1"), &["scene.toml:4: ", "1 to 16"]),
        (
            format!("{ONE}[simulation]\nstages = 3\nstep = 0.1\ntolerance = 1e-3"),
            &["scene.toml:6: ", "either tolerance, or stages and step"],
        ),
        (format!("{ONE}[simulation]\nrate = 1e7"), &["scene.toml:4: ", "at most 1e6"]),
        (closing("hinge", &both), &["scene.toml:5: loop \"c\": loop.type: unknown variant `hinge`", "`revolute`"]),
        (closing("revolute", &both.replace("lower", "knee")), &["scene.toml:6: loop \"c\": ", "no link \"knee\""]),
        (
            closing("revolute", &both.replacen("[0, 1, 0]", "[0, 0, 0]", 1)),
            &["scene.toml:6: loop \"c\": the axis is zero"],
        ),
        (
            closing("revolute", &both.replacen(", axis = [0, 1, 0]", "", 1)),
            &["scene.toml:6: loop \"c\": ", "need an axis"],
        ),
        (closing("fixed", &both.replacen(", axis = [0, 1, 0]", "", 1)), &["scene.toml:3: loop \"c\": ", "at none"]),
        (closing("revolute", &format!("{both}length = 1")), &["scene.toml:8: loop \"c\": ", "\"distance\""]),
        (closing("spherical", "a = { link = \"lower\" }"), &["scene.toml:3: loop \"c\": loop: missing field `b`"]),
        (
            format!("{}[[loop]]\nname = \"c\"\ntype = \"planar\"\n{both}", closing("planar", &both)),
            &["scene.toml:8: loop \"c\": ", "taken on line 3"],
        ),
        (
            closing("spherical", &ends("link = \"lower\"", "link = \"lower\"")),
            &["scene.toml:3: loop \"c\": ", "says nothing new"],
        ),
        (
            closing("spherical", &ends("link = \"lower\"", "link = \"weight\"")),
            &["scene.toml:3: loop \"c\": ", "\"lower\" and \"weight\" are fixed to each other and 1.00e0 m"],
        ),
        (
            closing("spherical", &ends("link = \"base\"", "link = \"world\"")),
            &["scene.toml:3: loop \"c\": ", "says nothing new"],
        ),
        (
            closing("spherical", &ends("link = \"upper\", position = [0, 0, -1]", "link = \"lower\"")),
            &["scene.toml:3: loop \"c\": ", "whatever they do"],
        ),
        (
            closing("spherical", &ends("link = \"lower\", position = [1e200, 0, 0]", "link = \"world\"")),
            &["scene.toml:3: loop \"c\": ", "\"lower\" is so far away"],
        ),
        (
            closing("spherical", &ends("link = \"lens\"", "link = \"world\"")),
            &["scene.toml:3: loop \"c\": ", "\"lens\" is not simulated"],
        ),
        (
            closing(
                "distance",
                &ends("link = \"lower\", position = [0, 0, -1]", "link = \"world\", position = [0, 0, -2]"),
            ),
            &["scene.toml:3: loop \"c\": ", "no distance"],
        ),
        (
            format!("{ONE}[[spring]]\njoint = \"elbow\"\nrest_length = 1"),
            &["scene.toml:5: spring \"spring1\": ", "no rest_length"],
        ),
        (
            format!("{ONE}[[spring]]\njoint = \"elbow\"\nrest = 1"),
            &["scene.toml:3: spring \"spring1\": ", "needs its stiffness, its damping, or both"],
        ),
        (format!("{ONE}[[spring]]\nstiffness = 1"), &["scene.toml:3: spring \"spring1\": ", "either between points"]),
        (
            format!("{ONE}[[spring]]\njoint = \"elbow\"\nstiffness = -1"),
            &["scene.toml:5: spring.stiffness: -1 must not be negative"],
        ),
        (
            format!("{ONE}[[spring]]\nstiffness = 1\n{}", ends("link = \"lower\"", "link = \"world\"")),
            &["scene.toml:3: spring \"spring1\": ", "needs its rest_length"],
        ),
        (
            format!(
                "{ONE}[[spring]]\nstiffness = 1\nrest_length = 1\n{}",
                ends("link = \"lower\"", "link = \"weight\"")
            ),
            &["scene.toml:3: spring \"spring1\": ", "does nothing"],
        ),
        (format!("{ONE}[[load]]\njoint = \"weld\"\neffort = 1"), &["scene.toml:3: load on \"weld\": ", "is fixed"]),
        (format!("{ONE}[[load]]\njoint = \"elbow\""), &["scene.toml:3: ", "needs its effort"]),
        (
            format!("{ONE}[[load]]\nlink = \"base\"\nforce = [1, 0, 0]"),
            &["scene.toml:3: load on \"base\": ", "fixed in the world"],
        ),
        (format!("{ONE}[[load]]\nlink = \"lower\""), &["scene.toml:3: ", "needs a force or a torque"]),
        (format!("{ONE}[[load]]\neffort = 1"), &["scene.toml:3: ", "either on a joint or on a link"]),
        (
            format!("{TWO}[[load]]\njoint = \"hinge\"\neffort = 1"),
            &["scene.toml:8: ", "no joint \"hinge\"", "robot/name"],
        ),
    ];
    for (text, parts) in cases {
        let message = refusal(&folder, &text);
        assert!(message.lines().count() == 1, "{message}");
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?} of\n{text}");
        }
    }
}

#[test]
fn a_model_of_mujoco_is_no_robot_of_a_scene_and_the_error_says_what_to_do() {
    let folder = folder("mujoco_as_robot");
    std::fs::write(folder.join("m.xml"), "<mujoco><worldbody/></mujoco>").unwrap();
    let said = refusal(&folder, "[[robot]]\nurdf = \"m.xml\"\n");
    assert!(
        said.contains("m.xml:1: it is a model of MuJoCo, which is a whole scene and no robot of another one"),
        "{said}"
    );
    assert!(said.contains("catena simulate FILE.xml") && said.contains("--set"), "{said}");
}
