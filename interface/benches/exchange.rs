//! Round trip of one frame pair between two processes, three ways in one run.
//!
//! - `link`: through the real link, protocol checks and waiting rule included;
//! - `publish-subscribe`: a bare iceoryx2 ping-pong of the same payloads;
//! - `mapped-memory`: two sequence numbers and two copies in a mapped file, the
//!   least that any transport can take.
//!
//! The goal is `link` ≤ 1.2 × `publish-subscribe`. The second process is this
//! binary again, told its part by an environment variable. All three wait alike:
//! 2 µs of spinning, then `sched_yield`.
#![allow(clippy::unwrap_used, missing_docs)]

use criterion::{Criterion, criterion_group};
use iceoryx2::{
    port::{publisher::Publisher, subscriber::Subscriber},
    prelude::*,
};
use interface::{
    Side,
    control::{Clock, PatchBundle, Reply, Request, RunSpec},
    frame::{ModeCommand, RunState, Samples, Updates},
    link::{AnalogPort, DigitalPort, FramePort, Patience, shm::ShmAnalog, shm::ShmDigital},
    profile::Profile,
    session::Session,
};
use rustix::{
    mm::{MapFlags, ProtFlags, mmap},
    process::{Signal, set_parent_process_death_signal},
};
use std::{
    hint::black_box,
    process::{Child, Command},
    sync::atomic::{AtomicU64, Ordering},
    time::{Duration, Instant},
};

const ROLE: &str = "EXCHANGE_ROLE";
const PLACE: &str = "EXCHANGE_PLACE";

/// The second process; killed and reaped when dropped.
struct Second(Child);

impl Second {
    fn start(role: &str, place: &str) -> Second {
        let mut command = Command::new(std::env::current_exe().unwrap());
        Second(command.env(ROLE, role).env(PLACE, place).spawn().unwrap())
    }
}

impl Drop for Second {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The waiting rule of the link, without its blocking part.
fn poll<T>(mut attempt: impl FnMut() -> Option<T>) -> T {
    if let Some(found) = attempt() {
        return found;
    }
    let start = Instant::now();
    loop {
        if start.elapsed() < Duration::from_micros(2) {
            std::hint::spin_loop();
        } else {
            rustix::thread::sched_yield();
        }
        if let Some(found) = attempt() {
            return found;
        }
    }
}

// ---- the link ---------------------------------------------------------------

fn link_second(name: &str) {
    let session = Session::join(Side::Analog, name).unwrap();
    let mut port = ShmAnalog::open(&session, None, &Patience::default()).unwrap();
    loop {
        let request = port.await_request().unwrap();
        let reply = match &request {
            Request::Load { bundle, .. } => {
                Reply::Loaded { patch_hash: bundle.hash(), channels: vec![] }
            }
            _ => Reply::Done,
        };
        port.reply(&reply).unwrap();
        match request {
            Request::Operate(_) => {}
            Request::Bye => return,
            _ => continue,
        }
        for n in 0.. {
            port.send_samples(&Samples::new(n, interface::Tick(n as i64), RunState::Operate))
                .unwrap();
            let updates = port.await_updates(n).unwrap();
            if updates.mode_command() == ModeCommand::End {
                let last = Samples::new(n + 1, interface::Tick(0), RunState::Ended);
                port.send_samples(&last).unwrap();
                break;
            }
        }
    }
}

fn link(c: &mut Criterion) {
    let session = Session::create(Side::Digital, None).unwrap();
    let second = Second::start("link", session.name());
    let mut port = ShmDigital::open(&session, Some(second.0.id()), &Patience::default()).unwrap();
    let load =
        Request::Load { bundle: PatchBundle::default(), params: vec![], profile: Profile::ideal() };
    port.request(&load).unwrap();
    let spec = RunSpec {
        frame: interface::Tick(1_000_000),
        latency: interface::Tick::ZERO,
        skew: interface::Tick::ZERO,
        stop: interface::Tick::SECOND,
        from_ic: true,
        clock: Clock::LockStep,
    };
    c.bench_function("exchange/link", |b| {
        b.iter_custom(|rounds| {
            port.request(&Request::Operate(spec.clone())).unwrap();
            let mut got = port.await_samples(0).unwrap();
            let start = Instant::now();
            for n in 0..rounds {
                let mut updates = Updates::new(n, got.tick);
                updates.set_dac(0, got.adc[0]);
                port.send_updates(&updates).unwrap();
                got = port.await_samples(n + 1).unwrap();
            }
            let taken = start.elapsed();
            let mut end = Updates::new(rounds, got.tick);
            end.mode = ModeCommand::End as u32;
            port.send_updates(&end).unwrap();
            port.await_samples(rounds + 1).unwrap();
            taken
        });
    });
    port.request(&Request::Bye).unwrap();
}

// ---- bare publish-subscribe -------------------------------------------------

#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
struct Ping(Updates);
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
struct Pong(Samples);
// SAFETY: plain `repr(C)` data without pointers, as in the link.
unsafe impl ZeroCopySend for Ping {
    unsafe fn type_name() -> &'static str {
        "bare_ping"
    }
}
// SAFETY: as above.
unsafe impl ZeroCopySend for Pong {
    unsafe fn type_name() -> &'static str {
        "bare_pong"
    }
}

type Out<T> = Publisher<ipc::Service, T, ()>;
type In<T> = Subscriber<ipc::Service, T, ()>;

fn bare_node(place: &str) -> iceoryx2::node::Node<ipc::Service> {
    set_log_level(LogLevel::Error);
    let mut config = Config::default();
    let prefix = place.rsplit('/').next().unwrap();
    config.global.prefix = FileName::new(format!("bare{prefix}_").as_bytes()).unwrap();
    config.global.set_root_path(&Path::new(place.as_bytes()).unwrap());
    NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .unwrap()
}

