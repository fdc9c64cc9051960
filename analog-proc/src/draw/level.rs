//! Levelling: the heights of the blocks and wires of each column.
//!
//! Each item wants to be level with its neighbours; the least-squares answer that
//! keeps the distances is found by pooling. Then the last small steps are taken
//! out of the wires, since a step of two pixels looks like a mistake.

use super::layout::{CLEARANCE, Item, Layout, Link, PASSAGE, Placed, sweep};
use std::collections::BTreeMap;

pub(super) fn heights(columns: &[Vec<usize>], layout: &mut Layout, links: &[Link]) {
    let mut of: Vec<Vec<(usize, f64, f64)>> = vec![Vec::new(); layout.items.len()];
    for link in links {
        let shift = link.a_offset - link.b_offset;
        of[link.b].push((link.a, shift, link.weight));
        of[link.a].push((link.b, -shift, link.weight));
    }
    for column in columns {
        let mut y = 0.0;
        for &item in column {
            y += layout.items[item].above;
            layout.items[item].y = y;
            y += layout.items[item].below + CLEARANCE;
        }
        let shift = y / 2.0;
        column.iter().for_each(|i| layout.items[*i].y -= shift);
    }
    for round in 0..40 {
        for column in sweep(columns.len(), round % 2 == 0).map(|layer| &columns[layer]) {
            let wanted: Vec<(f64, f64)> = column
                .iter()
                .map(|&item| {
                    let mut sum = (0.0, 0.0);
                    for &(other, shift, weight) in &of[item] {
                        let is_block = matches!(layout.items[other].item, Item::Block(_));
                        let is_passage = matches!(layout.items[item].item, Item::Passage { .. });
                        // Straight wires first where a wire passes to a wire.
                        let weight = if is_passage && !is_block { 3.0 * weight } else { weight };
                        sum = (sum.0 + weight * (layout.items[other].y + shift), sum.1 + weight);
                    }
                    if sum.1 > 0.0 { (sum.0 / sum.1, sum.1) } else { (layout.items[item].y, 0.05) }
                })
                .collect();
            let gaps: Vec<f64> = column
                .windows(2)
                .map(|pair| distance(&layout.items[pair[0]], &layout.items[pair[1]]))
                .collect();
            for (item, y) in column.iter().zip(pool(&wanted, &gaps)) {
                layout.items[*item].y = y;
            }
        }
    }
}

/// Least distance between the middles of two items of a column, `a` above `b`.
fn distance(a: &Placed, b: &Placed) -> f64 {
    let is_wire = |p: &Placed| matches!(p.item, Item::Passage { .. });
    let clear = match (is_wire(a), is_wire(b)) {
        (true, true) => 0.0,
        (false, false) => CLEARANCE,
        _ => 6.0,
    };
    a.below + b.above + clear
}

/// Takes the last small steps out of wires: first whole passages are levelled,
/// then an item moves to where most of its wires run straight, if its neighbours
/// in the column leave it the room.
pub(super) fn straighten(columns: &[Vec<usize>], layout: &mut Layout, links: &[Link]) {
    /// Farther than this an item is not moved for the sake of a straight wire.
    const REACH: f64 = 40.0;
    /// Heights closer than this are the same.
    const LEVEL: f64 = 0.05;
    let mut of: Vec<Vec<(usize, f64)>> = vec![Vec::new(); layout.items.len()];
    for link in links {
        let shift = link.a_offset - link.b_offset;
        if layout.items[link.a].layer != layout.items[link.b].layer {
            of[link.b].push((link.a, shift));
            of[link.a].push((link.b, -shift));
        }
    }
    for round in 0..8 {
        let is_forward = round % 2 == 0;
        level_passages(columns, layout);
        for column in sweep(columns.len(), is_forward).map(|layer| &columns[layer]) {
            for (at, &item) in column.iter().enumerate() {
                let (low, high) = room(column, at, layout);
                let here = &layout.items[item];
                let wanted: Vec<(f64, bool)> = of[item]
                    .iter()
                    .map(|(other, shift)| {
                        let other = &layout.items[*other];
                        (other.y + shift, other.layer < here.layer)
                    })
                    .collect();
                let straight = |y: f64| wanted.iter().filter(|w| (w.0 - y).abs() < LEVEL).count();
                let mut best = (straight(here.y), here.y);
                for &(candidate, is_left) in &wanted {
                    let fits = candidate >= low && candidate <= high;
                    let count = straight(candidate);
                    // Ties move too, after the side that has just been placed, so that a chain lines up.
                    let is_better = count > best.0 || (count == best.0 && is_forward == is_left);
                    if fits && (candidate - here.y).abs() < REACH && is_better {
                        best = (count, candidate);
                    }
                }
                layout.items[item].y = best.1;
            }
        }
    }
    level_passages(columns, layout);
}

