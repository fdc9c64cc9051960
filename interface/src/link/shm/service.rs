//! The transport's services, and its words for what fails.

use super::wire::{Frame, Shared};
use crate::{link::LinkFault, session::Session};
use iceoryx2::{
    node::Node,
    port::{publisher::Publisher, subscriber::Subscriber},
    prelude::{Config, FileName, SemanticString, ServiceName, ipc},
    service::port_factory::publish_subscribe,
};
use std::{os::unix::ffi::OsStrExt, time::Duration};

/// Frames that a subscriber holds before the oldest is lost. Lock-step needs one;
/// on the wall clock this is the slack of a side that is late.
const FRAME_BUFFER: usize = 16;
/// One partner and a few observers.
const SUBSCRIBERS: usize = 8;
/// Processes that may open a service.
pub(super) const NODES: usize = 16;
/// A service half made by a process that was killed stays so for ever; this long
/// one waits to see whether it is merely slow. Below the second in which an end
/// must notice its partner's death.
pub(super) const CREATION_TIMEOUT: Duration = Duration::from_millis(50);

/// Wraps the transport's own words.
pub(super) fn fault<E: std::fmt::Display>(doing: &'static str) -> impl FnOnce(E) -> LinkFault {
    move |error| LinkFault::Transport { doing, detail: error.to_string() }
}

pub(super) fn config(session: &Session) -> Result<Config, LinkFault> {
    let doing = "naming the shared memory";
    let text = |e: iceoryx2::prelude::SemanticStringError| fault(doing)(format!("{e:?}"));
    let mut config = Config::default();
    config.global.prefix = FileName::new(session.prefix().as_bytes()).map_err(text)?;
    let root = session.root();
    config
        .global
        .set_root_path(&iceoryx2::prelude::Path::new(root.as_os_str().as_bytes()).map_err(text)?);
    config.global.creation_timeout = CREATION_TIMEOUT;
    // A session's leavings are removed as a whole, by the session.
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    Ok(config)
}

pub(super) fn service_name(name: &str) -> Result<ServiceName, LinkFault> {
    ServiceName::new(name).map_err(fault("naming a service"))
}

/// Both ends of the frames of one direction.
type FrameService<F> = publish_subscribe::PortFactory<ipc::Service, Shared<F>, ()>;
pub(super) type FramesOut<F> = Publisher<ipc::Service, Shared<F>, ()>;
pub(super) type FramesIn<F> = Subscriber<ipc::Service, Shared<F>, ()>;

fn frames<F: Frame>(node: &Node<ipc::Service>) -> Result<FrameService<F>, LinkFault> {
    node.service_builder(&service_name(F::SERVICE)?)
        .publish_subscribe::<Shared<F>>()
        .enable_safe_overflow(true)
        .history_size(0)
        .subscriber_max_buffer_size(FRAME_BUFFER)
        .subscriber_max_borrowed_samples(2)
        .max_publishers(1)
        .max_subscribers(SUBSCRIBERS)
        .max_nodes(NODES)
        .open_or_create()
        .map_err(fault("opening a frame service"))
}

pub(super) fn publisher<F: Frame>(node: &Node<ipc::Service>) -> Result<FramesOut<F>, LinkFault> {
    frames(node)?
        .publisher_builder()
        .max_loaned_samples(1)
        .create()
        .map_err(fault("creating a publisher"))
}

pub(super) fn subscriber<F: Frame>(node: &Node<ipc::Service>) -> Result<FramesIn<F>, LinkFault> {
    frames(node)?.subscriber_builder().create().map_err(fault("creating a subscriber"))
}

pub(super) fn publish<F: Frame>(publisher: &FramesOut<F>, frame: F) -> Result<(), LinkFault> {
    let sample = publisher.loan_uninit().map_err(fault("loaning a frame"))?;
    sample.write_payload(Shared(frame)).send().map_err(fault("sending a frame"))?;
    Ok(())
}
