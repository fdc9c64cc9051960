//! A run that goes on from its snapshot in another simulation has the bits of one that was never
//! stopped.

use crate::bench::ordered;
use crate::generator;
use crate::random::Random;
use analog_proc::order::Ordered;
use engine::fault::RunFault;
use engine::id::NetId;
use engine::integration::{Integration, Method};
use engine::simulation::{Pulse, Simulation, SnapshotFault};
use interface::Tick;
use interface::control::PatchBundle;
use std::ops::ControlFlow;

/// Rows, and everything that a report tells of a run.
type Told = (Vec<(u64, Vec<u64>)>, String);

/// Times that a run is stopped and gone on with elsewhere.
const STOPS: usize = 3;

/// Derivative passes of one run; one that needs more is not compared.
const MOST_PASSES: u64 = 100_000;

fn run(ordered: &Ordered, until: Tick, mut rests: Vec<Tick>) -> Told {
    let nets: Vec<NetId> = (0..ordered.netlist.nets.len() as u32).map(NetId).collect();
    let mut rows = Vec::new();
    let Ok(mut simulation) = ordered.simulation() else {
        return (rows, String::new());
    };
    rests.push(Tick(i64::MAX));
    let mut end = None;
    for rest in rests {
        let mut sink = |t_s: f64, row: &[f64]| {
            rows.push((t_s.to_bits(), row.iter().map(|x| x.to_bits()).collect()));
            ControlFlow::Continue(())
        };
        let mut bounded = |pulse: &Pulse| match pulse.statistics.evaluations > MOST_PASSES {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let every = Tick(until.0 / 37);
        let leg = (until, rest);
        let advance = simulation.advance_by_legs(leg, every, &nets, &mut sink, &mut bounded);
        let is_resting = advance.as_ref().is_ok_and(|a| a.stopped_by.is_none())
            && simulation.now_s() < until.secs();
        if matches!(advance, Err(RunFault::Halted { .. })) {
            // How often somebody was asked decides where a run without end was given up.
            return (Vec::new(), String::new());
        }
        end = Some(advance.map_err(|fault| fault.to_string()));
        if !is_resting {
            break;
        }
        let bytes = simulation.snapshot().unwrap();
        simulation = ordered.simulation().unwrap();
        simulation.restore(&bytes).unwrap();
    }
    let last: Vec<u64> = nets.iter().map(|net| simulation.net(*net).to_bits()).collect();
    rows.push((simulation.now_s().to_bits(), last));
    let mut edges = Vec::new();
    simulation.take_edges(&mut edges);
    let (statistics, remarks) = (simulation.statistics(), simulation.remarks());
    let overloads = simulation.overloads();
    (rows, format!("{end:?} {statistics:?} {remarks:?} {overloads:?} {edges:?}"))
}

fn same(name: &str, ordered: &Ordered, until_s: f64, random: &mut Random) -> usize {
    let until = Tick::from_secs(until_s).unwrap();
    let mut rests: Vec<Tick> =
        (0..STOPS).map(|_| Tick((random.between(0.0, 1.0) * until.0 as f64) as i64)).collect();
    rests.sort_unstable();
    let (whole, parts) = (run(ordered, until, Vec::new()), run(ordered, until, rests.clone()));
    assert_eq!(whole.1, parts.1, "{name}, resumed at {rests:?}");
    assert!(whole.0 == parts.0, "{name}, resumed at {rests:?}: rows differ");
    whole.0.len()
}

#[test]
fn random_patches_go_on_from_snapshots_to_the_bit() {
    let mut random = Random::new(0x5eed);
    let mut rows = 0;
    for seed in 0..crate::setting("FUZZ_PATCHES", 300) {
        let patch = generator::patch(seed);
        let Ok(mut ordered) = ordered(&patch.text()) else { continue };
        let methods = [Method::DormandPrince, Method::Sdirk4, Method::RungeKutta4, Method::Euler];
        ordered.netlist.integration = Integration {
            method: methods[if seed % 5 == 0 { 1 + (seed / 5) as usize % 3 } else { 0 }],
            ..Integration::default()
        };
        rows += same(&format!("seed {seed}"), &ordered, patch.until_s, &mut random);
    }
    assert!(rows > 5000, "{rows} rows compared");
}

#[test]
fn shipped_patches_go_on_from_snapshots_to_the_bit() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../patch-files");
    let mut random = Random::new(0x5eed);
    let (mut rows, mut patches) = (0, 0);
    for entry in ["", "/lab", "/sub"].map(|sub| std::fs::read_dir(format!("{folder}{sub}"))) {
        for path in entry.unwrap().map(|entry| entry.unwrap().path()) {
            if path.extension().is_none_or(|e| e != "toml") {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let name =
                |path: &std::path::Path| path.file_name().unwrap().to_str().unwrap().to_owned();
            let files = std::fs::read_dir(path.parent().unwrap()).unwrap();
            let beside = files.map(|entry| entry.unwrap().path());
            let beside = beside.filter(|p| p.extension().is_some_and(|e| e == "toml"));
            let mut files: Vec<(String, String)> =
                beside.map(|p| (name(&p), std::fs::read_to_string(&p).unwrap())).collect();
            files.retain(|file| file.0 == name(&path) || text.contains(&file.0));
            let bundle = PatchBundle { root: name(&path), files };
            let Ok(ordered) = analog_proc::patch::compile(&bundle, &[]) else { continue };
            patches += 1;
            rows += same(&name(&path), &ordered, 2.3, &mut random);
        }
    }
    assert!(patches > 15 && rows > 15 * 38, "{patches} patches, {rows} rows");
}

#[test]
fn a_state_of_another_program_is_refused() {
    let patch = |rate: f64, rtol: f64| {
        let text = format!(
            "[integration]\nrtol = {rtol:?}\n[blocks]\nx = {{ kind = \"integrator\", in = [\"{rate:?} * x\"], ic = 1.0 }}"
        );
        ordered(&text).unwrap().simulation().unwrap()
    };
    let mut mine = patch(-1.0, 1e-9);
    mine.advance_to(Tick(500_000_000)).unwrap();
    let bytes = mine.snapshot().unwrap();
    for mut other in [patch(-1.1, 1e-9), patch(-1.0, 1e-8)] {
        assert_eq!(other.restore(&bytes), Err(SnapshotFault::Foreign));
    }
    let untouched = |simulation: &Simulation| simulation.now_s() == 0.0;
    let mut same = patch(-1.0, 1e-9);
    for cut in 0..bytes.len() {
        assert!(same.restore(&bytes[..cut]).is_err() && untouched(&same), "cut to {cut}");
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(matches!(same.restore(&longer), Err(SnapshotFault::Damaged(_))) && untouched(&same));
    same.restore(&bytes).unwrap();
    assert_eq!(same.now_s(), 0.5);
}
