//! The arguments of the `catena simulate` that makes a run again. Logs contain them; `catena replay` and pages read them.
//!
//! Numbers have all their digits.

use crate::mechanism::description::rules::Rule;
use crate::model::Base;
use crate::session::asked::Asked;
use crate::session::world::World;
use std::path::Path;

fn listed(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// The arguments of a run, word by word, from the subcommand on.
pub(crate) fn words(
    input: &Path,
    world: &World,
    asked: &Asked,
    kept: &[Rule],
    positions: &[(String, Vec<f64>)],
    velocities: &[(String, Vec<f64>)],
) -> Vec<String> {
    let World { base, base_pose, gravity, without, floor, contact, packages, xacro, set, hold, keyframe } = world;
    let mut words = vec!["simulate".to_string(), input.display().to_string()];
    let mut say = |option: &str, value: String| words.push(format!("--{option}={value}"));
    if let Some(base) = base {
        say("base", if *base == Base::Floating { "floating" } else { "fixed" }.to_string());
    }
    base_pose.iter().for_each(|pose| say("base-pose", listed(pose)));
    gravity.iter().for_each(|gravity| say("gravity", listed(gravity)));
    without.iter().for_each(|left| say("without", left.name().to_string()));
    floor.iter().for_each(|height| say("floor", height.to_string()));
    contact.iter().for_each(|touching| say("contact", touching.name().to_string()));
    packages.iter().for_each(|(name, folder)| say("package", format!("{name}={}", folder.display())));
    xacro.iter().for_each(|(name, value)| say("xacro", format!("{name}:={value}")));
    keyframe.iter().for_each(|name| say("keyframe", name.clone()));
    let mut held = None;
    if let Some(hold) = hold {
        let gains = [("kp", hold.kp), ("kd", hold.kd), ("gravity", hold.gravity)];
        let gains: Vec<String> = gains.iter().filter_map(|(name, gain)| Some(format!("{name}={}", (*gain)?))).collect();
        match gains.is_empty() {
            true => held = Some("--hold".to_string()),
            false => say("hold", gains.join(",")),
        }
    }
    set.iter().for_each(|(key, given)| say("set", format!("{key}={}", given.number)));
    kept.iter().for_each(|rule| say("keep", rule.name().to_string()));
    positions.iter().for_each(|(joint, values)| say("position", format!("{joint}={}", listed(values))));
    velocities.iter().for_each(|(joint, values)| say("velocity", format!("{joint}={}", listed(values))));
    let Asked { duration, tolerance, no_estimate, fixed, reversible, precise, rate } = asked;
    duration.iter().for_each(|duration| say("duration", duration.to_string()));
    tolerance.iter().for_each(|tolerance| say("tolerance", tolerance.to_string()));
    if let Some((stages, step)) = fixed {
        say("stages", stages.to_string());
        say("step", step.to_string());
    }
    rate.iter().for_each(|rate| say("rate", rate.to_string()));
    words.extend(no_estimate.then(|| "--no-estimate".to_string()));
    words.extend(held);
    words.extend(reversible.then(|| "--reversible".to_string()));
    words.extend(precise.then(|| "--precise".to_string()));
    words
}
