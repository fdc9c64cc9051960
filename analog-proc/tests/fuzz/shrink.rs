//! Makes a failing patch smaller for as long as it still fails.

use crate::patch::{Block, Patch, Term};

/// The smallest patch found for which `fails` still holds.
pub fn shrink(patch: &Patch, fails: impl Fn(&Patch) -> bool) -> Patch {
    let mut best = patch.clone();
    loop {
        let before = best.clone();
        for i in (0..best.blocks.len()).rev() {
            if i >= best.blocks.len() {
                continue;
            }
            for smaller in [without(&best, i), bypassed(&best, i)] {
                if let Some(smaller) = smaller.filter(|s| *s != best && fails(s)) {
                    best = smaller;
                    break;
                }
            }
        }
        for i in 0..best.blocks.len() {
            while let Some(smaller) = simpler(&best, i).into_iter().find(|s| fails(s)) {
                best = smaller;
            }
        }
        for part in [0.5, 0.8] {
            let mut shorter = best.clone();
            shorter.until_s = (shorter.until_s * part * 1e3).round() / 1e3;
            if shorter.until_s > 0.02 && fails(&shorter) {
                best = shorter;
            }
        }
        if best == before {
            return best;
        }
    }
}

/// Without a block that nothing reads.
fn without(patch: &Patch, i: usize) -> Option<Patch> {
    let mut smaller = patch.clone();
    let block = smaller.blocks.remove(i);
    let read = |b: &mut Block| b.reads().any(|net| block.drives(net));
    (!smaller.blocks.iter_mut().any(read)).then_some(smaller)
}

/// Without a block: those that read it read its first input of the same sort, or the constant.
fn bypassed(patch: &Patch, i: usize) -> Option<Patch> {
    let mut smaller = patch.clone();
    let block = smaller.blocks.remove(i);
    if block.kind == "constant" {
        return None;
    }
    let sort = |net: &str| patch.blocks.iter().find(|b| b.drives(net)).map(Block::is_logic);
    let first = block
        .inputs
        .iter()
        .find(|t| !block.drives(&t.net) && sort(&t.net) == Some(block.is_logic()));
    let instead = match first {
        Some(term) => term.net.clone(),
        None if block.is_logic() => return None,
        None => "n00".into(),
    };
    for other in &mut smaller.blocks {
        for net in other.reads().filter(|net| block.drives(net)) {
            net.clone_from(&instead);
        }
    }
    Some(smaller)
}

/// With one input or field less, or a rounder number.
fn simpler(patch: &Patch, i: usize) -> Vec<Patch> {
    let mut all = Vec::new();
    let block = &patch.blocks[i];
    let mut add = |change: &dyn Fn(&mut Block)| {
        let mut smaller = patch.clone();
        change(&mut smaller.blocks[i]);
        all.push(smaller);
    };
    let many = "integrator summer gain sine cosine limiter dead-zone function relay comparator lag \
                transport-delay abs square track-store";
    if block.is(many) && block.inputs.len() > 1 {
        for k in 0..block.inputs.len() {
            add(&move |b| {
                b.inputs.remove(k);
            });
        }
    }
    for k in 0..block.inputs.len() {
        let unit = |t: &mut Term| t.c = t.c.signum();
        if block.inputs[k].c.abs() != 1.0 {
            add(&move |b| unit(&mut b.inputs[k]));
        }
    }
    for (k, (key, _)) in block.fields.iter().enumerate() {
        let spare = "limits operate reset reset-to hysteresis breakaway modulo ic";
        if block.kind != "limiter" && spare.split(' ').any(|s| s == *key) {
            add(&move |b| {
                b.fields.remove(k);
            });
        }
    }
    all
}
