//! One battery, run over the in-memory link and over shared memory.

use interface::{
    Side, Tick,
    control::{Clock, PatchBundle, Reply, Request, RunSpec},
    frame::{
        ADC_CHANNELS, DAC_CHANNELS, DCU_CHANNELS, Edge, ModeCommand, RunState, Samples, Updates,
    },
    link::{
        AnalogPort, DigitalFrames, DigitalPort, LinkFault, Patience, memory, shm::ShmAnalog,
        shm::ShmDigital,
    },
    profile::Profile,
    session::Session,
};
use std::time::{Duration, Instant};

pub fn spec(clock: Clock) -> RunSpec {
    RunSpec {
        frame: Tick(1_000_000),
        latency: Tick::ZERO,
        skew: Tick::ZERO,
        stop: Tick::SECOND,
        from_ic: true,
        clock,
    }
}

pub fn patience() -> Patience {
    Patience { silence: Duration::from_secs(5), ..Patience::default() }
}

/// Runs one side in this thread and the other in a second one, over both links.
fn over_both_links(
    analog: impl Fn(&mut dyn AnalogPort) + Send + Sync,
    digital: impl Fn(&mut dyn DigitalFrames) + Send + Sync,
) {
    let (mut a, mut d) = memory::pair_with(&patience());
    std::thread::scope(|scope| {
        scope.spawn(|| {
            analog(&mut a);
            drop(a);
        });
        digital(&mut d);
        drop(d);
    });

    let base = tempfile::tempdir().unwrap();
    let session = Session::create_in(base.path(), Side::Digital, None).unwrap();
    let prefix = session.prefix().to_owned();
    let name = session.name().to_owned();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let session = Session::join_in(base.path(), Side::Analog, &name).unwrap();
            let mut port = ShmAnalog::open(&session, None, &patience()).unwrap();
            analog(&mut port);
        });
        let mut port = ShmDigital::open(&session, None, &patience()).unwrap();
        digital(&mut port);
        drop((port, session));
    });
    assert_nothing_left(base.path(), &prefix);
}

/// Neither the base nor shared memory holds anything of the session.
pub fn assert_nothing_left(base: &std::path::Path, prefix: &str) {
    let shared: Vec<_> = std::fs::read_dir("/dev/shm")
        .unwrap()
        .flatten()
        .filter(|e| e.file_name().to_string_lossy().starts_with(prefix))
        .collect();
    assert!(shared.is_empty(), "left in shared memory: {shared:?}");
    // The base itself goes with its last session.
    assert!(!base.exists(), "{} is left", base.display());
}

