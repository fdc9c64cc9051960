//! Routing: each net has one vertical trunk in each gap that it enters, and
//! horizontal branches to its ends there. Trunks are ordered so that few
//! branches cross them, and no two nets run on the same line if that can be helped.

use super::graph::Graph;
use super::layout::{Item, Layout};
use std::collections::BTreeMap;

/// Distance between trunks.
const TRACK: f64 = 9.0;
/// Distance from the symbols to the first trunk.
const MARGIN: f64 = 14.0;
/// Two horizontal branches nearer than this look like one.
const NEAR: f64 = 4.0;

/// One net in one gap.
#[derive(Clone, Debug, Default)]
pub(super) struct Trunk {
    /// Heights of its ends at the left of the gap.
    pub(super) left: Vec<f64>,
    /// Heights of its ends at the right.
    pub(super) right: Vec<f64>,
    pub(super) x: f64,
}

impl Trunk {
    pub(super) fn range(&self) -> (f64, f64) {
        let all = || self.left.iter().chain(&self.right).copied();
        (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max))
    }

    fn is_straight(&self) -> bool {
        let (low, high) = self.range();
        high - low < 0.5
    }
}

/// Trunks of every gap; gap `l` lies left of column `l`.
pub(super) struct Routes {
    pub(super) gaps: Vec<BTreeMap<usize, Trunk>>,
    /// Width of the trunk zone of each gap.
    pub(super) widths: Vec<f64>,
}

pub(super) fn route(graph: &Graph, layout: &Layout) -> Routes {
    let mut gaps: Vec<BTreeMap<usize, Trunk>> = vec![BTreeMap::new(); graph.layers + 1];
    for placed in &layout.items {
        if let Item::Passage { net, .. } = placed.item {
            let here = gaps[placed.layer].entry(net).or_default();
            here.right.push(placed.y);
            let next = gaps[placed.layer + 1].entry(net).or_default();
            next.left.push(placed.y);
        }
    }
    let block_y = |block: usize| {
        let at = layout.index[&(graph.layer[block], Item::Block(block))];
        layout.items[at].y
    };
    for (block, ports) in graph.ports.iter().enumerate() {
        for (port, offset) in ports.iter().zip(&layout.port_offsets[block]) {
            if port.is_tag {
                continue;
            }
            let trunk = gaps[graph.layer[block]].entry(port.net).or_default();
            trunk.right.push(block_y(block) + offset);
            let (driver, output) = graph.driver[port.net];
            let start = gaps[graph.layer[driver] + 1].entry(port.net).or_default();
            let y = block_y(driver) + layout.sizes[driver].outputs[output.min(1)];
            if !start.left.contains(&y) {
                start.left.push(y);
            }
        }
    }
    let widths = gaps.iter_mut().map(arrange).collect();
    Routes { gaps, widths }
}

/// Gives the trunks of a gap their places; returns the width of the zone.
fn arrange(gap: &mut BTreeMap<usize, Trunk>) -> f64 {
    let mut bent: Vec<usize> =
        gap.iter().filter(|(_, trunk)| !trunk.is_straight()).map(|(net, _)| *net).collect();
    let cost = |a: usize, b: usize| left_of(&gap[&a], &gap[&b]);
    // Bubble neighbours into the cheaper order until nothing changes; the cap guards against ties in a ring.
    for _ in 0..bent.len().min(60) {
        let mut has_changed = false;
        for i in 1..bent.len() {
            if cost(bent[i], bent[i - 1]) < cost(bent[i - 1], bent[i]) {
                bent.swap(i - 1, i);
                has_changed = true;
            }
        }
        if !has_changed {
            break;
        }
    }
    // Trunks whose heights do not meet share a track, if what stands between allows it.
    let mut tracks: Vec<Vec<usize>> = Vec::new();
    for net in bent {
        let fits = |other: &usize| {
            let ((low, high), (l, h)) = (gap[&net].range(), gap[other].range());
            high + NEAR < l || h + NEAR < low
        };
        match tracks.last_mut() {
            Some(track) if track.iter().all(fits) => track.push(net),
            _ => tracks.push(vec![net]),
        }
    }
    let width = 2.0 * MARGIN + TRACK * (tracks.len().max(1) - 1) as f64;
    for trunk in gap.values_mut() {
        trunk.x = width / 2.0;
    }
    for (at, track) in tracks.iter().enumerate() {
        for net in track {
            if let Some(trunk) = gap.get_mut(net) {
                trunk.x = MARGIN + TRACK * at as f64;
            }
        }
    }
    width
}

/// Crossings, and (dearer) coincidences, if trunk `a` stands left of trunk `b`.
fn left_of(a: &Trunk, b: &Trunk) -> f64 {
    let ((a_low, a_high), (b_low, b_high)) = (a.range(), b.range());
    let mut cost = 0.0;
    for y in &a.right {
        if *y > b_low && *y < b_high {
            cost += 1.0;
        }
        if b.left.iter().any(|other| (other - y).abs() < NEAR) {
            cost += 20.0;
        }
    }
    for y in &b.left {
        if *y > a_low && *y < a_high {
            cost += 1.0;
        }
    }
    cost
}
