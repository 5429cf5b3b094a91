//! `catena model`: the parts of the input, the reductions with their reasons, and the mechanism that will be simulated.

use crate::cli::arguments::input::InputArgs;
use crate::cli::page_files::{check_page, write_page};
use crate::cli::tables::table::{Table, number, triple};
use crate::cli::tables::{contact_tables, couplings, joint_tables, rules};
use crate::cli::terminal::printing::{Failure, print, print_json};
use catena::instant::start::assembly::{Redundancy, redundancy, redundancy_counted};
use catena::mechanism::description::joint::wxyz_from_rotation;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::ground::words::counted;
use catena::mechanism::motion::state::State;
use catena::model::{JointRecord, LinkFrame, Model, ReductionRule, position_names};
use catena::output::page::{MESH_LIMIT, PageOptions, PageTable, model_page};
use catena::output::report::ModelReport;
use catena::scene::{Scene, Warning, warning_lines};
use catena::session::Loaded;
use catena::simulation::parallel::partition::Plan;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Show the links and joints that were read, the parts left out and why, and the mechanism that will be simulated
#[derive(Clone, Debug, clap::Args)]
pub struct ModelArgs {
    #[command(flatten)]
    pub input: InputArgs,

    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,

    /// List all numbers that a sweep can vary: key path and value
    #[arg(long, conflicts_with_all = ["json", "output"])]
    pub parameters: bool,

    /// Write a page that shows the robot in 3-D, with a slider for each joint; any browser opens it
    #[arg(short, long, value_name = "FILE.html", value_parser = crate::cli::arguments::outputs::output_file())]
    pub output: Option<PathBuf>,

    /// Most triangles of all meshes of the page together; larger meshes are simplified, 0 leaves meshes out
    #[arg(long, value_name = "TRIANGLES", default_value_t = MESH_LIMIT, requires = "output")]
    pub mesh_limit: usize,
}

/// Runs the verb.
///
/// # Errors
/// [`Failure`]: 2 for bad input, 1 if standard output cannot be written.
pub fn run(args: &ModelArgs) -> Result<(), Failure> {
    if args.parameters {
        return print(parameters(&args.input.world.scene(&args.input.input).map_err(Failure::input)?));
    }
    let mut loaded = args.input.load().map_err(Failure::input)?;
    let state = match loaded.initial_state(&[], &[], None) {
        Ok(state) => state,
        // A model whose loops do not close is shown all the same, with a warning.
        Err(error) => {
            let warning = Warning::odd(loaded.model.path(), None, None, error.problem().to_string());
            loaded.model.warnings.push(warning);
            loaded.unassembled_state().map_err(Failure::input)?
        }
    };
    args.input.refuse_warnings(&loaded.model).map_err(Failure::input)?;
    let kept = &args.input.keep[..];
    let (redundancy, plan) = counts(&loaded, &state, kept);
    let model = &loaded.model;
    let described = Described { model, start: &state, redundancy: &redundancy, plan: &plan, kept };
    if let Some(page) = &args.output {
        check_page(page, model.files()).map_err(Failure::input)?;
        let tables = page_tables(&loaded, &state, kept);
        let text = model_page(model, &state, &PageOptions { mesh_limit: args.mesh_limit, tables });
        write_page(page, &text)?;
    }
    match (args.json, &args.output) {
        (true, _) => print_json(&as_json(&described)),
        (false, Some(page)) => {
            print(format_args!("{}: {} with a slider for each joint\n", page.display(), model.mechanism.name))
        }
        (false, None) => print(as_text(&described)),
    }
}

/// The key paths of all numbers of a scene, with what the files say.
fn parameters(scene: &Scene) -> String {
    let mut lines = String::new();
    for parameter in scene.parameters() {
        let said = parameter.said().map_or_else(|| "-".to_string(), |number| number.to_string());
        let _ = writeln!(lines, "{}  {said}", parameter.key());
    }
    lines
}

