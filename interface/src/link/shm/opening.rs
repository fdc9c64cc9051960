//! Opening an end under supervision.
//!
//! The transport has waits of its own while it makes services, ports and
//! connections, and some have no limit: a partner killed between making and filling
//! a shared-memory file holds them up for ever. So an end opens in a thread of its
//! own, which goes as far as the first exchange of messages; after that everything
//! that both sides share exists. The caller watches partner, interrupt and deadline,
//! and gives up when the thread does not notice them by itself. A thread that hangs
//! stays behind and ends with the process.

use super::{
    peer::{Peer, Progress},
    service::fault,
};
use crate::link::{LinkFault, waiting::Patience};
use std::{
    sync::{
        atomic::Ordering,
        mpsc::{RecvTimeoutError, sync_channel},
    },
    time::{Duration, Instant},
};

/// Time between two looks at partner, interrupt and deadline.
const LOOK: Duration = Duration::from_millis(5);
/// How long the thread may take to notice by itself what its watcher has seen, which
/// makes the better report. Its own waits look every 20 ms; but it may be slow, beside busy
/// programs or a busy disk, and what it makes after the session was left would stay behind.
const GRACE: Duration = Duration::from_millis(1500);

/// An end on its way from the thread that opened it to the caller.
struct Moved<E>(E);

// SAFETY: the transport's parts are not `Send` because they share reference counts that
// are not atomic. Node and ports move all at once and the opening thread keeps none of
// them, nor anything else that shares their counts (what it borrowed to make them is gone
// before it sends), so no count is ever touched by two threads; the channel orders the
// one thread's accesses before the other's. The transport keeps no state by thread.
unsafe impl<E> Send for Moved<E> {}

/// Runs `open` in a thread and gives what it makes.
pub(super) fn supervised<E: 'static>(
    peer: Peer,
    patience: &Patience,
    open: impl FnOnce(Peer, &Patience) -> Result<E, LinkFault> + Send + 'static,
) -> Result<E, LinkFault> {
    let progress = peer.progress.clone();
    let session = peer.session.clone();
    let (done, opened) = sync_channel(1);
    let own = patience.clone();
    let started = Instant::now();
    std::thread::Builder::new()
        .name("opening".into())
        .spawn(move || {
            // The caller may have given up and gone.
            let _ = done.send(Moved(open(peer, &own)));
        })
        .map_err(fault("starting a thread to open the link"))?;
    let mut overdue: Option<(Instant, LinkFault)> = None;
    loop {
        match opened.recv_timeout(LOOK) {
            Ok(Moved(end)) => return end,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(fault("opening the link")("the transport panicked"));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        match &overdue {
            None => {
                let fault = due(&progress, patience, started, session.side().partner().name());
                overdue = fault.map(|fault| (Instant::now(), fault));
            }
            Some((since, _)) if since.elapsed() < GRACE => {}
            Some(_) => {
                // The hanging thread holds the session too: it would never be dropped.
                session.leave();
                return Err(overdue.map_or_else(|| fault("opening the link")("it hangs"), |o| o.1));
            }
        }
    }
}

/// Why the opening ought to have failed by now.
fn due(
    progress: &Progress,
    patience: &Patience,
    started: Instant,
    side: &'static str,
) -> Option<LinkFault> {
    if let Err(interrupted) = patience.check_interrupt(0) {
        return Some(interrupted);
    }
    if let Some(partner) = progress.partner.get().filter(|partner| partner.ended()) {
        return Some(LinkFault::PartnerDied { side, frame: 0, detail: partner.epitaph() });
    }
    // Later waits are our own and keep their own limits.
    let limit = patience.arrival.unwrap_or(patience.silence);
    let late = !progress.built.load(Ordering::Acquire) && started.elapsed() > limit;
    late.then(|| {
        fault("joining the shared memory")(format!(
            "the transport did not come back within {:.0} s",
            limit.as_secs_f64()
        ))
    })
}
