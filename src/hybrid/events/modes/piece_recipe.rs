//! How the steps of a piece are made: by the scheme, or by another method for comparison.

use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::stepping::integrator::MethodError;
use crate::stepping::recipe::{Recipe, Steps};
use crate::stepping::spans::SpanSteps;
use crate::stepping::step_maker::PieceSteps;
use crate::stepping::trees::other_tree::OnOtherTree;

/// Makes the steps of another method for a mechanism, with a tolerance (m).
pub type OtherMethod = fn(&Mechanism, f64) -> Box<dyn PieceSteps>;

/// How the steps of pieces are made.
#[derive(Clone, Debug)]
pub(crate) enum PieceRecipe {
    /// The scheme.
    Lobatto(Recipe),
    /// Another method with this tolerance (m), of trees alone.
    Other(OtherMethod, f64),
}

impl PieceRecipe {
    /// The integrator of the reduced mechanism, with efforts from outside in the joints of these bodies.
    ///
    /// # Errors
    /// [`MethodError`] for impossible stages and steps.
    pub fn make(&self, mechanism: &Mechanism, driven: &[usize]) -> Result<Box<dyn PieceSteps>, MethodError> {
        Ok(match self {
            PieceRecipe::Lobatto(recipe) => match OnOtherTree::new(mechanism, driven, recipe)? {
                Some(other) => Box::new(other),
                None => Box::new(SpanSteps::new(mechanism, recipe)?),
            },
            PieceRecipe::Other(make, tolerance) => make(mechanism, *tolerance),
        })
    }

    /// The method description used while every joint is held.
    ///
    /// # Errors
    /// As of [`PieceRecipe::make`].
    pub fn idle(&self, whole: &Mechanism) -> Result<MethodDescription, MethodError> {
        let nothing = Mechanism {
            bodies: Vec::new(),
            loops: Vec::new(),
            mimics: Vec::new(),
            forces: Default::default(),
            position_count: 0,
            velocity_count: 0,
            ..whole.clone()
        };
        Ok(self.make(&nothing, &[])?.description())
    }

    /// A program asks for every step.
    pub fn expect_to_be_asked(&mut self) {
        if let PieceRecipe::Lobatto(recipe) = self {
            recipe.asked_for = true;
        }
    }

    /// Whether a rule is switched off.
    pub fn keeps(&self, rule: Rule) -> bool {
        matches!(self, PieceRecipe::Lobatto(recipe) if recipe.kept.contains(&rule))
    }

    /// The tolerance (m) and the number of stages of steps of the scheme that are chosen from it.
    pub fn chosen(&self) -> Option<(f64, usize)> {
        match self {
            PieceRecipe::Lobatto(Recipe { steps: Steps::Chosen { tolerance, stages, .. }, .. }) => {
                Some((*tolerance, stages.count()))
            }
            PieceRecipe::Lobatto(Recipe { steps: Steps::Fixed { .. }, .. }) | PieceRecipe::Other(..) => None,
        }
    }

    /// The number of stages of given steps.
    pub fn given(&self) -> Option<usize> {
        match self {
            PieceRecipe::Lobatto(Recipe { steps: Steps::Fixed { stages, .. }, .. }) => Some(*stages),
            PieceRecipe::Lobatto(Recipe { steps: Steps::Chosen { .. }, .. }) | PieceRecipe::Other(..) => None,
        }
    }

    /// The tolerance from which steps are chosen (m); `None` for given steps.
    pub fn tolerance(&self) -> Option<f64> {
        match self {
            PieceRecipe::Lobatto(Recipe { steps: Steps::Fixed { .. }, .. }) => None,
            PieceRecipe::Lobatto(Recipe { steps: Steps::Chosen { tolerance, .. }, .. })
            | PieceRecipe::Other(_, tolerance) => Some(*tolerance),
        }
    }
}
