//! `analog-proc draw`.

use super::{PatchArgs, add_files, expect_output};
use crate::draw;
use desk::{failure::Failure, outcome::Outcome, say};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Draw {
    #[command(flatten)]
    patch: PatchArgs,
    /// SVG file to write; `-` for standard output [default: the patch's name with .svg, here]
    #[arg(long, short)]
    out: Option<PathBuf>,
}

impl Draw {
    pub fn execute(self) -> Result<(), Failure> {
        let out = self.out.unwrap_or_else(|| {
            PathBuf::from(self.patch.patch.file_stem().unwrap_or_default()).with_extension("svg")
        });
        expect_output(&out, &self.patch.patch, &["svg"])?;
        let compiled = self.patch.compile()?;
        let svg = draw::svg(&compiled.ordered);
        let blocks = compiled.ordered.netlist.blocks.len();
        let mut outcome = Outcome::default();
        add_files(&mut outcome, [out.as_path()]);
        if self.patch.json {
            outcome.results.add("blocks", "Blocks", blocks as f64, 17, "", "");
        } else {
            outcome.title = format!("{blocks} blocks drawn to {}", out.display());
        }
        if out.as_os_str() == "-" {
            say!("{svg}");
            return outcome.tell_beside("draw", self.patch.json);
        }
        std::fs::write(&out, svg)
            .map_err(|e| Failure::output(format!("cannot write {}: {e}", out.display())))?;
        outcome.tell("draw", None, self.patch.json)
    }
}
