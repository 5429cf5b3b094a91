//! Loads and drag, from the tables `[[load]]` and `[[drag]]`: names resolved, keys that belong together checked.

use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::joint_settings::TableFile;
use crate::scene::loads::{Factor, LoadKind, SceneDrag, SceneLoad};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::joint_schema::TargetKey;
use crate::scene::scene_reading::scene_files::SceneFiles;
use crate::scene::scene_reading::scene_numbers::{Finite, Quantity};
use crate::scene::scene_reading::scene_schema::{DragTable, LoadFrame, LoadTable, vector};
use std::ops::Range;
use toml::Spanned;

impl CouplingReader<'_> {
    /// All loads; the CSV files of their factors join `read`.
    pub fn loads(
        &mut self,
        tables: Vec<Spanned<LoadTable>>,
        files: &mut dyn SceneFiles,
        read: &mut Vec<TableFile>,
    ) -> Result<Vec<SceneLoad>, SceneError> {
        let mut loads = Vec::with_capacity(tables.len());
        for table in tables {
            let span = table.span();
            let (on, kind) = self.loaded(table.get_ref(), &span)?;
            let table = table.into_inner();
            let factor = self.factor(&table, &span, &Element::Load(on.clone()), files, read)?;
            let [from, until] = [table.from, table.until].map(|time| time.map(|time| time.0));
            if let (Some(from), Some(until)) = (from, until)
                && from >= until
            {
                let problem = Problem::Keys("a load ends after it begins: give a later until");
                return Err(self.text.error(&span, Some(Element::Load(on)), problem));
            }
            loads.push(SceneLoad { on, kind, factor, from, until, line: self.text.line(&span) });
        }
        Ok(loads)
    }

    /// The part on which a load acts, and how.
    fn loaded(&mut self, table: &LoadTable, span: &Range<usize>) -> Result<(String, LoadKind), SceneError> {
        let LoadTable { joint, effort, link, position, force, torque, frame, .. } = table;
        let refuse = |message| Err(self.text.error(span, None, Problem::Keys(message)));
        match (joint, link) {
            (Some(joint), None) => {
                let Some(effort) = effort else { return refuse("a load on a joint needs its effort") };
                if position.is_some() || force.is_some() || torque.is_some() || frame.is_some() {
                    return refuse("a load on a joint has an effort, no position, force, torque or frame");
                }
                let on = joint.get_ref().clone();
                let joint = self.joint(joint, &Element::Load(on.clone()))?;
                Ok((on, LoadKind::Joint { joint, effort: effort.get_ref().0 }))
            }
            (None, Some(link)) => {
                if effort.is_some() {
                    return refuse("a load on a link has a force or torque, no effort");
                }
                if force.is_none() && torque.is_none() {
                    return refuse("a load on a link needs a force or a torque");
                }
                let numbers = |given: &Option<Spanned<[Finite; 3]>>| {
                    given.as_ref().map_or([Finite(0.0); 3], |own| *own.get_ref())
                };
                let on = link.get_ref().clone();
                let point = self.point(link, &numbers(position), &Element::Load(on.clone()))?;
                let (force, torque) = (vector(&numbers(force)), vector(&numbers(torque)));
                Ok((on, LoadKind::Link { point, force, torque, turns: *frame == Some(LoadFrame::Link) }))
            }
            _ => refuse("a load is either on a joint or on a link"),
        }
    }

    /// The factor of a load over time.
    fn factor(
        &self,
        table: &LoadTable,
        span: &Range<usize>,
        owner: &Element,
        files: &mut dyn SceneFiles,
        read: &mut Vec<TableFile>,
    ) -> Result<Factor, SceneError> {
        let refuse = |message| Err(self.text.error(span, Some(owner.clone()), Problem::Keys(message)));
        match (&table.factor, &table.wave) {
            (Some(_), Some(_)) => refuse("a load has either a factor or a wave"),
            (None, Some(wave)) => Ok(Factor::Wave(wave.wave())),
            (None, None) => Ok(Factor::None),
            (Some(factor), None) => {
                if matches!(factor.get_ref(), TargetKey::Start) {
                    return refuse(
                        "its factor is a number, a list of [time, value], the name of a CSV file of time,value, or { formula = \"…\" }",
                    );
                }
                let value = |given: Quantity, span: &Range<usize>| {
                    given.value(false, false).map_err(|reason| {
                        self.text.error(span, Some(owner.clone()), Problem::Table(format!("its factor: {reason}")))
                    })
                };
                let interpolation = table.interpolation.into();
                Ok(match self.target(factor, &value, interpolation, owner, files, read)? {
                    (_, Some(table)) => Factor::Table(table),
                    (target, None) => match target.as_formula() {
                        Some(formula) => Factor::Formula(formula.clone()),
                        None => Factor::Number(target.value(0.0)),
                    },
                })
            }
        }
    }

    /// The drag of all links that have some.
    pub fn drags(&mut self, tables: Vec<Spanned<DragTable>>) -> Result<Vec<SceneDrag>, SceneError> {
        let mut drags = Vec::with_capacity(tables.len());
        for table in tables {
            let span = table.span();
            let DragTable { link, position, linear, quadratic, angular, angular_quadratic } = table.into_inner();
            let (on, line) = (link.get_ref().clone(), self.text.line(&span));
            let point = self.point(&link, &position, &Element::Drag(on.clone()))?;
            let numbers = [linear, quadratic, angular, angular_quadratic];
            if numbers.iter().all(Option::is_none) {
                let problem = Problem::Keys("drag needs its linear, quadratic, angular or angular_quadratic");
                return Err(self.text.error(&span, Some(Element::Drag(on)), problem));
            }
            let numbers = numbers.map(|number| number.map_or(0.0, |number| number.0));
            drags.push(SceneDrag { on, point, numbers, line });
        }
        Ok(drags)
    }
}
