//! The static check: outputs and derivatives at IC against the patch's own figures.
//!
//! What an operator did with a voltmeter before the first OPERATE: it finds a
//! forgotten wire or a wrong sign before anything moves.

use crate::order::Ordered;
use engine::{fault::RunFault, simulation::Simulation};
use interface::control::StaticCheckLine;

/// Resets the machine and compares every value that the patch expects.
pub fn static_check(
    ordered: &Ordered,
    simulation: &mut Simulation,
) -> Result<Vec<StaticCheckLine>, RunFault> {
    simulation.reset()?;
    let netlist = &ordered.netlist;
    let mut lines = Vec::new();
    for expected in &netlist.expected {
        let net = &netlist.nets[expected.net.index()];
        let mut line = |what: &str, wanted: Option<f64>, found: Option<f64>| {
            let Some(wanted) = wanted else { return };
            // A block without a derivative cannot agree with an expected one.
            let found = found.unwrap_or(f64::NAN);
            lines.push(StaticCheckLine {
                block: net.name.clone(),
                what: what.to_owned(),
                expected: wanted,
                found,
                agrees: (found - wanted).abs() <= expected.tolerance,
            });
        };
        line("output", expected.output, Some(simulation.net(expected.net)));
        line("derivative", expected.derivative, simulation.derivative(net.driver));
    }
    Ok(lines)
}
