//! `analog-proc check`: all faults of a patch, or what it is.

use super::{PatchArgs, is_coloured};
use crate::{
    net::{Kind, Net, Netlist},
    order::Ordered,
    patch,
    session::static_check::static_check,
};
use desk::{
    failure::Failure,
    faults::FileFault,
    outcome::Outcome,
    report::{Column, Table},
};
use engine::{id::NetId, simulation::Simulation};
use interface::control::StaticCheckLine;
use std::path::Path;

/// Check a patch: all its faults at once, what it is made of, and whether it starts where its
/// `[expect]` says.
///
///   analog-proc check patch-files/van-der-pol.toml
///   analog-proc check patch-files/van-der-pol.toml --values --set mu=5
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Check {
    #[command(flatten)]
    patch: PatchArgs,
    /// Show the output of every block at IC, and the derivative of each that has one
    #[arg(long)]
    values: bool,
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
            let text = if is_coloured() { f.render_coloured() } else { f.render() };
            let folder = self.patch.parent().unwrap_or(Path::new(""));
            let told =
                |f: FileFault| FileFault { file: folder.join(&f.file).display().to_string(), ..f };
            let faults = f.to_list().into_iter().map(told).collect();
            Failure { faults, ..Failure::input(text) }
        };
        let profile = desk::profile::load(&self.profile)?;
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
        let blocks = &ordered.netlist.blocks;
        let count = |f: fn(&Kind) -> bool| blocks.iter().filter(|b| f(&b.kind)).count();
        let integrators = count(|k| matches!(k, Kind::Integrator(_) | Kind::Lag(_)));
        let title = format!("{}: {}", self.patch.patch.display(), ordered.netlist.title);
        let mut outcome = Outcome::new(title, "");
        for (key, label, count) in [
            ("blocks", "Blocks, without faults", blocks.len()),
            ("integrators", "  of them integrators and lags", integrators),
            ("logic", "  of them logic", count(Kind::is_logic)),
        ] {
            outcome.results.add(key, label, count as f64, 17, "", "");
        }
        let patch = [Column::new("SHA-256", "", |hash: &String| hash.as_str().into())];
        let columns = [
            Column::new("Block", "", |l: &StaticCheckLine| l.block.as_str().into()),
            Column::new("What", "", |l: &StaticCheckLine| l.what.as_str().into()),
            Column::new("Expected", "", |l: &StaticCheckLine| l.expected.into()).digits(17),
            Column::new("Found", "", |l: &StaticCheckLine| l.found.into()).digits(17),
            Column::new("Verdict", "", |l: &StaticCheckLine| {
                if l.agrees { "agrees" } else { "DISAGREES" }.into()
            }),
        ];
        let mut section = outcome.section("").long_table("patch", "", Table::of(&patch, [&hash]));
        if !lines.is_empty() {
            section = section.table("static_check", "Static check", Table::of(&columns, &lines));
        }
        if self.values {
            let rows = at_ic(&ordered.netlist, &simulation);
            let columns = [
                Column::new("Net", "", |v: &AtIc| v.net.into()),
                Column::new("Kind", "", |v: &AtIc| v.kind.into()),
                Column::new("Output", "", |v: &AtIc| v.output.into()).digits(17),
                Column::new("Derivative", "1/s", |v: &AtIc| v.derivative.into()).digits(17),
            ];
            section.table("values", "At IC", Table::of(&columns, &rows));
        }
        outcome.remarks = warnings.iter().map(|warning| format!("warning: {warning}")).collect();
        let disagree = lines.iter().filter(|l| !l.agrees).count();
        if disagree > 0 {
            let text = format!("static check: {disagree} of {} values disagree", lines.len());
            outcome.refused.push(text);
        }
        outcome.tell("check", None, self.patch.json)
    }
}

/// A net at IC.
struct AtIc<'a> {
    net: &'a str,
    kind: &'static str,
    output: f64,
    derivative: Option<f64>,
}

fn at_ic<'a>(netlist: &'a Netlist, simulation: &Simulation) -> Vec<AtIc<'a>> {
    let value = |(net, i): (&'a Net, u32)| AtIc {
        net: &net.name,
        kind: netlist.blocks[net.driver.index()].kind.name(),
        output: simulation.net(NetId(i)),
        derivative: simulation.derivative(net.driver),
    };
    netlist.nets.iter().zip(0..).map(value).collect()
}
