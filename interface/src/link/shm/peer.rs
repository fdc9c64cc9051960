//! The process at the other side, as far as it is known.

use super::{
    counter,
    service::{config, fault},
};
use crate::{
    Side,
    link::{
        LinkFault,
        bell::Bell,
        end::died,
        waiting::{Limit, Patience, Watch, Watched, wait},
    },
    session::{Partner, SHARED_MEMORY, Session},
};
use iceoryx2::{
    node::Node,
    prelude::{LogLevel, NodeBuilder, SignalHandlingMode, ipc, set_log_level},
};
use std::{
    path::Path,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

/// What opening thread and watcher share.
#[derive(Clone, Debug, Default)]
pub(super) struct Progress {
    /// The partner as soon as it is known.
    pub(super) partner: Arc<OnceLock<Partner>>,
    /// Set once the transport has made everything that this side needs.
    pub(super) built: Arc<AtomicBool>,
}

/// The session, and the process at its other side as far as it is known.
#[derive(Debug)]
pub struct Peer {
    pub(super) side: Side,
    pub(super) progress: Progress,
    pub(super) bell: Bell,
    pub(super) session: Session,
}

impl Peer {
    pub(super) fn new(session: &Session, child: Option<u32>) -> Result<Peer, LinkFault> {
        let partner = match child {
            Some(pid) => Some(session.child(pid).map_err(fault("watching the started partner"))?),
            None => session.partner().map_err(fault("looking for the partner"))?,
        };
        if partner.is_none() && session.joined() {
            // It was there when this side joined: it is not late, it is dead.
            return Err(LinkFault::PartnerDied {
                side: session.side().partner().name(),
                frame: 0,
                detail: "it ended before the link was open".to_owned(),
            });
        }
        let progress = Progress::default();
        if let Some(partner) = partner {
            let _ = progress.partner.set(partner);
        }
        let bell = Bell::mapped(&session.root().join("bell"), session.side())
            .map_err(fault("mapping the session's bell"))?;
        Ok(Peer { side: session.side().partner(), progress, bell, session: session.clone() })
    }

    /// Makes a node and ports on it, again and again while the partner is making
    /// the same services or has not come yet.
    pub(super) fn build<P>(
        &self,
        patience: &Patience,
        ports: impl Fn(&Node<ipc::Service>) -> Result<P, LinkFault>,
    ) -> Result<(Node<ipc::Service>, P), LinkFault> {
        set_log_level(LogLevel::Fatal);
        let config = config(&self.session)?;
        counter::provide(Path::new(SHARED_MEMORY), self.session.prefix())?;
        let started = Instant::now();
        let limit = patience.arrival.unwrap_or(patience.silence);
        loop {
            patience.check_interrupt(0)?;
            let made = NodeBuilder::new()
                .config(&config)
                .signal_handling_mode(SignalHandlingMode::Disabled)
                .create::<ipc::Service>()
                .map_err(fault("joining the shared memory"))
                .and_then(|node| ports(&node).map(|ports| (node, ports)));
            match made {
                Ok(made) => {
                    self.progress.built.store(true, Ordering::Release);
                    return Ok(made);
                }
                Err(_) if self.gone() => return Err(died(self, 0)),
                Err(fault) if started.elapsed() > limit => return Err(fault),
                Err(_) => std::thread::sleep(Duration::from_millis(1)),
            }
        }
    }

    /// Waits until the partner has taken its place in the session.
    pub(super) fn meet(&mut self, patience: &Patience) -> Result<(), LinkFault> {
        let limit = patience.arrival.map_or(Limit::Unlimited, Limit::After);
        let joined = wait(patience, self, limit, 0, |peer| {
            let partner = peer.session.partner();
            partner.map_err(fault("looking for the partner"))
        })?;
        // A child that was started and the partner that has joined are one process.
        let _ = self.progress.partner.set(joined);
        Ok(())
    }

    fn process(&self) -> Option<&Partner> {
        self.progress.partner.get()
    }
}

impl Watched for Peer {
    type Partner = Peer;

    fn partner(&self) -> &Peer {
        self
    }
}

impl Watch for Peer {
    fn side(&self) -> Side {
        self.side
    }

    fn bell(&self) -> &Bell {
        &self.bell
    }

    fn gone(&self) -> bool {
        self.process().is_some_and(Partner::ended)
    }

    fn left(&self) -> bool {
        self.bell.partner_closed() || self.process().is_some_and(Partner::left)
    }

    fn epitaph(&self) -> String {
        self.process().map_or_else(|| "it never came".to_owned(), Partner::epitaph)
    }

    fn stopped(&self) -> bool {
        self.process().is_some_and(Partner::stopped)
    }

    fn cpu_time(&self) -> Option<Duration> {
        self.process().and_then(Partner::cpu_time)
    }
}

pub(super) fn expect_side(session: &Session, side: Side) -> Result<(), LinkFault> {
    if session.side() == side {
        Ok(())
    } else {
        Err(fault("opening the link")(format!(
            "this process joined the session as {}, not as {}",
            session.side().name(),
            side.name()
        )))
    }
}
