//! Decides the next mode of elements at rest: which joints are held (by friction or on a limit), which way the others move, which contacts stay
//! closed, and which of these slide.
//!
//! All joints whose rate is zero and that have friction or are on a limit, and all contacts that do not part, are decided together, at the level of
//! accelerations:
//!
//! ```text
//!     a = b + D λ,   b = W a_free + Ẇ v,  D = W Y Wᵀ      a_free under all efforts but λ; friction that slides in joints is among them
//!     joints:    λ_i ∈ [lo_i, hi_i]:   a_i = 0 inside,  a_i ≥ 0 at lo_i,  a_i ≤ 0 at hi_i           (the box of `mode`)
//!     contacts:  Signorini's and Coulomb's law between λ and a; where one slides, λ_T = −μ λ_N t    (`crate::instant::cone`)
//!     turnings:  the same for the moments of rolling and spinning friction                          (`crate::instant::holding::moments`)
//! ```
//!
//! A joint with `a_i = 0` is held; one with `a_i > 0` goes forward with friction `−τ_f = lo_i` against it, or leaves its lower limit. In a mechanism
//! with closures, joints that the held ones immobilise are held, too, so that the reduced mechanism has no redundant closure.
//!
//! Source: Ch. Glocker, Set-Valued Force Laws, Springer 2001, chapter 9.

use crate::events::effects::decision::{Candidate, Decided, Scene, Undecided, Yielding};
use crate::events::effects::next_modes::NextModes;
use crate::events::effects::rest_problem::AtRest;
use crate::events::modes::mode::Mode;
use crate::mechanism::motion::state::State;

/// Decides the joints whose rate is zero and the contacts that touch; `efforts` are those from outside and of motors.
pub(crate) fn decide(
    scene: &mut Scene,
    mode: &mut Mode,
    state: &State,
    efforts: &[f64],
    yielding: &Yielding,
    candidates: &[Candidate],
) -> Result<Decided, Undecided> {
    let none = vec![0.0; candidates.len()];
    let at_rest = AtRest::of(scene, mode, state, efforts, yielding, candidates);
    if at_rest.is_empty() {
        let accelerations = vec![0.0; state.velocity.len()];
        return Ok(Decided { off: 0.0, accelerations, pressures: none.clone(), holding: none });
    }
    let mut problem = at_rest.respond(scene, state, candidates);
    problem.weaken(scene.elements, yielding, candidates);
    let is_flat = candidates.iter().any(|candidate| candidate.contact.flat_end().is_some());
    let holding = is_flat.then(|| problem.holding_forces());
    let (found, off) = problem.solve(scene.solvers)?;
    NextModes::new(scene, &problem, &found, yielding, candidates).write(mode);
    let (pressures, holding) = holding.map_or((none.clone(), none), |holding| {
        let along = |forces: &[f64]| problem.along_normals(forces, candidates.len());
        (along(&found.forces), along(&holding))
    });
    Ok(Decided { off, accelerations: problem.into_accelerations(&found.forces), pressures, holding })
}