/// Heights between which an item of a column may move.
fn room(column: &[usize], at: usize, layout: &Layout) -> (f64, f64) {
    let here = &layout.items[column[at]];
    let low = at.checked_sub(1).map_or(f64::NEG_INFINITY, |before| {
        let other = &layout.items[column[before]];
        other.y + distance(other, here)
    });
    let high = column.get(at + 1).map_or(f64::INFINITY, |after| {
        let other = &layout.items[*after];
        other.y - distance(here, other)
    });
    (low, high)
}

/// Brings the passages of a wire through neighbouring columns to one height, from the outside inwards.
fn level_passages(columns: &[Vec<usize>], layout: &mut Layout) {
    let mut place = vec![0; layout.items.len()];
    for column in columns {
        for (at, item) in column.iter().enumerate() {
            place[*item] = at;
        }
    }
    let mut wires: BTreeMap<(usize, bool), Vec<usize>> = BTreeMap::new();
    for (at, item) in layout.items.iter().enumerate() {
        if let Item::Passage { net, back } = item.item {
            wires.entry((net, back)).or_default().push(at);
        }
    }
    let mean = |wire: &[usize], layout: &Layout| {
        wire.iter().map(|i| layout.items[*i].y).sum::<f64>() / wire.len() as f64
    };
    let mut wires: Vec<Vec<usize>> = wires.into_values().filter(|w| w.len() > 1).collect();
    wires.sort_by(|a, b| mean(b, layout).abs().total_cmp(&mean(a, layout).abs()));
    for wire in wires {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for item in &wire {
            let column = &columns[layout.items[*item].layer];
            let (l, h) = room(column, place[*item], layout);
            (low, high) = (low.max(l), high.min(h));
        }
        if low <= high {
            let y = mean(&wire, layout).clamp(low, high);
            wire.iter().for_each(|item| layout.items[*item].y = y);
        } else {
            push_out(&wire, columns, &place, (low, high), layout);
        }
    }
}

/// Levels a wire that has no room by pushing the wires beyond it outwards, where only wires are.
fn push_out(
    wire: &[usize],
    columns: &[Vec<usize>],
    place: &[usize],
    (low, high): (f64, f64),
    layout: &mut Layout,
) {
    let is_below = wire.iter().map(|i| layout.items[*i].y).sum::<f64>() > 0.0;
    let beyond = |item: usize| -> Vec<usize> {
        let column = &columns[layout.items[item].layer];
        let at = place[item];
        if is_below {
            column[at + 1..].to_vec()
        } else {
            column[..at].iter().rev().copied().collect()
        }
    };
    let outer: Vec<Vec<usize>> = wire.iter().map(|item| beyond(*item)).collect();
    let is_wire = |item: &usize| matches!(layout.items[*item].item, Item::Passage { .. });
    if !outer.iter().flatten().all(is_wire) {
        return;
    }
    let y = if is_below { low } else { high };
    for (item, outer) in wire.iter().zip(outer) {
        layout.items[*item].y = y;
        let mut limit = y;
        for other in outer {
            let wanted = layout.items[other].y;
            let moved =
                if is_below { wanted.max(limit + PASSAGE) } else { wanted.min(limit - PASSAGE) };
            layout.items[other].y = moved;
            limit = moved;
        }
    }
}

/// Least squares of `weight · (y − wanted)²` with `y[i+1] − y[i] ≥ gaps[i]` (pool adjacent violators).
fn pool(wanted: &[(f64, f64)], gaps: &[f64]) -> Vec<f64> {
    // With u[i] = y[i] − Σ gaps before i the constraint is that u does not decrease.
    let mut before = 0.0;
    let mut pools: Vec<(f64, f64, usize)> = Vec::new();
    for (i, (value, weight)) in wanted.iter().enumerate() {
        if i > 0 {
            before += gaps[i - 1];
        }
        let mut next = (value - before, *weight, 1);
        while let Some(&last) = pools.last().filter(|last| last.0 > next.0) {
            pools.pop();
            let weight = last.1 + next.1;
            let mean = (last.0 * last.1 + next.0 * next.1) / weight;
            next = (mean, weight, last.2 + next.2);
        }
        pools.push(next);
    }
    let mut out = Vec::with_capacity(wanted.len());
    let mut before = 0.0;
    for (mean, _, count) in pools {
        for _ in 0..count {
            if !out.is_empty() {
                before += gaps[out.len() - 1];
            }
            out.push(mean + before);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::pool;

    #[test]
    fn pooling_keeps_distances_and_the_mean() {
        let y = pool(&[(0.0, 1.0), (0.0, 1.0), (100.0, 1.0)], &[10.0, 10.0]);
        // Two that want the same place share it evenly; the third is free. Exact in binary.
        assert_eq!(y, [-5.0, 5.0, 100.0]);
    }
}
