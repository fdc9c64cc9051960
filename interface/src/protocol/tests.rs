use super::*;
use crate::{
    Tick,
    control::{Checkpoints, PatchBundle, RunSpec},
    profile::Profile,
};
use proptest::prelude::*;

fn spec(clock: Clock) -> RunSpec {
    RunSpec {
        frame: Tick(1_000_000),
        latency: Tick::ZERO,
        skew: Tick::ZERO,
        stop: Tick::SECOND,
        from_ic: true,
        clock,
    }
}

fn loaded() -> Protocol {
    let mut protocol = Protocol::new();
    protocol.request(&hello()).unwrap();
    protocol.reply(&hello_reply()).unwrap();
    let bundle = PatchBundle::default();
    let patch_hash = bundle.hash();
    protocol
        .request(&Request::Load { bundle, params: vec![], profile: Profile::default() })
        .unwrap();
    protocol.reply(&Reply::Loaded { patch_hash, channels: vec![] }).unwrap();
    protocol
}

fn operating(clock: Clock) -> Protocol {
    let mut protocol = loaded();
    protocol.request(&Request::Operate(spec(clock))).unwrap();
    protocol.reply(&Reply::Done).unwrap();
    protocol
}

#[test]
fn a_whole_session_in_order() {
    let mut protocol = operating(Clock::LockStep);
    for n in 0..3 {
        protocol.samples(n, RunState::Operate).unwrap();
        protocol.updates(n).unwrap();
    }
    protocol.samples(3, RunState::Hold).unwrap();
    assert_eq!(protocol.mode(), Mode::Hold);
    protocol.updates(3).unwrap();
    protocol.samples(4, RunState::Ended).unwrap();
    assert!(!protocol.operating());
    // Rep-op: the next run starts at frame 0 again.
    protocol.request(&Request::Operate(spec(Clock::LockStep))).unwrap();
    protocol.reply(&Reply::Done).unwrap();
    protocol.samples(0, RunState::Faulted).unwrap();
    protocol.request(&Request::Diagnose).unwrap();
    protocol.reply(&Reply::Diagnosis { fault: None, overloads: vec![] }).unwrap();
    protocol.request(&Request::Bye).unwrap();
    protocol.reply(&Reply::Done).unwrap();
    assert!(protocol.closed());
    assert!(protocol.request(&hello()).is_err());
}

/// That the analog end refuses another build is a test of `link/end.rs`.
#[test]
fn an_analog_side_of_another_build_is_refused() {
    let mut protocol = Protocol::new();
    protocol.request(&hello()).unwrap();
    assert!(matches!(
        protocol.reply(&Reply::Hello { version: 0, layout_hash: layout_hash() }),
        Err(ProtocolError::Version { theirs: 0, .. })
    ));
}

#[test]
fn nothing_precedes_the_greeting() {
    let mut protocol = Protocol::new();
    assert!(matches!(
        protocol.request(&Request::StaticCheck),
        Err(ProtocolError::OutOfOrder { .. })
    ));
    assert!(protocol.samples(0, RunState::Operate).is_err());
    assert!(protocol.updates(0).is_err());
    assert!(protocol.reply(&Reply::Done).is_err());
}

#[test]
fn an_altered_patch_is_noticed() {
    let mut protocol = Protocol::greeted();
    protocol
        .request(&Request::Load {
            bundle: PatchBundle::default(),
            params: vec![],
            profile: Profile::default(),
        })
        .unwrap();
    assert!(matches!(
        protocol.reply(&Reply::Loaded { patch_hash: "0".into(), channels: vec![] }),
        Err(ProtocolError::PatchHash { .. })
    ));
}

#[test]
fn replies_match_their_requests() {
    let mut protocol = loaded();
    protocol.request(&Request::Read(vec!["x".into()])).unwrap();
    assert!(protocol.request(&Request::StaticCheck).is_err());
    assert!(matches!(protocol.clone().reply(&Reply::Done), Err(ProtocolError::ReplyKind { .. })));
    assert!(protocol.clone().reply(&Reply::Values(vec![])).is_err());
    protocol.reply(&Reply::Values(vec![1.0])).unwrap();
    protocol.request(&Request::SetParams(vec![("nil".into(), 0.0)])).unwrap();
    protocol.reply(&Reply::Refused("no such".into())).unwrap();
    protocol.request(&Request::StaticCheck).unwrap();
}