fn bare_ports<O: ZeroCopySend + std::fmt::Debug, I: ZeroCopySend + std::fmt::Debug>(
    node: &iceoryx2::node::Node<ipc::Service>,
    out: &str,
    input: &str,
) -> (Out<O>, In<I>) {
    macro_rules! service {
        ($name:expr, $payload:ty) => {
            node.service_builder(&ServiceName::new($name).unwrap())
                .publish_subscribe::<$payload>()
                .enable_safe_overflow(true)
                .history_size(0)
                .subscriber_max_buffer_size(16)
                .open_or_create()
                .unwrap()
        };
    }
    (
        service!(out, O).publisher_builder().create().unwrap(),
        service!(input, I).subscriber_builder().create().unwrap(),
    )
}

fn publish<T: ZeroCopySend + std::fmt::Debug + 'static>(out: &Out<T>, value: T) {
    let sample = out.loan_uninit().unwrap().write_payload(value);
    sample.send().unwrap();
}

fn bare_second(place: &str) {
    let node = bare_node(place);
    let (out, input) = bare_ports::<Pong, Ping>(&node, "pong", "ping");
    loop {
        let ping = poll(|| input.receive().unwrap().map(|sample| sample.0));
        let pong = Samples::new(ping.frame, ping.effective, RunState::Operate);
        publish(&out, Pong(pong));
    }
}

fn bare(c: &mut Criterion) {
    let dir = tempfile::tempdir().unwrap();
    let place = dir.path().to_str().unwrap();
    let node = bare_node(place);
    let (out, input) = bare_ports::<Ping, Pong>(&node, "ping", "pong");
    let second = Second::start("bare", place);
    // Pings sent before the second process subscribes go nowhere.
    let arrived = Instant::now();
    loop {
        publish(&out, Ping(Updates::new(0, interface::Tick(0))));
        std::thread::sleep(Duration::from_millis(1));
        if input.receive().unwrap().is_some() {
            break;
        }
        assert!(arrived.elapsed() < Duration::from_secs(10));
    }
    std::thread::sleep(Duration::from_millis(20));
    while input.receive().unwrap().is_some() {}
    c.bench_function("exchange/publish-subscribe", |b| {
        b.iter_custom(|rounds| {
            let start = Instant::now();
            for n in 1..=rounds {
                publish(&out, Ping(Updates::new(n, interface::Tick(0))));
                let pong = poll(|| input.receive().unwrap().map(|sample| sample.0));
                assert_eq!(black_box(pong).frame, n);
            }
            start.elapsed()
        });
    });
    drop(second);
    drop((out, input, node));
    let prefix = format!("bare{}_", place.rsplit('/').next().unwrap());
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with(&prefix) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

// ---- mapped memory ----------------------------------------------------------

#[repr(C, align(64))]
struct Mapped {
    ping_number: AtomicU64,
    ping: std::cell::UnsafeCell<Updates>,
    pong_number: AtomicU64,
    pong: std::cell::UnsafeCell<Samples>,
}

fn map(path: &str) -> &'static Mapped {
    let file = std::fs::OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)
        .unwrap();
    let length = size_of::<Mapped>();
    file.set_len(length as u64).unwrap();
    // SAFETY: a fresh shared mapping of a file of this length, zero-filled, which
    // is a valid `Mapped`; it is never unmapped.
    unsafe {
        let address = mmap(
            std::ptr::null_mut(),
            length,
            ProtFlags::READ | ProtFlags::WRITE,
            MapFlags::SHARED,
            &file,
            0,
        )
        .unwrap();
        &*address.cast::<Mapped>()
    }
}

fn mapped_second(path: &str) {
    let memory = map(path);
    for n in 1.. {
        poll(|| (memory.ping_number.load(Ordering::Acquire) == n).then_some(()));
        // SAFETY: the other side writes `ping` only after it has seen `pong_number` n,
        // and reads `pong` only then.
        unsafe {
            let ping = *memory.ping.get();
            *memory.pong.get() = Samples::new(n, ping.effective, RunState::Operate);
        }
        memory.pong_number.store(n, Ordering::Release);
    }
}

fn mapped(c: &mut Criterion) {
    let file = tempfile::NamedTempFile::new_in("/dev/shm").unwrap();
    let path = file.path().to_str().unwrap();
    let memory = map(path);
    let _second = Second::start("mapped", path);
    let mut n = 0;
    let mut round = || {
        n += 1;
        // SAFETY: as in `mapped_second`, the other way round.
        unsafe { *memory.ping.get() = Updates::new(n, interface::Tick(0)) };
        memory.ping_number.store(n, Ordering::Release);
        poll(|| (memory.pong_number.load(Ordering::Acquire) == n).then_some(()));
        // SAFETY: as above.
        unsafe { *memory.pong.get() }
    };
    c.bench_function("exchange/mapped-memory", |b| b.iter(|| black_box(round())));
}

criterion_group! {
    name = exchange;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(4))
        .sample_size(40);
    targets = link, bare, mapped
}

fn main() {
    let Some(role) = std::env::var_os(ROLE) else {
        exchange();
        Criterion::default().configure_from_args().final_summary();
        return;
    };
    // A second process never outlives the first, however that ends.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
    let place = std::env::var(PLACE).unwrap();
    match role.to_str() {
        Some("link") => link_second(&place),
        Some("bare") => bare_second(&place),
        _ => mapped_second(&place),
    }
}
