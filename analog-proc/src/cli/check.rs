//! `analog-proc check`: all faults of a patch, or what it is.

use super::{Failure, PatchArgs, is_coloured};
use crate::{net::Kind, order::Ordered, patch, static_check::static_check};
use desk::{command_line::CHECK_FAILED, say};
use interface::{control::StaticCheckLine, profile::Profile};

/// Check a patch.
#[derive(clap::Args)]
pub struct Check {
    #[command(flatten)]
    patch: PatchArgs,
}

/// A patch read, checked against its profile and put in order.
pub struct Compiled {
    pub ordered: Ordered,
    pub hash: String,
}

impl PatchArgs {
    /// Reads, checks and orders the patch; faults come back rendered.
    pub fn compile(&self) -> Result<Compiled, Failure> {
        let faults = |f: patch::PatchFaults| {
            Failure::input(if self.json {
                serde_json::json!({ "faults": f.to_list() }).to_string()
            } else if is_coloured() {
                f.render_coloured()
            } else {
                f.render()
            })
        };
        let profile = Profile::load(&self.profile).map_err(Failure::input)?;
        let bundle = patch::bundle_from_path(&self.patch).map_err(faults)?;
        let mut ordered = patch::compile(&bundle, &self.params).map_err(faults)?;
        crate::check::against_profile(&ordered, &profile).map_err(faults)?;
        crate::tolerance::apply(&mut ordered, profile.component_error());
        Ok(Compiled { hash: bundle.hash(), ordered })
    }
}

impl Check {
    pub fn execute(self) -> Result<(), Failure> {
        let Compiled { ordered, hash } = self.patch.compile()?;
        let mut simulation = ordered.simulation().map_err(Failure::input)?;
        let lines = static_check(&ordered, &mut simulation).map_err(Failure::input)?;
        let warnings = simulation.outlook();
        let disagree = lines.iter().filter(|l| !l.agrees).count();
        let count =
            |f: fn(&Kind) -> bool| ordered.netlist.blocks.iter().filter(|b| f(&b.kind)).count();
        let integrators = count(|k| matches!(k, Kind::Integrator(_) | Kind::Lag(_)));
        let logic = count(Kind::is_logic);
        if self.patch.json {
            let report = serde_json::json!({
                "patch": self.patch.patch,
                "title": ordered.netlist.title,
                "hash": hash,
                "blocks": ordered.netlist.blocks.len(),
                "integrators": integrators,
                "logic": logic,
                "static-check": lines,
                "warnings": warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
            });
            say!("{report:#}");
        } else {
            say!("{}: {}", self.patch.patch.display(), ordered.netlist.title);
            say!(
                "  {} blocks, {integrators} of them integrators or lags, {logic} logic; no faults",
                ordered.netlist.blocks.len()
            );
            for line in &lines {
                say!("  static check {}", describe(line));
            }
            for warning in &warnings {
                say!("  warning: {warning}");
            }
        }
        if disagree > 0 {
            return Err(Failure {
                code: CHECK_FAILED,
                text: format!("static check: {disagree} of {} values disagree", lines.len()),
            });
        }
        Ok(())
    }
}

fn describe(line: &StaticCheckLine) -> String {
    let StaticCheckLine { block, what, expected, found, agrees } = line;
    let verdict = if *agrees { "ok" } else { "DISAGREES" };
    format!("{block} {what}: expected {expected}, found {found}: {verdict}")
}