#[test]
fn a_checkpoint_has_its_place_between_updates_and_samples() {
    let mut protocol = loaded();
    let checkpoints = Checkpoints { every: 2, from: None };
    protocol.request(&Request::OperateKept(spec(Clock::LockStep), checkpoints)).unwrap();
    protocol.reply(&Reply::Done).unwrap();
    assert!(protocol.request(&Request::Checkpoint).is_err());
    for n in 0..2 {
        protocol.samples(n, RunState::Operate).unwrap();
        assert!(protocol.request(&Request::Checkpoint).is_err());
        protocol.updates(n).unwrap();
    }
    assert!(protocol.reply(&Reply::Checkpoint(vec![])).is_err());
    protocol.request(&Request::Checkpoint).unwrap();
    assert!(protocol.request(&Request::Checkpoint).is_err());
    assert!(protocol.samples(2, RunState::Operate).is_err());
    assert!(protocol.reply(&Reply::Refused("no".into())).is_err());
    protocol.reply(&Reply::Checkpoint(vec![1])).unwrap();
    protocol.samples(2, RunState::Ended).unwrap();
    assert!(protocol.request(&Request::Checkpoint).is_err());
}

#[test]
fn operate_needs_a_patch() {
    let mut protocol = Protocol::greeted();
    protocol.request(&Request::Operate(spec(Clock::LockStep))).unwrap();
    assert!(protocol.clone().reply(&Reply::Done).is_err());
    protocol.reply(&Reply::Refused("no patch".into())).unwrap();
}

#[test]
fn lock_step_loses_no_frame() {
    let mut protocol = operating(Clock::LockStep);
    assert!(protocol.updates(0).is_err());
    protocol.samples(0, RunState::Operate).unwrap();
    assert!(protocol.clone().samples(1, RunState::Operate).is_err());
    assert!(protocol.clone().request(&Request::Bye).is_err());
    assert_eq!(
        protocol.clone().updates(1),
        Err(ProtocolError::FrameNumber { message: "updates", expected: 0, found: 1 })
    );
    protocol.updates(0).unwrap();
    assert!(protocol.clone().updates(0).is_err());
    assert_eq!(
        protocol.samples(2, RunState::Operate),
        Err(ProtocolError::FrameNumber { message: "samples", expected: 1, found: 2 })
    );
}

#[test]
fn the_wall_clock_may_skip_but_never_goes_back() {
    let mut protocol = operating(Clock::Wall { processor: None });
    protocol.samples(0, RunState::Operate).unwrap();
    protocol.samples(3, RunState::Operate).unwrap();
    protocol.updates(1).unwrap();
    protocol.updates(3).unwrap();
    assert!(protocol.clone().updates(2).is_err());
    assert!(protocol.clone().updates(4).is_err());
    assert!(protocol.samples(2, RunState::Operate).is_err());
}

proptest! {
    /// Whatever a partner sends, each message is either taken or refused, and
    /// in lock-step the numbers taken are consecutive pairs.
    #[test]
    fn any_order_is_judged(messages in proptest::collection::vec((0_u8..6, 0_u64..4), 0..60)) {
        let mut protocol = operating(Clock::LockStep);
        let mut due = None;
        for (kind, number) in messages {
            match kind {
                0 | 1 => if protocol.samples(number, RunState::Operate).is_ok() {
                    prop_assert!(due.is_none_or(|d| d == (number, 's')));
                    due = Some((number, 'u'));
                },
                2 | 3 => if protocol.updates(number).is_ok() {
                    prop_assert_eq!(due, Some((number, 'u')));
                    due = Some((number + 1, 's'));
                },
                4 => prop_assert!(protocol.request(&Request::Bye).is_err()),
                _ => prop_assert!(protocol.reply(&Reply::Done).is_err()),
            }
        }
    }
}
