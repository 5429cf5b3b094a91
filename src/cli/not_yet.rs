//! What files can say and this version cannot simulate: refused before anything is written.

use anyhow::bail;
use catena::model::Model;

/// Refuses a model with couplings or forces that the integrator does not know.
///
/// # Errors
/// What is not simulated yet, and what of it the model has.
pub fn refuse_what_is_not_simulated(model: &Model) -> anyhow::Result<()> {
    let (mechanism, file) = (&model.mechanism, model.path().display());
    if let Some(closing) = mechanism.loops.first() {
        bail!("{file}: closed loops are not simulated yet (loop {:?})", closing.name);
    }
    if let Some(mimic) = mechanism.mimics.first() {
        bail!("{file}: mimic relations are not simulated yet (joint {:?})", mimic.name);
    }
    if !mechanism.forces.is_empty() {
        bail!("{file}: springs, dampers and loads are not simulated yet");
    }
    Ok(())
}
