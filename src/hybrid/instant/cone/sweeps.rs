//! Block Gauss–Seidel: each block in turn takes the force that fits its law while all others stay.
//!
//! ```text
//!     r_c ← solution of the law of c with W = D_cc and b = u_c − D_cc r_c
//! ```
//!
//! It converges slowly or not at all with mass ratios and redundant contacts, but some sweeps are a good start for Newton's method.

use crate::instant::cone::problem::Law;
use crate::instant::cone::scaled::Scaled;
use crate::instant::cone::single::single_contact;
use nalgebra::Vector3;

/// Makes some sweeps over all blocks.
pub(super) fn sweep(problem: &Scaled, forces: &mut [f64], sweeps: usize) {
    let mut rates = vec![0.0; forces.len()];
    problem.rates(forces, &mut rates);
    for _ in 0..sweeps {
        for (start, law) in problem.blocks() {
            let own = problem.mobility[(start, start)];
            let target = match law {
                Law::Interval { lower, upper } => {
                    let moved = if own > 0.0 { forces[start] - rates[start] / own } else { forces[start] };
                    Vector3::new(moved.max(lower).min(upper), 0.0, 0.0)
                }
                Law::Sliding { friction, direction } => {
                    let along = Vector3::new(1.0, -friction * direction[0], -friction * direction[1]);
                    let normal_row = problem.mobility.fixed_view::<1, 3>(start, start);
                    let before = Vector3::from_column_slice(&forces[start..start + 3]);
                    let free = rates[start] - (normal_row * before).x;
                    let coupled = (normal_row * along).x;
                    // If friction overcomes the normal mobility (Painlevé), the frictionless force is a start as good as any.
                    let mobility = if coupled > 0.0 { coupled } else { own };
                    let normal = if mobility > 0.0 { (-free / mobility).max(0.0) } else { 0.0 };
                    along * normal
                }
                Law::Contact { friction } => {
                    let mobility = problem.mobility.fixed_view::<3, 3>(start, start).into_owned();
                    let before = Vector3::from_column_slice(&forces[start..start + 3]);
                    let free = Vector3::from_column_slice(&rates[start..start + 3]) - mobility * before;
                    single_contact(&mobility, &free, friction)
                }
            };
            for row in 0..law.rows() {
                let change = target[row] - forces[start + row];
                if change != 0.0 {
                    forces[start + row] = target[row];
                    problem.add_column(start + row, change, &mut rates);
                }
            }
        }
    }
}
