//! `analog-proc draw`.

use super::{Failure, PatchArgs, expect_output};
use crate::draw;
use desk::say;
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
        if out.as_os_str() == "-" {
            say!("{svg}");
            return Ok(());
        }
        std::fs::write(&out, svg)
            .map_err(|e| Failure::output(format!("cannot write {}: {e}", out.display())))?;
        say!("{} blocks drawn to {}", compiled.ordered.netlist.blocks.len(), out.display());
        Ok(())
    }
}
