//! Whether the default settings tell the truth about a patch.
//!
//! The same patch runs with default settings; with steps of a hundredth of a radian of its
//! quickest source (the reference); with a second method in steps as small; and with tolerances
//! ten times tighter and looser. All nets are compared at the end and at sixteen instants
//! before it. Two answers agree where they differ by 1e-7 of the net's greatest value.
//!
//! A greater difference is no fault of the engine where the patch itself leaves the answer open:
//! the reference run is repeated with every number of the patch off by 1e-9 (and by 1e-11), and
//! a net is *sensitive* where the difference is less than ten times what that changes: the
//! answer is then the exact one of a patch within the 1e-8 that the default settings claim.
//!
//! Fixed steps have no error to end a run by. Where something turns ever faster (a divisor that
//! follows what sticks at zero, at a rate of one over it), no step is short enough, and what
//! follows is off by a finite amount, also the instant of a fault. The run then says so in a
//! remark, and that counts as said, whether it ends by itself or by the fault.
//!
//! It is long, but one judgement: each excuse rests on the ones before it.

use crate::bench::ordered;
use crate::patch::Patch;
use crate::random::Random;
use analog_proc::order::Ordered;
use engine::fault::RunFault;
use engine::remark::Remark;
use engine::simulation::{Pulse, Simulation};
use engine::{
    id::NetId,
    integration::{Integration, Method},
};
use interface::Tick;
use std::ops::ControlFlow;

/// Rows compared before the end.
const ROWS: usize = 16;

/// Step of the reference and of the second method, s: 0.0126 rad of the quickest generator.
const FINE_S: f64 = 2.5e-4;

/// Agreement, relative to a net's greatest value: ten times the claim of the default settings.
const TOLERANCE: f64 = 1e-7;

/// Agreement with looser tolerances and with the fixed steps of the second method.
const COARSE: f64 = 3e-6;

/// Derivative passes of one run: ten times what the reference's steps need.
const MOST_PASSES: u64 = 1_000_000;

/// Beyond this a patch is not well scaled, and not judged.
const LARGEST: f64 = 1e5;

/// Loss of digits that is still put down to the tolerances, relative to a net's greatest value.
const TOLERABLE: f64 = 1e-5;

/// Draws of a perturbed patch until the compiler takes one.
const DRAWS: usize = 32;

/// All nets at some instants, from the start to the end.
type Rows = Vec<Vec<f64>>;

/// How a patch was judged.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// All runs agree.
    Agreed,
    /// All runs end in the same fault at the same instant.
    SameFault,
    /// Default settings refuse by a fault what the others run through.
    Refused(String),
    /// The answers differ by less than the patch's own sensitivity accounts for.
    Sensitive,
    /// They differ, and a remark of the run says so.
    Flagged,
    /// Values too large, or a patch that the compiler refuses.
    Unfit(String),
    /// One of the runs takes work beyond all bounds.
    Endless(String),
    /// Silently wrong.
    Wrong(String),
}

#[derive(Clone, Debug)]
struct Fault {
    kind: &'static str,
    t_s: f64,
    text: String,
}

fn fault(fault: &RunFault) -> Fault {
    let (kind, t_s) = match fault {
        RunFault::NonFinite { t_s, .. }
        | RunFault::StepUnderflow { t_s, .. }
        | RunFault::TooQuick { t_s, .. }
        | RunFault::NotFollowed { t_s, .. } => ("singular", *t_s),
        RunFault::Halted { t_s } => ("endless", *t_s),
        RunFault::DividedByZero { t_s, .. } => ("divisor", *t_s),
        RunFault::NegativeRoot { t_s, .. } => ("root", *t_s),
        RunFault::LogicRace { t_s, .. } => ("race", *t_s),
        RunFault::Chatter { t_s, .. } => ("chatter", *t_s),
        _ => ("setting", 0.0),
    };
    Fault { kind, t_s, text: fault.to_string() }
}

fn simulate(ordered: &Ordered, integration: Integration, until_s: f64) -> Result<Rows, Fault> {
    remarked(ordered, integration, until_s).0
}

/// A run, and whether it had a remark to make; of one that ended by a fault, on its fixed steps.
fn remarked(
    ordered: &Ordered,
    integration: Integration,
    until_s: f64,
) -> (Result<Rows, Fault>, bool) {
    let mut ordered = ordered.clone();
    ordered.netlist.integration = integration;
    let mut simulation = match ordered.simulation() {
        Ok(simulation) => simulation,
        Err(f) => return (Err(fault(&f)), false),
    };
    let run = recorded(&ordered, &mut simulation, until_s);
    let remarks = simulation.remarks();
    let counts = |remark: &Remark| run.is_ok() || matches!(remark, Remark::Coarse { .. });
    let said = remarks.iter().any(counts);
    (run, said)
}

