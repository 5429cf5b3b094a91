//! The report as lines for people.

use crate::mechanism::ground::words::{counted, decimals, rounded};
use crate::output::report::method::OverSlipsReport;
use crate::output::report::{Report, StepErrorReport, WheelsReport};
use crate::simulation::StepChoice;
use std::fmt;

/// Energies below this part of the largest are roundings of it, and written as 0.
const ROUNDING: f64 = 1e-17;
/// More warnings than this are only counted in the lines for people.
const SHOWN_WARNINGS: usize = 10;

impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let simulated = self.duration - self.start;
        let speed = if self.wall_seconds > 0.0 { simulated / self.wall_seconds } else { f64::INFINITY };
        writeln!(
            out,
            "{}: {} s simulated in {:.3} s, {} times real time",
            self.scene,
            // Sums of steps carry roundings, which are cut off for readers.
            (simulated * 1e6).round() / 1e6,
            self.wall_seconds,
            rounded(speed)
        )?;
        let model = &self.model;
        write!(
            out,
            "  model       {}, {}, {}",
            counted(model.links, "link", "links"),
            counted(model.bodies, "moving body", "moving bodies"),
            counted(model.degrees_of_freedom, "degree of freedom", "degrees of freedom")
        )?;
        match (model.loops, model.redundant_constraints) {
            (0, _) => writeln!(out)?,
            (loops, redundant) => {
                writeln!(
                    out,
                    ", {}, {}",
                    counted(loops, "loop", "loops"),
                    counted(redundant, "redundant constraint", "redundant constraints")
                )?;
            }
        }
        match (model.islands, model.sleeping_islands) {
            (0 | 1, 0) => {}
            (1, _) => writeln!(out, "  islands     at rest in equilibrium: not simulated")?,
            (islands, 0) => writeln!(out, "  islands     {islands}")?,
            (islands, all) if islands == all => {
                writeln!(out, "  islands     {islands}, all at rest in equilibrium: not simulated")?
            }
            (islands, asleep) => {
                writeln!(out, "  islands     {islands}, of which {asleep} at rest in equilibrium: not simulated")?;
            }
        }
        if let Some(WheelsReport { shapes, angle, moved }) = model.wheels {
            writeln!(
                out,
                "  wheels      {} turned onto the axes of their joints, by up to {angle:.1e} rad and {moved:.1e} m (--keep wheels)",
                counted(shapes, "shape was", "shapes were")
            )?;
        }
        let method = &self.method;
        write!(
            out,
            "  method      {}, {}, order {}, ",
            method.name,
            counted(method.stages, "stage", "stages"),
            method.order
        )?;
        let step = rounded(1e3 * method.step);
        match (method.tolerance, method.reversible_resets) {
            (Some(tolerance), _) => {
                write!(out, "tolerance {tolerance:e}, mean step {step} ms")?;
                match method.few_stage_steps {
                    0 => {}
                    few => {
                        write!(out, "; {} between given instants with 3 or 5 stages", counted(few, "step", "steps"))?
                    }
                }
                match method.over_slips {
                    OverSlipsReport { steps: 0, .. } => {}
                    OverSlipsReport { steps, time_share, order } => write!(
                        out,
                        "; {} over slips, {} % of the time, order {order}",
                        counted(steps, "step", "steps"),
                        rounded(100.0 * time_share)
                    )?,
                }
                writeln!(out)?;
            }
            (None, Some(resets)) => {
                writeln!(out, "reversible steps, mean {step} ms, {}", counted(resets, "reset", "resets"))?;
            }
            (None, None) if method.digits > 16 => writeln!(out, "step {step} ms, {} digits", method.digits)?,
            (None, None) => writeln!(out, "step {step} ms")?,
        }
        if let Some(from) = &self.from_log {
            writeln!(out, "  start       {}", from.words())?;
        }
        if let Some(accuracy) = &self.accuracy {
            let by = match accuracy.begun {
                1 => "computed along with the run".to_string(),
                2 => "computed along with the run, which restarted once with finer steps".to_string(),
                begun => {
                    format!("computed along with the run, which restarted {} times with finer steps", begun - 1)
                }
            };
            write!(out, "  accuracy    estimated error {:.1e} m (order of magnitude, {by})", accuracy.estimated)?;
            if let Some(between) = accuracy.between_steps.filter(|between| *between > accuracy.estimated) {
                write!(out, ", interpolation between steps adds {between:.1e} m")?;
            }
            if accuracy.is_early {
                write!(out, " up to t = {} s; not known beyond", rounded(accuracy.told_until))?;
            }
            writeln!(out)?;
        }
        if let (Some(unknown), true) = (&self.no_accuracy, self.method.adaptive) {
            writeln!(out, "  accuracy    not known: {}", unknown.reason)?;
        }
        if self.method.stages == StepChoice::OVER_EVENTS && self.step_error.is_none() {
            writeln!(out, "  accuracy    not known: add --check for an estimate by half the step")?;
        }
        if let Some(StepErrorReport { estimated, by }) = self.step_error {
            let more = if by == "energy" { "; more where the motion amplifies errors" } else { "" };
            writeln!(out, "  accuracy    {estimated:.1e} m estimated at the end, by {by}{more}")?;
        }
        write!(
            out,
            "  steps       {}, {}",
            self.steps,
            counted(self.iterations, "Newton iteration", "Newton iterations")
        )?;
        if self.steps > 0 {
            write!(out, " ({:.1} per step", self.iterations as f64 / self.steps as f64)?;
            match 100 * self.kept_factor_iterations / self.iterations.max(1) {
                0 => write!(out, ")")?,
                share => write!(out, ", {share} % reuse a factorisation)")?,
            }
        }
        write!(out, ", {} rejected{}", self.rejected_steps, self.rejected.words())?;
        match self.exact_newton_steps {
            0 => writeln!(out)?,
            all if all == self.steps && all > 1 => writeln!(out, ", all {all} by the exact Newton method")?,
            some => writeln!(out, ", {some} by the exact Newton method")?,
        }
        if self.events.is_nonsmooth {
            writeln!(out, "  events      {}", self.events.counts.words())?;
        }
        writeln!(
            out,
            "  energy      {} J at the start, largest relative error {:.1e}",
            decimals(self.energy.initial),
            self.energy.max_relative_error
        )?;
        let energy = &self.energy;
        let parts = [energy.dissipated, energy.friction, energy.impacts, energy.work, energy.parts.spring];
        let largest = parts.iter().fold(energy.initial.abs(), |largest, part| largest.max(part.abs()));
        let joules = |part: f64| rounded(if part.abs() < ROUNDING * largest { 0.0 } else { part });
        if self.events.is_nonsmooth {
            writeln!(
                out,
                "              {} J dissipated by dampers, {} J by dry friction, {} J lost in impacts, {} J from motors and loads, {} J in springs",
                joules(energy.dissipated),
                joules(energy.friction),
                joules(energy.impacts),
                joules(energy.work),
                joules(energy.parts.spring)
            )?;
        } else if energy.dissipated != 0.0 || energy.work != 0.0 {
            writeln!(
                out,
                "              {} J dissipated by dampers, {} J from motors and loads, {} J in springs",
                joules(energy.dissipated),
                joules(energy.work),
                joules(energy.parts.spring)
            )?;
        }
        writeln!(
            out,
            "  constraint  largest error {:.1e} m, {:.1e} m/s",
            self.constraint.max_position, self.constraint.max_velocity
        )?;
        let contact = &self.contact;
        if contact.may_touch {
            writeln!(out, "  contact     {}", contact.words())?;
        }
        if let Some(words) = self.method.contact_solvers.words() {
            writeln!(out, "  solvers     {words}")?;
        }
        if let Some(log) = &self.log {
            writeln!(out, "  log         {}", log.display())?;
        }
        for warning in self.warnings.iter().take(SHOWN_WARNINGS) {
            writeln!(out, "  warning     {warning}")?;
        }
        if self.warnings.len() > SHOWN_WARNINGS {
            writeln!(out, "  warning     and {} more", self.warnings.len() - SHOWN_WARNINGS)?;
        }
        Ok(())
    }
}
