//! Linear relations of joints, from the tables `[[coupling]]`: names resolved, coefficients checked.

use crate::scene::coupling::{JointReference, SceneCoupling};
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::scene_schema::CouplingTable;
use toml::Spanned;

impl CouplingReader<'_> {
    /// All relations of joints.
    pub fn relations(&mut self, tables: Vec<Spanned<CouplingTable>>) -> Result<Vec<SceneCoupling>, SceneError> {
        let mut couplings: Vec<SceneCoupling> = Vec::with_capacity(tables.len());
        for (index, table) in tables.into_iter().enumerate() {
            let span = table.span();
            let CouplingTable { name, joints, offset } = table.into_inner();
            let name = name.map_or_else(|| format!("coupling{}", index + 1), Spanned::into_inner);
            let owner = Element::Coupling(name.clone());
            let refuse = |problem| Err(self.text.error(&span, Some(owner.clone()), problem));
            if let Some(first) = couplings.iter().find(|other| other.name == name) {
                return refuse(Problem::DuplicateName { first_line: first.line });
            }
            let mut given: Vec<_> = joints.into_iter().collect();
            given.sort_by_key(|(joint, _)| joint.span().start);
            let mut terms: Vec<(JointReference, f64)> = Vec::with_capacity(given.len());
            for (joint, coefficient) in given {
                let joint = self.joint(&joint, &owner)?;
                if coefficient.0 == 0.0 {
                    return refuse(Problem::Keys("a coefficient of a coupling is not zero; leave its joint out"));
                }
                terms.push((joint, coefficient.0));
            }
            if terms.len() < 2 {
                return refuse(Problem::Keys("a coupling needs two joints or more"));
            }
            let offset = offset.map_or(0.0, |offset| offset.0);
            couplings.push(SceneCoupling { name, terms, offset, line: self.text.line(&span) });
        }
        Ok(couplings)
    }
}
