//! What can be out of order between the two sides, and the names of messages.

use crate::{
    control::{Reply, Request},
    link::LinkFault,
};

/// What was out of order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProtocolError {
    /// The two processes speak different protocols.
    #[error("protocol version {theirs} met version {ours}; run both processes from the same build")]
    Version {
        /// This side's version.
        ours: u32,
        /// The partner's version.
        theirs: u32,
    },
    /// The two processes lay their frames out differently.
    #[error(
        "frame layout {theirs:016x} met layout {ours:016x}; run both processes from the same build"
    )]
    Layout {
        /// This side's layout hash.
        ours: u64,
        /// The partner's layout hash.
        theirs: u64,
    },
    /// The analog side loaded another patch than the one that was sent.
    #[error("the patch arrived altered: hash {sent} was sent, {loaded} was loaded")]
    PatchHash {
        /// Hash of the bundle in the request.
        sent: String,
        /// Hash in the reply.
        loaded: String,
    },
    /// A message came at a moment when it has no place.
    #[error("{message} has no place while {phase}")]
    OutOfOrder {
        /// What came.
        message: &'static str,
        /// What the session was doing.
        phase: &'static str,
    },
    /// A frame came with another number than the next one.
    #[error("{message} {found} came where {expected} was due")]
    FrameNumber {
        /// `samples` or `updates`.
        message: &'static str,
        /// Number due.
        expected: u64,
        /// Number found.
        found: u64,
    },
    /// The reply does not belong to the request.
    #[error("the request {request} was answered by {reply}")]
    ReplyKind {
        /// The request.
        request: &'static str,
        /// The reply.
        reply: &'static str,
    },
}

impl ProtocolError {
    /// As a link fault at the given frame.
    pub fn at(self, frame: u64) -> LinkFault {
        LinkFault::Protocol { frame, detail: self.to_string() }
    }
}

pub(super) fn request_name(request: &Request) -> &'static str {
    match request {
        Request::Hello { .. } => "request Hello",
        Request::Load { .. } => "request Load",
        Request::SetParams(_) => "request SetParams",
        Request::SetIcs(_) => "request SetIcs",
        Request::Preset(_) => "request Preset",
        Request::Read(_) => "request Read",
        Request::StaticCheck => "request StaticCheck",
        Request::Sweep(_) => "request Sweep",
        Request::Linearise { .. } => "request Linearise",
        Request::Operate(_) => "request Operate",
        Request::Diagnose => "request Diagnose",
        Request::Bye => "request Bye",
    }
}

pub(super) fn reply_name(reply: &Reply) -> &'static str {
    match reply {
        Reply::Hello { .. } => "reply Hello",
        Reply::Loaded { .. } => "reply Loaded",
        Reply::Done => "reply Done",
        Reply::Values(_) => "reply Values",
        Reply::StaticCheck(_) => "reply StaticCheck",
        Reply::Swept(_) => "reply Swept",
        Reply::Linear(_) => "reply Linear",
        Reply::Diagnosis { .. } => "reply Diagnosis",
        Reply::Refused(_) => "reply Refused",
    }
}
