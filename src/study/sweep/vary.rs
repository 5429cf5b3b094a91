//! The varied parameters, from the tables `[[vary]]` of a sweep file: key paths looked up, ways of varying checked.

use crate::mechanism::ground::words::counted;
use crate::scene::{Geometry, Parameter, Problem, Scene, SceneError, TomlText, Touching, read_text};
use crate::sweep::lists::read_list;
use crate::sweep::random::Law;
use crate::sweep::schema::{SpacingTable, VaryTable};
use crate::sweep::variation::{Column, Source};
use sha2::{Digest, Sha256};
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// Reads the tables of a sweep file, and gathers what tells the sweep from others.
pub(super) struct Reader<'r> {
    pub text: &'r TomlText<'r>,
    pub hash: Sha256,
    /// Numbers that vary, so far.
    pub columns: Vec<Column>,
}

impl Reader<'_> {
    /// Adds bytes to the fingerprint, apart from those before them.
    pub fn mix(&mut self, bytes: &[u8]) {
        self.hash.update((bytes.len() as u64).to_le_bytes());
        self.hash.update(bytes);
    }

    /// Mixes in the content of the scene and its files, without their paths, which differ between machines.
    pub fn mix_scene(&mut self, scene: &Scene) {
        self.mix(scene.source.as_bytes());
        scene.robots.iter().for_each(|robot| self.mix(robot.robot.source.as_bytes()));
        scene.tables.iter().for_each(|table| self.mix(table.text.as_bytes()));
        let meshes = scene.contact.obstacles.iter().filter_map(|obstacle| obstacle.mesh.as_ref());
        meshes.for_each(|mesh| self.mix(&mesh.bytes));
        let touches = !scene.contact.obstacles.is_empty() || scene.contact.touching() == Touching::All;
        let links = scene.robots.iter().flat_map(|robot| &robot.robot.links).filter(|_| touches);
        for shape in links.flat_map(|link| &link.collisions) {
            if let Geometry::Mesh(mesh) = &shape.geometry
                && let Some(Ok((_, bytes))) = mesh.read()
            {
                self.mix(&bytes);
            }
        }
    }

    /// The fingerprint, in hexadecimal digits.
    pub fn fingerprint(&self) -> String {
        self.hash.clone().finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The error of a wrong key.
    pub fn refuse(&self, span: &Range<usize>, key: &str, message: String) -> SceneError {
        self.text.error(span, None, Problem::Toml { key: Some(key.to_string()), message })
    }

    /// All tables `[[vary]]`.
    pub fn sources(&mut self, scene: &Scene, tables: &[Spanned<VaryTable>]) -> Result<Vec<Source>, SceneError> {
        let known = scene.parameters();
        tables.iter().enumerate().map(|(entry, table)| self.source(scene, &known, entry as u64, table)).collect()
    }

    fn source(
        &mut self,
        scene: &Scene,
        known: &[Parameter],
        entry: u64,
        table: &Spanned<VaryTable>,
    ) -> Result<Source, SceneError> {
        let span = table.span();
        let table = table.get_ref();
        let first = self.columns.len();
        let ways = "one of linear, logarithmic, values, uniform, log_uniform, normal, csv";
        if let Some(csv) = &table.csv {
            if table.key.is_some() || table.keys.is_some() {
                return Err(self.refuse(
                    &csv.span(),
                    "vary.csv",
                    "the first line of the CSV file names the keys; leave key and keys out".into(),
                ));
            }
            if how(table).len() > 1 {
                return Err(self.refuse(&csv.span(), "vary", format!("give {ways}")));
            }
            return self.list(scene, known, csv, table.relative);
        }
        let keys: Vec<&Spanned<String>> = match (&table.key, &table.keys) {
            (Some(key), None) => vec![key],
            (None, Some(keys)) if !keys.get_ref().is_empty() => keys.get_ref().iter().collect(),
            _ => return Err(self.refuse(&span, "vary", "give either its key or its keys".into())),
        };
        for key in keys {
            self.column(scene, known, key.get_ref(), table.relative)
                .map_err(|message| self.refuse(&key.span(), "vary.key", message))?;
        }
        let columns = self.columns.len() - first;
        let [way] = how(table)[..] else {
            return Err(self.refuse(&span, "vary", format!("give {ways}")));
        };
        let grid = |values: Vec<f64>| Source::Grid { first, columns, values };
        let drawn = |law| Source::Random { first, columns, law, entry };
        let (place, source, tried) = match way {
            Way::Spaced(spacing, logarithmic) => {
                let values = spaced(spacing.get_ref(), logarithmic)
                    .map_err(|message| self.refuse(&spacing.span(), "vary", message))?;
                (spacing.span(), grid(values.clone()), values)
            }
            Way::Values(values) if values.get_ref().is_empty() => {
                return Err(self.refuse(&values.span(), "vary.values", "give at least one number".into()));
            }
            Way::Values(values) => (values.span(), grid(values.get_ref().clone()), values.get_ref().clone()),
            Way::Law(bounds, law) => {
                check_law(law).map_err(|message| self.refuse(&bounds.span(), "vary", message))?;
                // A normal law has no bounds to try, so its mean is tried. An impossible draw becomes a row that says so.
                let tried = if let Law::Normal(mean, _) = law { vec![mean] } else { bounds.get_ref().to_vec() };
                (bounds.span(), drawn(law), tried)
            }
        };
        for column in &self.columns[first..] {
            for number in &tried {
                if let Err(reason) = column.parameter.check(number * column.unit) {
                    let message = format!("{} = {}: {reason}", column.parameter.key(), number * column.unit);
                    return Err(self.refuse(&place, "vary", message));
                }
            }
        }
        Ok(source)
    }

    /// A CSV file of runs.
    fn list(
        &mut self,
        scene: &Scene,
        known: &[Parameter],
        csv: &Spanned<String>,
        relative: bool,
    ) -> Result<Source, SceneError> {
        let file = self.text.file.parent().unwrap_or(Path::new("")).join(csv.get_ref());
        let text = match read_text(&file) {
            Err(error) if matches!(*error.problem, Problem::Unreadable(_)) => {
                return Err(self.refuse(&csv.span(), "vary.csv", error.to_string()));
            }
            read => read?,
        };
        self.mix(text.as_bytes());
        let list = read_list(&text, &file)?;
        let (first, columns) = (self.columns.len(), list.keys.len());
        let refuse = |line: usize, reason: String| SceneError {
            file: file.clone(),
            line: Some(line),
            element: None,
            problem: Box::new(Problem::Table(reason)),
        };
        for key in &list.keys {
            self.column(scene, known, key, relative).map_err(|message| refuse(list.header, message))?;
        }
        for (row, numbers) in list.numbers.chunks_exact(columns).enumerate() {
            for (number, column) in numbers.iter().zip(&self.columns[first..]) {
                if let Err(reason) = column.parameter.check(number * column.unit) {
                    return Err(refuse(
                        list.lines[row],
                        format!("{} = {}: {reason}", column.parameter.key(), number * column.unit),
                    ));
                }
            }
        }
        Ok(Source::Table { first, columns, rows: list.numbers })
    }

    /// A number that varies.
    fn column(&mut self, scene: &Scene, known: &[Parameter], key: &str, relative: bool) -> Result<(), String> {
        let parameter = scene.parameter_among(known, key).map_err(|error| error.to_string())?.clone();
        if self.columns.iter().any(|other| other.parameter.key() == parameter.key()) {
            return Err(format!("{} varies twice", parameter.key()));
        }
        let unit = match (relative, parameter.said()) {
            (false, _) => 1.0,
            (true, Some(said)) if said.is_finite() => said,
            (true, _) => return Err(format!("{} is relative to nothing: the files do not say it", parameter.key())),
        };
        self.columns.push(Column { parameter, unit });
        Ok(())
    }
}

