//! Whether a machine has the blocks that a patch needs.

use crate::net::Netlist;
use crate::order::Ordered;
use crate::patch::{Faults, Flaw, PatchFaults};
use interface::profile::{BlockClass, Profile};
use std::collections::BTreeMap;

/// Blocks of each class that a net needs.
pub fn needs(netlist: &Netlist) -> BTreeMap<BlockClass, u32> {
    let mut needs = BTreeMap::new();
    for class in netlist.blocks.iter().filter_map(|block| block.kind.facts().class) {
        *needs.entry(class).or_insert(0) += 1;
    }
    needs
}

/// Checks that a machine has the blocks for a patch.
///
/// # Errors
/// One fault, with a table of everything that the patch needs against what the machine has.
pub fn against_profile(ordered: &Ordered, profile: &Profile) -> Result<(), PatchFaults> {
    let netlist = &ordered.netlist;
    let needs = needs(netlist);
    let shortfalls = profile.shortfalls(&needs);
    let Some(worst) = shortfalls.first() else {
        return Ok(());
    };
    let takes = |index: &usize| {
        let class = netlist.blocks[*index].kind.facts().class;
        class == Some(worst.class)
            || (worst.class == BlockClass::Dac && class == Some(BlockClass::Mdac))
    };
    let first_without =
        (0..netlist.blocks.len()).filter(takes).nth(worst.available as usize).unwrap_or(0);
    let mut table = format!("  {:<20} {:>7} {:>10}", "class", "needed", "available");
    for class in BlockClass::ALL {
        let short = shortfalls.iter().find(|s| s.class == class);
        let needed = short.map_or(needs.get(&class).copied().unwrap_or(0), |s| s.needed);
        if needed == 0 {
            continue;
        }
        let available =
            profile.available(class).map_or_else(|| "any".to_owned(), |count| count.to_string());
        let mark = if short.is_some() { "  too few" } else { "" };
        let row = format!("\n  {:<20} {needed:>7} {available:>10}{mark}", class.key());
        table.push_str(&row);
    }
    let mut faults = Faults::new(ordered.sources().clone(), ordered.root());
    let block = &netlist.blocks[first_without];
    let help = "take a larger machine (profile `ideal` has no limit), or save blocks: coefficients on inputs need no pots or gains, and a summer in front of an integrator is the integrator's own";
    faults.push(block.span, Flaw::TooManyBlocks { profile: profile.name.clone(), table }, help);
    faults.into_result()
}
