//! Ropes, from the tables `[[rope]]`: names resolved.

use crate::scene::coupling::{Point, SceneRope};
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::scene_schema::RopeTable;
use toml::Spanned;

impl CouplingReader<'_> {
    /// All ropes.
    pub fn ropes(&mut self, tables: Vec<Spanned<RopeTable>>) -> Result<Vec<SceneRope>, SceneError> {
        let mut ropes: Vec<SceneRope> = Vec::with_capacity(tables.len());
        for (index, table) in tables.into_iter().enumerate() {
            let span = table.span();
            let RopeTable { name, points, length, restitution } = table.into_inner();
            let name = name.map_or_else(|| format!("rope{}", index + 1), Spanned::into_inner);
            let owner = Element::Rope(name.clone());
            let refuse = |span, problem| Err(self.text.error(span, Some(owner.clone()), problem));
            if let Some(first) = ropes.iter().find(|other| other.name == name) {
                return refuse(&span, Problem::DuplicateName { first_line: first.line });
            }
            if name.is_empty() || name.contains(['|', '*']) {
                return refuse(&span, Problem::Keys("a rope has a name without | and *"));
            }
            let place = points.span();
            if points.get_ref().len() < 2 {
                return refuse(
                    &place,
                    Problem::Keys("a rope has two points or more: its ends, and eyelets between them"),
                );
            }
            let points = points.get_ref().iter().map(|point| self.point(&point.link, &point.position, &owner));
            let points = points.collect::<Result<Vec<Point>, SceneError>>()?;
            let restitution = restitution.map_or(0.0, |restitution| restitution.0);
            ropes.push(SceneRope { name, points, length: length.0, restitution, line: self.text.line(&span) });
        }
        Ok(ropes)
    }
}