/// Samples whose every field depends on `n`, so that no stale byte passes for a new one; the
/// values are any bits, NaN payloads and all.
pub fn samples(n: u64, state: RunState) -> Samples {
    let mut samples = Samples::new(n, Tick(n as i64 * 1_000_000), state);
    for (i, value) in samples.adc.iter_mut().enumerate() {
        let mixed = (n * 64 + i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        *value = f64::from_bits(mixed ^ (mixed >> 29));
    }
    samples.adc_saturated = n.rotate_left(7);
    samples.sense = !n;
    samples.overloads = n as u32;
    samples.edge_count = 1;
    samples.edges[0] = Edge { tick: Tick(n as i64), line: 3, rising: 1 };
    samples
}

/// The updates that answer `samples`.
pub fn updates(samples: &Samples) -> Updates {
    let mut updates = Updates::new(samples.frame, samples.tick);
    for i in 0..64 {
        updates.set_dac(i, -samples.adc[i]);
        updates.set_dcu(64 + i, samples.adc[63 - i]);
    }
    updates.set_control(63, samples.frame % 2 == 1);
    updates
}

/// Equal to the last bit.
pub fn assert_samples(found: &Samples, sent: &Samples) {
    assert_eq!(found.adc.map(f64::to_bits), sent.adc.map(f64::to_bits));
    let rest = |of: &Samples| Samples { adc: [0.0; ADC_CHANNELS], ..*of };
    assert_eq!(rest(found), rest(sent));
}

fn assert_updates(found: &Updates, sent: &Updates) {
    assert_eq!(found.dac.map(f64::to_bits), sent.dac.map(f64::to_bits));
    assert_eq!(found.dcu.map(f64::to_bits), sent.dcu.map(f64::to_bits));
    let rest = |of: &Updates| Updates { dac: [0.0; DAC_CHANNELS], dcu: [0.0; DCU_CHANNELS], ..*of };
    assert_eq!(rest(found), rest(sent));
}

pub fn load(port: &mut (impl DigitalFrames + ?Sized)) -> Result<(), LinkFault> {
    let bundle =
        PatchBundle { root: "a.toml".into(), files: vec![("a.toml".into(), "[blocks]".into())] };
    let hash = bundle.hash();
    let params = vec![("w".into(), f64::NAN)];
    let reply = port.request(&Request::Load { bundle, params, profile: Profile::default() })?;
    assert!(matches!(reply, Reply::Loaded { patch_hash, .. } if patch_hash == hash));
    Ok(())
}

/// Loads a patch and starts a run.
fn operate(port: &mut dyn DigitalFrames, clock: Clock) {
    load(port).unwrap();
    port.request(&Request::Operate(spec(clock))).unwrap();
}

/// Answers requests until one starts a run (true) or ends the session (false).
pub fn serve(port: &mut (impl AnalogPort + ?Sized)) -> Result<bool, LinkFault> {
    loop {
        let request = port.await_request()?;
        let reply = match &request {
            Request::Hello { .. } => interface::protocol::hello_reply(),
            Request::Load { bundle, .. } => {
                Reply::Loaded { patch_hash: bundle.hash(), channels: vec![] }
            }
            Request::Read(nets) if nets == &["busy"] => {
                // Computes for 1.5 s before it answers.
                let start = Instant::now();
                while start.elapsed() < Duration::from_millis(1500) {
                    std::hint::spin_loop();
                }
                Reply::Values(vec![0.0])
            }
            Request::Read(nets) => Reply::Values(vec![f64::INFINITY; nets.len()]),
            Request::StaticCheck => Reply::StaticCheck(vec![]),
            Request::Diagnose => {
                Reply::Diagnosis { fault: Some("x".repeat(1_000_000)), overloads: vec![] }
            }
            _ => Reply::Done,
        };
        port.reply(&reply)?;
        match request {
            Request::Operate(_) => return Ok(true),
            Request::Bye => return Ok(false),
            _ => {}
        }
    }
}

#[test]
fn frames_arrive_unchanged_and_in_order() {
    const FRAMES: u64 = 500;
    over_both_links(
        |port| {
            // Three runs in one session, as in rep-op.
            while serve(port).unwrap() {
                for n in 0..FRAMES {
                    let sent = samples(n, RunState::Operate);
                    port.send_samples(&sent).unwrap();
                    assert_updates(&port.await_updates(n).unwrap(), &updates(&sent));
                }
                port.send_samples(&samples(FRAMES, RunState::Ended)).unwrap();
            }
        },
        |port| {
            load(port).unwrap();
            for _ in 0..3 {
                port.request(&Request::Operate(spec(Clock::LockStep))).unwrap();
                for n in 0..FRAMES {
                    let got = port.await_samples(n).unwrap();
                    assert_samples(&got, &samples(n, RunState::Operate));
                    port.send_updates(&updates(&got)).unwrap();
                }
                let last = port.await_samples(FRAMES).unwrap();
                assert_eq!(last.run_state(), RunState::Ended);
            }
            assert_eq!(port.request(&Request::Bye).unwrap(), Reply::Done);
        },
    );
}

#[test]
fn long_messages_pass_both_ways() {
    // 3 MB: a dozen parts; the reply of 1 MB: four.
    let long = PatchBundle { root: "r".into(), files: vec![("r".into(), "y".repeat(3_000_000))] };
    over_both_links(
        |port| assert!(!serve(port).unwrap()),
        |port| {
            for _ in 0..2 {
                let request = Request::Load {
                    bundle: long.clone(),
                    params: vec![],
                    profile: Profile::default(),
                };
                let reply = port.request(&request).unwrap();
                assert!(
                    matches!(reply, Reply::Loaded { patch_hash, .. } if patch_hash == long.hash())
                );
                let reply = port.request(&Request::Diagnose).unwrap();
                assert!(
                    matches!(reply, Reply::Diagnosis { fault: Some(f), .. } if f.len() == 1_000_000)
                );
            }
            port.request(&Request::Bye).unwrap();
        },
    );
}

#[test]
fn a_dropped_end_is_a_dead_partner() {
    over_both_links(
        |port| {
            assert!(serve(port).unwrap());
            for n in 0..3 {
                port.send_samples(&samples(n, RunState::Operate)).unwrap();
                port.await_updates(n).unwrap();
            }
        },
        |port| {
            operate(port, Clock::LockStep);
            for n in 0..3 {
                let got = port.await_samples(n).unwrap();
                port.send_updates(&updates(&got)).unwrap();
            }
            let start = Instant::now();
            let fault = port.await_samples(3).unwrap_err();
            assert!(
                matches!(fault, LinkFault::PartnerDied { side: "analog-proc", frame: 3, .. }),
                "{fault}"
            );
            assert!(start.elapsed() < Duration::from_secs(1));
        },
    );
}

#[test]
fn a_wrong_order_is_refused_by_either_end() {
    over_both_links(
        |port| {
            assert!(serve(port).unwrap());
            port.send_samples(&samples(0, RunState::Operate)).unwrap();
            // Updates of this frame are due first.
            let fault = port.send_samples(&samples(1, RunState::Operate)).unwrap_err();
            assert!(matches!(fault, LinkFault::Protocol { frame: 1, .. }));
            port.await_updates(0).unwrap();
            port.send_samples(&samples(1, RunState::Operate)).unwrap();
            assert!(matches!(port.await_updates(1), Err(LinkFault::PartnerDied { .. })));
        },
        |port| {
            operate(port, Clock::LockStep);
            let got = port.await_samples(0).unwrap();
            assert!(matches!(port.request(&Request::StaticCheck), Err(LinkFault::Protocol { .. })));
            let mut other = updates(&got);
            other.frame = 7;
            assert!(matches!(port.send_updates(&other), Err(LinkFault::Protocol { frame: 7, .. })));
            port.send_updates(&updates(&got)).unwrap();
            assert!(matches!(port.await_samples(2), Err(LinkFault::Protocol { frame: 2, .. })));
        },
    );
}

#[test]
fn a_session_on_the_wall_clock_skips_and_takes_late_updates() {
    over_both_links(
        |port| {
            assert!(serve(port).unwrap());
            for n in 0..4 {
                port.send_samples(&samples(n, RunState::Operate)).unwrap();
            }
            // The partner answers 0, then 3 only: both are taken, 0 as a late one.
            let mut taken = Vec::new();
            let start = Instant::now();
            while taken.len() < 2 && start.elapsed() < Duration::from_secs(5) {
                if let Some(updates) = port.poll_updates(3).unwrap() {
                    taken.push(updates.frame);
                }
            }
            assert_eq!(taken, [0, 3]);
            port.send_samples(&samples(9, RunState::Ended)).unwrap();
            assert!(!serve(port).unwrap());
        },
        |port| {
            operate(port, Clock::Wall { processor: None });
            let first = port.await_samples(0).unwrap();
            port.send_updates(&updates(&first)).unwrap();
            let third = port.await_samples(3).unwrap();
            assert_eq!(third.frame, 3);
            let mut answer = updates(&third);
            answer.mode = ModeCommand::End as u32;
            port.send_updates(&answer).unwrap();
            assert_eq!(port.await_samples(4).unwrap().run_state(), RunState::Ended);
            port.request(&Request::Bye).unwrap();
        },
    );
}

#[test]
fn a_silent_partner_meets_a_deadline() {
    let base = tempfile::tempdir().unwrap();
    let digital = Session::create_in(base.path(), Side::Digital, None).unwrap();
    let (quiet, quiet_end) = std::sync::mpsc::channel::<()>();
    let name = digital.name().to_owned();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let session = Session::join_in(base.path(), Side::Analog, &name).unwrap();
            let _port = ShmAnalog::open(&session, None, &patience()).unwrap();
            // Alive, silent and idle until the other side has seen it.
            let quiet_end = quiet_end;
            let _ = quiet_end.recv();
        });
        let impatient = Patience {
            silence: Duration::from_millis(300),
            // Both sides are this one process here, whose other tests may compute.
            busy_limit: Duration::from_millis(300),
            ..Patience::default()
        };
        let mut port = ShmDigital::open(&digital, None, &impatient).unwrap();
        let fault = port.request(&Request::StaticCheck).unwrap_err();
        assert!(
            matches!(fault, LinkFault::Deadline { side: "analog-proc", waited_s, .. } if waited_s >= 0.3),
            "{fault}"
        );
        drop(quiet);
    });
}
