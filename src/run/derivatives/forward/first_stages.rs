//! The first guess of the stages of a step: those of the run, or the cubic curve through both ends.
//!
//! ```text
//!     y(c) = h v₀ c + (3Δ − 2 h v₀ − h v₁) c² + (h v₀ + h v₁ − 2Δ) c³        Δ = y₁ − y₀
//! ```

use crate::derivatives::forward::between::motion_between;
use crate::derivatives::forward::step::StepProblem;
use crate::mechanism::motion::state::State;

impl StepProblem<'_> {
    /// Stages i = 2..s: the known ones of the run, moved along with the start, otherwise on a cubic curve through both ends.
    pub(super) fn first_stages(&self) -> Vec<State> {
        let StepProblem { mechanism, tableau, start, begun, toward, inside, .. } = *self;
        let mut stages = if inside.len() + 2 == tableau.stages {
            let moved = motion_between(mechanism, begun, start);
            let mut stages: Vec<State> = inside.iter().chain([toward]).cloned().collect();
            for (stage, node) in stages.iter_mut().zip(&tableau.nodes[1..]) {
                let gone = self.step * node;
                let faster = |freedom: usize| start.velocity[freedom] - begun.velocity[freedom];
                let along: Vec<f64> = (0..moved.len()).map(|freedom| moved[freedom] + gone * faster(freedom)).collect();
                stage.displace(mechanism, &along);
            }
            stages
        } else {
            self.on_a_cubic()
        };
        for (stage, node) in stages.iter_mut().zip(&tableau.nodes[1..]) {
            stage.time = start.time + self.step * node;
        }
        stages
    }

    /// Stages i = 2..s on a cubic curve through both ends.
    fn on_a_cubic(&self) -> Vec<State> {
        let (tableau, h, start) = (self.tableau, self.step, self.start);
        let whole = motion_between(self.mechanism, start, self.toward);
        let is_near = self.toward.time > start.time;
        let mut free = vec![false; start.velocity.len()];
        self.mode.free.iter().for_each(|&freedom| free[freedom] = true);
        let at = |i: usize| {
            let c = tableau.nodes[i];
            let along = |freedom: usize| {
                let first = h * start.velocity[freedom];
                if !free[freedom] {
                    return 0.0;
                }
                if !is_near {
                    return c * first;
                }
                let (all, last) = (whole[freedom], h * self.toward.velocity[freedom]);
                c * (first + c * (3.0 * all - 2.0 * first - last + c * (first + last - 2.0 * all)))
            };
            let moved: Vec<f64> = (0..free.len()).map(along).collect();
            let mut stage = start.clone();
            stage.displace(self.mechanism, &moved);
            stage
        };
        (1..tableau.stages).map(at).collect()
    }
}
