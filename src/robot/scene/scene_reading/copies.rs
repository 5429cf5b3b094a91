//! Copies of a robot or body: `count` along a line, or a `grid`, a `spacing` apart.
//!
//! Copy (i, j, k) of a grid is displaced by (i s_x, j s_y, k s_z), and copy i of a line by i s, with the spacing s (m) in the world. They are
//! numbered from 1, along x first.

use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::scene_reading::scene_numbers::Finite;
use crate::scene::scene_reading::scene_schema::vector;
use crate::scene::scene_reading::toml_text::TomlText;
use nalgebra::Vector3;
use toml::Spanned;

/// Most copies of one table.
const MOST: usize = 10_000;

/// The keys of a table that say how often it is there.
pub(crate) struct CopyKeys<'k> {
    pub count: &'k Option<Spanned<usize>>,
    pub grid: &'k Option<Spanned<[usize; 3]>>,
    pub spacing: &'k Option<Spanned<[Finite; 3]>>,
}

/// The number after the name of each copy, and its displacement (m). Without the keys there is one copy and no number.
///
/// # Errors
/// [`SceneError`] for keys that exclude each other or of which one is missing, and for no or too many copies.
pub(crate) fn copies(
    text: &TomlText,
    keys: &CopyKeys,
    owner: &Element,
) -> Result<Vec<(String, Vector3<f64>)>, SceneError> {
    let refuse = |span, message| Err(text.error(&span, Some(owner.clone()), Problem::Keys(message)));
    let (span, grid) = match (keys.count, keys.grid) {
        (None, None) => {
            return match keys.spacing {
                Some(spacing) => refuse(spacing.span(), "a spacing needs a count or a grid"),
                None => Ok(vec![(String::new(), Vector3::zeros())]),
            };
        }
        (Some(_), Some(grid)) => return refuse(grid.span(), "give either a count or a grid"),
        (Some(count), None) => (count.span(), [*count.get_ref(), 1, 1]),
        (None, Some(grid)) => (grid.span(), *grid.get_ref()),
    };
    let all = grid.iter().try_fold(1_usize, |all, one| all.checked_mul(*one));
    if !all.is_some_and(|all| (1..=MOST).contains(&all)) {
        return refuse(span, "it must be there at least once and at most 10000 times");
    }
    let Some(spacing) = keys.spacing else {
        return refuse(span, "copies need their spacing = [x, y, z], else all of them are at one place");
    };
    let spacing = vector(spacing.get_ref());
    let along_line = keys.count.is_some();
    let mut all = Vec::new();
    for k in 0..grid[2] {
        for j in 0..grid[1] {
            for i in 0..grid[0] {
                let steps = if along_line { [i; 3] } else { [i, j, k] };
                let displacement = spacing.component_mul(&Vector3::from(steps.map(|step| step as f64)));
                all.push(((all.len() + 1).to_string(), displacement));
            }
        }
    }
    Ok(all)
}