/// The description of a model.
struct Described<'d> {
    model: &'d Model,
    start: &'d State,
    redundancy: &'d Redundancy,
    plan: &'d Plan,
    kept: &'d [Rule],
}

fn as_json(&Described { model, start, redundancy, plan, kept }: &Described) -> Value {
    let mechanism = &model.mechanism;
    let body_name = |body: Option<usize>| body.map(|body| mechanism.bodies[body].name.as_str());
    let mut links_of: Vec<Vec<&LinkFrame>> = vec![Vec::new(); mechanism.bodies.len()];
    for link in &model.links {
        if let Some(body) = link.body {
            links_of[body].push(link);
        }
    }
    let bodies: Vec<Value> = mechanism
        .bodies
        .iter()
        .enumerate()
        .map(|(index, body)| {
            let links: Vec<&str> = links_of[index].iter().map(|link| link.name.as_str()).collect();
            // The principal frame as people see it: in the link that heads the body.
            let head = links_of[index].iter().find(|link| link.name == body.name);
            let frame = head.map(|head| head.in_body.inverse());
            json!({
                "name": body.name,
                "parent": body_name(body.parent).unwrap_or("world"),
                "joint": body.joint.name,
                "mass": body.mass,
                "principal_inertia": body.inertia.as_slice(),
                "center_of_mass": frame.map(|frame| frame.translation.vector.as_slice().to_vec()),
                "principal_axes": frame.map(|frame| wxyz_from_rotation(frame.rotation.matrix())),
                "links": links,
            })
        })
        .collect();
    let joints: Vec<Value> = model
        .joints
        .iter()
        .map(|joint| {
            json!({
                "name": joint.name,
                "type": joint.kind.name(),
                "parent": joint.parent_link,
                "child": joint.child_link,
                "body": body_name(joint.body),
                "degrees_of_freedom": joint.body.map_or(0, |body| mechanism.bodies[body].joint.kind.velocity_count()),
                "position": joint.body.map(|_| position_names(joint.kind)),
            })
        })
        .collect();
    let links: Vec<Value> = model
        .links
        .iter()
        .map(|link| {
            json!({
                "name": link.name,
                "body": body_name(link.body).unwrap_or("world"),
                "mass": link.mass,
                "parent_joint": link.parent_joint,
            })
        })
        .collect();
    let reductions: Vec<Value> = model
        .reductions
        .iter()
        .map(|reduction| {
            json!({
                "rule": reduction.rule.name(),
                "link": reduction.link,
                "joint": reduction.joint,
                "into": reduction.into,
                "reason": reduction.rule.reason(),
            })
        })
        .collect();
    let mut report = json!({
        "catena": env!("CARGO_PKG_VERSION"),
        "input": model.path().display().to_string(),
        "robot": mechanism.name,
        "gravity": mechanism.gravity.as_slice(),
        "model": ModelReport::new(model, redundancy, (plan.islands.len(), plan.sleeping())),
        "moving_mass": mechanism.total_mass(),
        "bodies": bodies,
        "joints": joints,
        "links": links,
        "reductions": reductions,
        "warnings": model.warning_lines().collect::<Vec<_>>(),
    });
    let of_joints = joint_tables::as_json(model, start);
    let parts = couplings::as_json(model, redundancy).into_iter().chain(of_joints);
    let parts = parts.chain(contact_tables::as_json(model)).chain(rules::as_json(model, plan, kept));
    for (key, value) in parts {
        report[key] = value;
    }
    report
}

