//! Decisions in which contacts begin to slide, with pressures as steps share them.
//!
//! If the normals of closed contacts imply each other, `zᵀ W_N = 0`, they can share the load in many ways. The law has one answer for each of them,
//! and each gives another friction. A step distributes the normal forces as if equal springs, as stiff as one likes, supported all contacts
//! ([`crate::events::forces::closed_forces`]). The decision reproduces this with
//!
//! ```text
//!     D' = D + ε d Σ_z z zᵀ        on the rows of the normals, z orthonormal; d: the mean of their D_ii
//! ```
//!
//! as long as all stay closed, whatever ε is: then `zᵀ λ_N = 0` and the added term vanishes. If some open, a small ε means that the others give way
//! little.

use crate::instant::cone::problem::{Answer, BlockState, Law, Problem, Unsolved};
use crate::instant::cone::sharing::{on_equal_springs, with_vanishing_compliance};
use crate::instant::cone::solve_apart;
use crate::instant::holding::blocks::{Block, Of};
use crate::mechanism::motion::contact_solvers::ContactSolvers;
use nalgebra::DMatrix;

/// ε.
const GIVES: f64 = 1e-6;

/// Solves the law of the blocks; again with D' where something begins to slide and normals imply each other, if that can be solved. Of several answers
/// elsewhere it is the one of vanishing compliances.
pub(crate) fn solve_as_steps_share(
    blocks: &[Block],
    problem: &Problem,
    solvers: &mut ContactSolvers,
) -> Result<Answer, Unsolved> {
    let solved = solve_apart(problem, solvers)?;
    let begins = |(law, state): (&Law, &BlockState)| matches!(law, Law::Contact { .. }) && *state == BlockState::Slips;
    if problem.laws.iter().zip(&solved.states).any(begins)
        && let Some(shared) = with_shared_pressures(blocks, problem.mobility)
    {
        return Ok(solve_apart(&Problem { mobility: &shared, ..*problem }, solvers).unwrap_or(solved));
    }
    Ok(with_vanishing_compliance(problem, solved))
}

/// D' for the blocks of a decision; `None` if no normals imply others.
fn with_shared_pressures(blocks: &[Block], mobility: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (mut normals, mut row) = (Vec::new(), 0);
    for block in blocks {
        if matches!(block.of, Of::Contact(_)) && mobility[(row, row)] > 0.0 {
            normals.push(row);
        }
        row += block.rows.len();
    }
    on_equal_springs(mobility, &normals, GIVES)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instant::cone::solve;
    use nalgebra::DVector;

    #[test]
    fn pressures_of_a_plate_on_four_feet_lie_on_a_plane() {
        let feet = [[0.3, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.3, -0.2]];
        // A plate of 2 kg and 0.1 kg m², whose weight presses beside the middle.
        let gradients = feet.map(|[x, y]| [1.0, y, -x]);
        let mobility = DMatrix::from_fn(4, 4, |i, j| {
            let [one, other] = [gradients[i], gradients[j]];
            one[0] * other[0] / 2.0 + (one[1] * other[1] + one[2] * other[2]) / 0.1
        });
        let free: Vec<f64> = gradients.iter().map(|[_, y, x]| -10.0 + 7.0 * y - 4.0 * x).collect();
        let law = Law::Interval { lower: 0.0, upper: f64::INFINITY };
        let blocks: Vec<Block> =
            (0..4).map(|foot| Block { of: Of::Contact(foot), law, rows: vec![Vec::new().into()] }).collect();
        let shared = with_shared_pressures(&blocks, &mobility).expect("three feet would do");
        let found = solve(&Problem { mobility: &shared, free: &free, laws: &[law; 4] }, None).expect("it stands");
        let [a, b, c, d] = [0, 1, 2, 3].map(|foot: usize| found.forces[foot]);
        assert!(found.forces.iter().all(|force| *force > 1.0), "{:?}", found.forces);
        // Solved to 1e-10 of 5 N, and a part of 1e-6 of the mobility says what the sum is.
        assert!((a - b + c - d).abs() < 1e-3 * 1e-1, "{:?}", found.forces);
        let rates = &mobility * DVector::from_vec(found.forces);
        assert!(rates.iter().zip(&free).all(|(rate, free)| (rate + free).abs() < 1e-9), "{rates}");
        // Three feet say all of theirs themselves.
        assert!(with_shared_pressures(&blocks[..3], &mobility.view((0, 0), (3, 3)).into_owned()).is_none());
    }
}
