//! What can be out of order between the two sides, and the names of messages.

use crate::{
    control::{Reply, Request},
    link::LinkFault,
};

/// What was out of order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProtocolError {
    #[error("protocol version {theirs} met version {ours}; run both processes from the same build")]
    Version { ours: u32, theirs: u32 },
    #[error(
        "frame layout {theirs:016x} met layout {ours:016x}; run both processes from the same build"
    )]
    Layout { ours: u64, theirs: u64 },
    #[error("the patch arrived altered: hash {sent} was sent, {loaded} was loaded")]
    PatchHash { sent: String, loaded: String },
    #[error("{message} has no place while {phase}")]
    OutOfOrder { message: &'static str, phase: &'static str },
    #[error("{message} {found} came where {expected} was due")]
    FrameNumber { message: &'static str, expected: u64, found: u64 },
    #[error("the request {request} was answered by {reply}")]
    ReplyKind { request: &'static str, reply: &'static str },
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
        Request::Operate(_) | Request::OperateKept(..) => "request Operate",
        Request::Checkpoint => "request Checkpoint",
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
        Reply::Checkpoint(_) => "reply Checkpoint",
        Reply::Diagnosis { .. } => "reply Diagnosis",
        Reply::Refused(_) => "reply Refused",
    }
}