fn as_text(described: &Described) -> String {
    let Described { model, redundancy, .. } = described;
    let mechanism = &model.mechanism;
    let mut text = String::new();
    // Writing into a String cannot fail.
    let _ = writeln!(
        text,
        "{}: {} → {}, {}, {}{}",
        mechanism.name,
        counted(model.links.len(), "link", "links"),
        counted(mechanism.bodies.len(), "body", "bodies"),
        counted(mechanism.bodies.len(), "joint", "joints"),
        counted(redundancy.degrees_of_freedom(mechanism), "degree of freedom", "degrees of freedom"),
        couplings::summary(model),
    );
    let g = mechanism.gravity;
    let _ = writeln!(text, "{} kg move under gravity {}, {}, {} m/s²", number(mechanism.total_mass()), g.x, g.y, g.z);
    for table in tables(described) {
        if table.title == NO_BODIES && !table.is_empty() {
            let _ = writeln!(text, "\nno bodies of their own:");
        }
        table.write(&mut text);
    }
    contact_tables::write_note(model, &mut text);
    let mut shown = None;
    for (group, warning) in warning_lines(&model.warnings) {
        if shown != Some(group) {
            let _ = writeln!(text, "\n{}:", group.title());
            shown = Some(group);
        }
        let _ = writeln!(text, "  {warning}");
    }
    text
}

const NO_BODIES: &str = "Links that are no bodies of their own";

/// All tables about a model, some of which may be empty.
fn tables(&Described { model, start, redundancy, plan, kept }: &Described) -> Vec<Table> {
    let mechanism = &model.mechanism;
    let mut bodies =
        Table::new("Bodies", &["body", "parent", "joint", "type", "given by", "mass [kg]", "inertia [kg m²]"]);
    let mut record_of: Vec<Option<&JointRecord>> = vec![None; mechanism.bodies.len()];
    for record in &model.joints {
        if let Some(body) = record.body {
            record_of[body] = Some(record);
        }
    }
    for (body, record) in mechanism.bodies.iter().zip(record_of) {
        bodies.row(vec![
            body.name.clone(),
            body.parent.map_or("world", |parent| mechanism.bodies[parent].name.as_str()).to_string(),
            body.joint.name.clone(),
            record.map_or(body.joint.kind.name(), |record| record.kind.name()).to_string(),
            record.map_or("", |record| position_names(record.kind)).to_string(),
            number(body.mass),
            triple(&body.inertia),
        ]);
    }
    let mut others = Table::new(NO_BODIES, &["link", "joint", "moves with", "because"]);
    for reduction in &model.reductions {
        let because = match reduction.rule {
            ReductionRule::MasslessLeaf => "it has no mass, nor has anything beyond it",
            rule => rule.reason(),
        };
        others.row(vec![
            reduction.link.clone(),
            reduction.joint.clone().unwrap_or_default(),
            reduction.into.clone(),
            because.to_string(),
        ]);
    }
    let of_couplings = couplings::tables(model, redundancy);
    let of_joints = joint_tables::tables(model, start);
    let of_contact = contact_tables::tables(model);
    let of_rules = rules::tables(model, plan, kept);
    std::iter::once(bodies)
        .chain(of_couplings)
        .chain(of_joints)
        .chain(of_contact)
        .chain([others])
        .chain(of_rules)
        .collect()
}

/// The tables about a model for a page.
pub fn page_tables(loaded: &Loaded, start: &State, kept: &[Rule]) -> Vec<PageTable> {
    let (redundancy, plan) = counts(loaded, start, kept);
    let described = Described { model: &loaded.model, start, redundancy: &redundancy, plan: &plan, kept };
    tables(&described).iter().filter(|table| !table.is_empty()).map(Table::on_page).collect()
}

/// Redundant equations and islands of the loaded model, at its start.
fn counts(loaded: &Loaded, start: &State, kept: &[Rule]) -> (Redundancy, Plan) {
    let mechanism = &loaded.model.mechanism;
    let redundancy = match &loaded.counted {
        Some(counted) => redundancy_counted(mechanism, counted),
        None => redundancy(mechanism, start),
    };
    (redundancy, Plan::from_counted(mechanism, start, kept, loaded.counted.as_ref()))
}
