//! The frequency of the fastest mode of a tree under gravity.
//!
//! The largest ω of a mechanism at an instant solves `H δq̈ + K δq = 0` with the joint-space inertia and the geometric stiffness of
//! [`crate::watching::dynamics`]. The power iteration `w = H⁻¹ K v` finds it from below,
//!
//! ```text
//!     ω⁴ ← wᵀ H w / vᵀ H v = wᵀ K v / vᵀ H v,     v ← w        [1/s⁴]
//! ```
//!
//! because `H⁻¹ K` is symmetric in the scalar product of H. Negative eigenvalues (an inverted pendulum) count by their size. The direction is kept
//! from instant to instant, so that one iteration now and then follows the mode. Mechanisms with forces or closures use
//! [`crate::watching::linearised`].

use crate::watching::dynamics::Dynamics;
use catena_lobatto::plan::tree::Plan;
use catena_lobatto::stages::start::Start;

/// Makes it a direction that has a part in every mode: its numbers have no symmetry of a mechanism.
pub(crate) fn first_direction(direction: &mut [f64]) {
    for (freedom, value) in direction.iter_mut().enumerate() {
        *value = (1.0 + 2.4 * freedom as f64).cos();
    }
}

/// Follows the frequency of the fastest mode of a tree under gravity.
#[derive(Clone)]
pub struct Fastest {
    /// The mode.
    direction: Vec<f64>,
    image: Vec<f64>,
}

impl Fastest {
    /// A search without a known direction.
    pub fn new(freedoms: usize) -> Self {
        let mut fastest = Fastest { direction: vec![0.0; freedoms], image: vec![0.0; freedoms] };
        fastest.forget();
        fastest
    }

    /// Forgets the mode.
    pub fn forget(&mut self) {
        first_direction(&mut self.direction);
    }

    /// The frequency at an instant [rad/s], from below, after some power iterations; zero without stiffness, or if the state is not finite.
    pub fn estimate(
        &mut self,
        dynamics: &mut Dynamics,
        plan: &Plan,
        start: &Start,
        gravity: &[f64; 3],
        iterations: usize,
    ) -> f64 {
        dynamics.set(plan, start, gravity);
        let mut power = 0.0;
        for _ in 0..iterations {
            let size = dynamics.stiffness(plan, start, &self.direction, &mut self.image);
            self.direction.copy_from_slice(&self.image);
            dynamics.solve(plan, start, &mut self.direction);
            let product: f64 = self.direction.iter().zip(&self.image).map(|(a, b)| a * b).sum();
            if !(product / size).is_normal() || product < 0.0 {
                self.forget();
                return 0.0;
            }
            power = product / size;
            let scale = 1.0 / product.sqrt();
            self.direction.iter_mut().for_each(|value| *value *= scale);
        }
        power.sqrt().sqrt()
    }
}