/// How numbers vary.
#[derive(Clone, Copy)]
enum Way<'w> {
    Spaced(&'w Spanned<SpacingTable>, bool),
    Values(&'w Spanned<Vec<f64>>),
    Law(&'w Spanned<[f64; 2]>, Law),
}

/// All ways that a table gives.
fn how(table: &VaryTable) -> Vec<Way<'_>> {
    let law = |bounds: &'_ Option<Spanned<[f64; 2]>>, law: fn(f64, f64) -> Law| {
        bounds.as_ref().map(|b| law(b.get_ref()[0], b.get_ref()[1]))
    };
    let given = [
        table.linear.as_ref().map(|spacing| Way::Spaced(spacing, false)),
        table.logarithmic.as_ref().map(|spacing| Way::Spaced(spacing, true)),
        table.values.as_ref().map(Way::Values),
        table.uniform.as_ref().zip(law(&table.uniform, Law::Uniform)).map(|(bounds, law)| Way::Law(bounds, law)),
        table
            .log_uniform
            .as_ref()
            .zip(law(&table.log_uniform, Law::LogUniform))
            .map(|(bounds, law)| Way::Law(bounds, law)),
        table.normal.as_ref().zip(law(&table.normal, Law::Normal)).map(|(bounds, law)| Way::Law(bounds, law)),
    ];
    given.into_iter().flatten().collect()
}

/// Numbers from the first to the last, both included, with equal steps or equal ratios.
fn spaced(table: &SpacingTable, logarithmic: bool) -> Result<Vec<f64>, String> {
    let &SpacingTable { from, to, count } = table;
    if !from.is_finite() || !to.is_finite() {
        return Err(format!("from {from} to {to}: give finite numbers"));
    }
    if count == 0 || (count == 1 && from != to) {
        return Err(format!(
            "{} from {from} to {to}: give a count of at least 2",
            counted(count as usize, "number", "numbers")
        ));
    }
    if count > 100_000_000 {
        return Err("give a count of at most 1e8".to_string());
    }
    if logarithmic && !(from > 0.0 && to > 0.0) {
        return Err(format!("from {from} to {to}: logarithmic spacing needs positive numbers"));
    }
    let at = |index: u64| match index {
        0 => from,
        last if last + 1 == count => to,
        index => {
            let part = index as f64 / (count - 1) as f64;
            if logarithmic { from * (part * (to / from).ln()).exp() } else { from + part * (to - from) }
        }
    };
    Ok((0..count).map(at).collect())
}

fn check_law(law: Law) -> Result<(), String> {
    let ([one, two], problem) = match law {
        Law::Uniform(low, high) => ([low, high], (low > high).then_some("the lower bound comes first")),
        Law::LogUniform(low, high) => {
            ([low, high], (low > high || low <= 0.0).then_some("give two positive bounds, the lower one first"))
        }
        Law::Normal(mean, deviation) => (
            [mean, deviation],
            (deviation < 0.0).then_some("give the mean and a standard deviation that is not negative"),
        ),
    };
    if !one.is_finite() || !two.is_finite() {
        return Err(format!("[{one}, {two}]: give finite numbers"));
    }
    problem.map_or(Ok(()), |problem| Err(format!("[{one}, {two}]: {problem}")))
}