fn recorded(ordered: &Ordered, simulation: &mut Simulation, until_s: f64) -> Result<Rows, Fault> {
    let nets: Vec<NetId> = (0..ordered.netlist.nets.len() as u32).map(NetId).collect();
    let end = Tick::from_secs(until_s).unwrap();
    let every = Tick(end.0 / (ROWS as i64 + 1));
    // The start among them: what decays is measured by what it was.
    let mut rows = Vec::with_capacity(ROWS + 2);
    rows.push(nets.iter().map(|n| simulation.net(*n)).collect());
    let mut sink = |_: f64, row: &[f64]| {
        rows.push(row.to_vec());
        ControlFlow::Continue(())
    };
    let mut bounded = |pulse: &Pulse| {
        if pulse.statistics.evaluations > MOST_PASSES {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    simulation
        .advance_recording_attended(end, every, &nets, &mut sink, &mut bounded)
        .map_err(|f| fault(&f))?;
    rows.truncate(ROWS + 1);
    rows.push(nets.iter().map(|n| simulation.net(*n)).collect());
    Ok(rows)
}

fn fine() -> Integration {
    Integration { max_step_s: FINE_S, ..Integration::default() }
}

fn implicit() -> Integration {
    Integration { method: Method::Sdirk4, max_step_s: 0.02, ..Integration::default() }
}

/// The greatest values of each net.
fn scales(rows: &Rows) -> Vec<f64> {
    (0..rows[0].len()).map(|net| rows.iter().map(|r| r[net].abs()).fold(0.0, f64::max)).collect()
}

/// The greatest differences of each net.
fn differences(a: &Rows, b: &Rows) -> Vec<f64> {
    (0..a[0].len())
        .map(|net| {
            let pairs = a.iter().zip(b).map(|(a, b)| (a[net] - b[net]).abs());
            pairs.fold(0.0, |w, d| if d > w || d.is_nan() { d } else { w })
        })
        .collect()
}

/// Nets that differ by more than `relative` of their greatest values.
fn differing(a: &Rows, b: &Rows, relative: f64) -> Vec<usize> {
    let scales = scales(b);
    let differences = differences(a, b);
    (0..scales.len()).filter(|net| differences[*net] > relative * scales[*net] + 1e-12).collect()
}

/// What the reference run changes by where the numbers of the patch change, as fractions of 1e-9;
/// and whether it changes by a fault.
struct Sensitivity {
    nets: Vec<f64>,
    faults: Vec<Result<(), Fault>>,
}

fn sensitivity(patch: &Patch, reference: &Result<Rows, Fault>, nets: usize) -> Sensitivity {
    let mut random = Random::new(1);
    let mut result = Sensitivity { nets: vec![0.0; nets], faults: Vec::new() };
    // Besides, steps a little shorter: what changes by them is left to rounding.
    let settings = [(1e-9, 1.0), (1e-9, 1.0), (1e-9, 1.0), (1e-9, 0.9), (1e-11, 0.8), (0.0, 0.7)];
    for (relative, part) in settings {
        // An initial condition at a limit may be off beyond it: then another draw.
        let mut draws = (0..DRAWS).map(|_| ordered(&patch.perturbed(relative, &mut random).text()));
        let Some(ordered) = draws.find_map(Result::ok) else {
            continue;
        };
        let shorter = Integration { max_step_s: part * FINE_S, ..fine() };
        let run = simulate(&ordered, shorter, patch.until_s);
        if let (Ok(run), Ok(reference)) = (&run, reference) {
            for (net, difference) in differences(reference, run).into_iter().enumerate() {
                result.nets[net] = f64::max(result.nets[net], difference);
            }
        }
        result.faults.push(run.map(|_| ()));
    }
    result
}

/// Whether two ends by a fault are one.
fn same(a: &Fault, b: &Fault) -> bool {
    let off = (a.t_s - b.t_s).abs();
    off < match (a.kind, b.kind) {
        ("divisor", "divisor") | ("race", "race") => 1e-6,
        // A radicand that slows down towards zero (the root drives what it is taken of) touches it:
        // the tolerance, 1e-10, moves the instant by its root.
        ("root", "root") => 1e-5,
        // Switchings that accumulate, and singularities that are approached, end where the last
        // step that still fits ends.
        _ => 1e-2,
    }
}

/// Whether fixed steps differ by their own error, which nothing bounds (near a pole, near the
/// origin of an angle, in a sine as quick as the step), and not in what switches alone: steps of
/// a sixteenth, or a third method, whose error is controlled, come closer by more than a third.
fn errs_alone(
    ordered: &Ordered,
    integration: Integration,
    until_s: f64,
    run: &Result<Rows, Fault>,
    reference: &Result<Rows, Fault>,
) -> bool {
    let (Method::RungeKutta4, Ok(reference)) = (integration.method, reference) else {
        return false;
    };
    let is_whole = |net: usize| reference.iter().all(|row| row[net].fract() == 0.0);
    let own = match run {
        Ok(run) if differing(run, reference, COARSE).into_iter().all(is_whole) => return false,
        Ok(run) => differences(run, reference),
        Err(fault) if matches!(fault.kind, "divisor" | "root" | "singular") => {
            vec![f64::INFINITY; reference[0].len()]
        }
        Err(_) => return false,
    };
    let finer = Integration { step_s: integration.step_s / 16.0, ..integration };
    let closer = |rows: &Rows| {
        let error = differences(rows, reference);
        let mut differing = differing(rows, reference, COARSE).into_iter();
        differing.all(|net| error[net] < own[net] / 3.0)
    };
    let comes_closer =
        |other: Integration| simulate(ordered, other, until_s).is_ok_and(|rows| closer(&rows));
    if comes_closer(implicit()) || comes_closer(finer) {
        return true;
    }
    // Sines so quick that the third method does not end bound the fixed steps too, at an eighth
    // of a turn: four digits are left.
    let close = |run: &Rows| differing(run, reference, 1e-4).is_empty();
    run.as_ref().is_ok_and(close)
}

/// Whether other settings come to the same, as far as they come to an end.
fn passes(
    ordered: &Ordered,
    others: [Integration; 3],
    until_s: f64,
    run: &Result<Rows, Fault>,
) -> bool {
    let Ok(run) = run else { return false };
    let others = others.map(|other| simulate(ordered, other, until_s).ok());
    let mut ended = others.iter().flatten().peekable();
    ended.peek().is_some() && ended.all(|rows| differing(run, rows, COARSE).is_empty())
}

/// Whether a small difference shrinks with the tolerances: what the patch makes of the errors they
/// leave in every step, and no event missed.
fn loses_digits(
    ordered: &Ordered,
    tight: Integration,
    until_s: f64,
    run: &Result<Rows, Fault>,
    reference: &Result<Rows, Fault>,
) -> bool {
    let (Ok(run), Ok(reference)) = (run, reference) else {
        return false;
    };
    let Ok(tight) = simulate(ordered, tight, until_s) else {
        return false;
    };
    let (own, tight) = (differences(run, reference), differences(&tight, reference));
    if !differing(run, reference, TOLERABLE).is_empty() {
        return false;
    }
    let mut differing = differing(run, reference, TOLERANCE).into_iter();
    differing.all(|net| tight[net] < 0.35 * own[net])
}

/// Judges one run against the reference. `None`: they agree.
fn against(
    what: &str,
    run: &Result<Rows, Fault>,
    reference: &Result<Rows, Fault>,
    relative: f64,
    names: &[String],
    felt: &mut impl FnMut() -> Sensitivity,
) -> Option<Verdict> {
    match (run, reference) {
        // Fixed steps pass over singularities: they have no error to see them by,
        // and what they make of the growth before is work without bound.
        (_, Err(b)) if what == "second method" && b.kind == "singular" => None,
        (Err(a), _) if a.kind == "endless" => Some(Verdict::Endless(format!("{what}: {}", a.text))),
        (Err(a), Err(b)) if same(a, b) => None,
        (Ok(a), Ok(b)) => {
            let differing = differing(a, b, relative);
            if differing.is_empty() {
                return None;
            }
            let sensitivity = felt();
            if sensitivity.faults.iter().any(Result::is_err) {
                return Some(Verdict::Sensitive);
            }
            let differences = differences(a, b);
            let factor = 10.0 * relative / TOLERANCE;
            let wrong: Vec<usize> = differing
                .into_iter()
                .filter(|net| differences[*net] > factor * sensitivity.nets[*net])
                .collect();
            if wrong.is_empty() {
                return Some(Verdict::Sensitive);
            }
            let mut text = format!("{what}:");
            for net in wrong.iter().take(6) {
                let (a, b) = (a[ROWS + 1][*net], b[ROWS + 1][*net]);
                text += &format!(
                    " {} = {a:?} instead of {b:?} (differs by up to {:.2e}, sensitive to {:.1e});",
                    names[*net], differences[*net], sensitivity.nets[*net]
                );
            }
            Some(Verdict::Wrong(text))
        }
        (a, b) => {
            let sensitivity = felt();
            let like = |run: &Result<(), Fault>, other: &Result<Rows, Fault>| match (run, other) {
                (Ok(()), Ok(_)) => true,
                (Err(a), Err(b)) => same(a, b),
                _ => false,
            };
            if sensitivity.faults.iter().any(|f| !like(f, b)) {
                return Some(Verdict::Sensitive);
            }
            let tell = |run: &Result<Rows, Fault>| match run {
                Ok(_) => "no fault".to_string(),
                Err(fault) => fault.text.clone(),
            };
            let text = format!("{what}: {} instead of {}", tell(a), tell(b));
            let refuses = |fault: &Fault| matches!(fault.kind, "singular" | "chatter");
            match (a, b) {
                (Err(a), _) if refuses(a) => Some(Verdict::Refused(text)),
                (_, Err(b)) if b.kind == "chatter" => Some(Verdict::Refused(text)),
                // The default settings have ended as the reference does, or this was not asked.
                (_, Err(b)) if what != "default" && refuses(b) => Some(Verdict::Refused(text)),
                _ => Some(Verdict::Wrong(text)),
            }
        }
    }
}

/// Judges a patch; `seed` chooses the second method.
pub fn judge(patch: &Patch, seed: u64) -> Verdict {
    let ordered = match ordered(&patch.text()) {
        Ok(ordered) => ordered,
        Err(faults) => return Verdict::Unfit(faults),
    };
    let names: Vec<String> = ordered.netlist.nets.iter().map(|n| n.name.clone()).collect();
    let until_s = patch.until_s;
    let reference = simulate(&ordered, fine(), until_s);
    if let Ok(rows) = &reference
        && scales(rows).iter().any(|s| *s > LARGEST)
    {
        return Verdict::Unfit("too large".into());
    }
    if let Err(fault) = &reference
        && fault.kind == "endless"
    {
        return Verdict::Endless(format!("reference: {}", fault.text));
    }
    let default = Integration::default();
    let second = if seed.is_multiple_of(8) {
        implicit()
    } else {
        Integration { method: Method::RungeKutta4, step_s: FINE_S, ..default }
    };
    let tight = Integration { rtol: 1e-11, atol: 1e-13, ..default };
    let loose = Integration { rtol: 1e-9, atol: 1e-11, ..default };
    let mut known = None;
    let mut felt = || -> Sensitivity {
        let found = known.get_or_insert_with(|| sensitivity(patch, &reference, names.len()));
        Sensitivity { nets: found.nets.clone(), faults: found.faults.clone() }
    };
    let (mut sensitive, mut flagged) = (false, false);
    for (what, integration, relative) in [
        ("default", default, TOLERANCE),
        ("tighter", tight, TOLERANCE),
        ("looser", loose, COARSE),
        ("second method", second, COARSE),
    ] {
        let (run, said) = remarked(&ordered, integration, until_s);
        match against(what, &run, &reference, relative, &names, &mut felt) {
            None => {}
            Some(Verdict::Sensitive) => sensitive = true,
            Some(Verdict::Wrong(_)) if said => flagged = true,
            Some(Verdict::Wrong(_))
                if what == "second method"
                    && errs_alone(&ordered, integration, until_s, &run, &reference) => {}
            // Tiny steps can be refused where the tolerances alone pass.
            Some(Verdict::Wrong(text))
                if what == "default"
                    && reference.is_err()
                    && passes(&ordered, [tight, loose, implicit()], until_s, &run) =>
            {
                return Verdict::Refused(text);
            }
            Some(Verdict::Wrong(_))
                if matches!(what, "default" | "looser")
                    && loses_digits(&ordered, tight, until_s, &run, &reference) =>
            {
                sensitive = true;
            }
            Some(verdict) => return verdict,
        }
    }
    if flagged {
        Verdict::Flagged
    } else if sensitive {
        Verdict::Sensitive
    } else if reference.is_err() {
        Verdict::SameFault
    } else {
        Verdict::Agreed
    }
}
