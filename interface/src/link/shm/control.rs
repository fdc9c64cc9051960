//! The control plane over request-response, in parts.
//!
//! A message is bincode, cut into parts of at most [`PART`] bytes so that a
//! patch of any size needs only modest shared memory. Each exchange carries one
//! part and its answer: parts of a request are acknowledged one by one, the last
//! one is answered by the first part of the reply, and the client pulls the
//! rest. A part begins with its kind, its index and the count of all parts.
//!
//! It refuses messages above [`MESSAGE_LIMIT`] and parts out of order.

use super::service::{NODES, fault, service_name};
use crate::{
    control::{Reply, Request},
    link::{LinkFault, bell::Bell},
};
use iceoryx2::{
    active_request::ActiveRequest,
    node::Node,
    pending_response::PendingResponse,
    port::{client::Client as ClientPort, server::Server as ServerPort},
    prelude::{AllocationStrategy, ipc},
    service::port_factory::request_response,
};
use serde::{Serialize, de::DeserializeOwned};

/// Bytes of a message in one part.
const PART: usize = 256 * 1024;
/// Longest message; the largest sensible patch is a thousandth of it.
const MESSAGE_LIMIT: usize = 256 * 1024 * 1024;
/// Bytes of a part's head: kind, index, count.
const HEAD: usize = 12;
/// First allocation of a port; it grows by powers of two.
const FIRST_SLICE: usize = 4096;

type Active = ActiveRequest<ipc::Service, [u8], (), [u8], ()>;
type Pending = PendingResponse<ipc::Service, [u8], (), [u8], ()>;
type Factory = request_response::PortFactory<ipc::Service, [u8], (), [u8], ()>;

/// What one exchange carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Bytes of a message.
    Part = 0,
    /// A part has come, send the next.
    Taken = 1,
    /// Send the part of the reply with this index.
    Pull = 2,
}

#[derive(Clone, Copy, Debug)]
struct Head {
    kind: Kind,
    index: u32,
    count: u32,
}

impl Head {
    fn bytes(self) -> [u8; HEAD] {
        let words = [self.kind as u32, self.index, self.count].map(u32::to_le_bytes);
        std::array::from_fn(|i| words[i / 4][i % 4])
    }

    fn parse(bytes: &[u8]) -> Option<(Head, &[u8])> {
        let (head, rest) = bytes.split_at_checked(HEAD)?;
        let word = |n: usize| u32::from_le_bytes(std::array::from_fn(|i| head[4 * n + i]));
        let kind = match word(0) {
            0 => Kind::Part,
            1 => Kind::Taken,
            2 => Kind::Pull,
            _ => return None,
        };
        Some((Head { kind, index: word(1), count: word(2) }, rest))
    }
}

fn garbled(detail: &str) -> LinkFault {
    LinkFault::Transport { doing: "reading a control message", detail: detail.to_owned() }
}

fn bincode_config() -> impl bincode::config::Config {
    bincode::config::standard().with_limit::<MESSAGE_LIMIT>()
}

fn encode(message: &impl Serialize) -> Result<Vec<u8>, LinkFault> {
    let bytes = bincode::serde::encode_to_vec(message, bincode_config())
        .map_err(fault("writing a control message"))?;
    if bytes.len() > MESSAGE_LIMIT {
        return Err(LinkFault::Transport {
            doing: "writing a control message",
            detail: format!("{} bytes are more than {MESSAGE_LIMIT}", bytes.len()),
        });
    }
    Ok(bytes)
}

fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, LinkFault> {
    let (message, used) = bincode::serde::decode_from_slice(bytes, bincode_config())
        .map_err(fault("reading a control message"))?;
    if used == bytes.len() { Ok(message) } else { Err(garbled("bytes are left over")) }
}

/// A message on its way out.
#[derive(Debug)]
struct Outgoing {
    bytes: Vec<u8>,
    next: u32,
}

impl Outgoing {
    fn count(&self) -> u32 {
        // Bounded by MESSAGE_LIMIT / PART; an empty message is one empty part.
        u32::try_from(self.bytes.len().div_ceil(PART).max(1)).unwrap_or(u32::MAX)
    }

    fn part(&self, index: u32) -> Option<(Head, &[u8])> {
        let count = self.count();
        let start = (index as usize).checked_mul(PART)?;
        let end = (start + PART).min(self.bytes.len());
        let head = Head { kind: Kind::Part, index, count };
        (index < count).then(|| self.bytes.get(start..end).map(|part| (head, part)))?
    }

    fn done(&self) -> bool {
        self.next >= self.count()
    }
}

/// A message on its way in.
#[derive(Debug, Default)]
struct Incoming {
    bytes: Vec<u8>,
    next: u32,
}

impl Incoming {
    /// Takes a part; true when it was the last.
    fn take(&mut self, head: Head, part: &[u8]) -> Result<bool, LinkFault> {
        if head.index == 0 {
            *self = Incoming::default();
        }
        if head.index != self.next || head.index >= head.count {
            return Err(garbled("a part is out of order"));
        }
        if self.bytes.len() + part.len() > MESSAGE_LIMIT {
            return Err(garbled("the message is too long"));
        }
        self.bytes.extend_from_slice(part);
        self.next += 1;
        Ok(self.next == head.count)
    }
}

/// One side's end of the control plane: what it sends, and what it gets.
pub trait Control: std::fmt::Debug {
    type Out;
    type In;
    /// Begins to send a message.
    fn put(&mut self, message: &Self::Out, bell: &Bell) -> Result<(), LinkFault>;
    /// Moves the exchange on; gives the message that comes when its last part has come.
    fn take(&mut self, bell: &Bell) -> Result<Option<Self::In>, LinkFault>;
    /// Moves what is left of a message; true when all of it has gone.
    fn gone(&mut self, bell: &Bell) -> Result<bool, LinkFault>;
    /// Whether the other side has said that it will end.
    fn goodbye(&self) -> bool;
}

fn service(node: &Node<ipc::Service>) -> Result<Factory, LinkFault> {
    node.service_builder(&service_name("control")?)
        .request_response::<[u8], [u8]>()
        .max_clients(1)
        .max_servers(1)
        .max_nodes(NODES)
        .max_active_requests_per_client(2)
        .max_response_buffer_size(2)
        .max_borrowed_responses_per_pending_response(2)
        .open_or_create()
        .map_err(fault("opening the control service"))
}

/// The analog side's end of the control plane.
#[derive(Debug)]
pub struct Server {
    port: ServerPort<ipc::Service, [u8], (), [u8], ()>,
    incoming: Incoming,
    /// The exchange that the reply will answer.
    asked: Option<Active>,
    outgoing: Option<Outgoing>,
    goodbye: bool,
}

impl Server {
    pub(super) fn open(node: &Node<ipc::Service>) -> Result<Server, LinkFault> {
        let port = service(node)?
            .server_builder()
            .initial_max_slice_len(FIRST_SLICE)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .map_err(fault("creating the control server"))?;
        let incoming = Incoming::default();
        Ok(Server { port, incoming, asked: None, outgoing: None, goodbye: false })
    }
}

impl Control for Server {
    type Out = Reply;
    type In = Request;

    fn take(&mut self, bell: &Bell) -> Result<Option<Request>, LinkFault> {
        let active = match self.port.receive() {
            Ok(Some(active)) => active,
            Ok(None) => return Ok(None),
            Err(e) => return Err(fault("receiving a request")(e)),
        };
        let (head, part) = Head::parse(active.payload()).ok_or_else(|| garbled("no such kind"))?;
        match head.kind {
            Kind::Part if self.incoming.take(head, part)? => {
                let request = decode(&std::mem::take(&mut self.incoming).bytes)?;
                self.asked = Some(active);
                self.goodbye |= matches!(request, Request::Bye);
                Ok(Some(request))
            }
            Kind::Part => {
                let taken = Head { kind: Kind::Taken, ..head };
                respond(&active, taken, &[], bell)?;
                Ok(None)
            }
            Kind::Pull => {
                let outgoing = self
                    .outgoing
                    .as_mut()
                    .ok_or_else(|| garbled("a part was pulled of no reply"))?;
                let (answer, part) = outgoing
                    .part(head.index)
                    .ok_or_else(|| garbled("a part was pulled beyond the last"))?;
                respond(&active, answer, part, bell)?;
                outgoing.next = head.index + 1;
                Ok(None)
            }
            Kind::Taken => Err(garbled("a request of the wrong kind")),
        }
    }

    fn put(&mut self, reply: &Reply, bell: &Bell) -> Result<(), LinkFault> {
        let active = self.asked.take().ok_or_else(|| garbled("a reply without a request"))?;
        let outgoing = self.outgoing.insert(Outgoing { bytes: encode(reply)?, next: 1 });
        let (head, part) = outgoing.part(0).ok_or_else(|| garbled("a reply without parts"))?;
        respond(&active, head, part, bell)
    }

    /// Serves pulls.
    fn gone(&mut self, bell: &Bell) -> Result<bool, LinkFault> {
        if self.outgoing.as_ref().is_none_or(Outgoing::done) {
            self.outgoing = None;
            return Ok(true);
        }
        match self.take(bell)? {
            None => Ok(self.outgoing.as_ref().is_none_or(Outgoing::done)),
            Some(_) => Err(garbled("a request came before its forerunner was answered")),
        }
    }

    fn goodbye(&self) -> bool {
        self.goodbye
    }
}

fn respond(active: &Active, head: Head, part: &[u8], bell: &Bell) -> Result<(), LinkFault> {
    let response = active.loan_slice_uninit(HEAD + part.len()).map_err(fault("loaning a reply"))?;
    let head = head.bytes();
    response.write_from_fn(|i| byte_at(&head, part, i)).send().map_err(fault("sending a reply"))?;
    bell.ring();
    Ok(())
}

fn byte_at(head: &[u8; HEAD], part: &[u8], i: usize) -> u8 {
    // Both lengths are those of the slice being written.
    if i < HEAD { head[i] } else { part[i - HEAD] }
}

/// The digital side's end of the control plane.
#[derive(Debug)]
pub struct Client {
    /// Dropped before the port that it belongs to.
    pending: Option<Pending>,
    port: ClientPort<ipc::Service, [u8], (), [u8], ()>,
    outgoing: Option<Outgoing>,
    incoming: Incoming,
}

impl Client {
    pub(super) fn open(node: &Node<ipc::Service>) -> Result<Client, LinkFault> {
        let port = service(node)?
            .client_builder()
            .initial_max_slice_len(FIRST_SLICE)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create()
            .map_err(fault("creating the control client"))?;
        Ok(Client { pending: None, port, outgoing: None, incoming: Incoming::default() })
    }

    fn ask(&self, head: Head, part: &[u8], bell: &Bell) -> Result<Pending, LinkFault> {
        let request =
            self.port.loan_slice_uninit(HEAD + part.len()).map_err(fault("loaning a request"))?;
        let head = head.bytes();
        let pending = request
            .write_from_fn(|i| byte_at(&head, part, i))
            .send()
            .map_err(fault("sending a request"))?;
        bell.ring();
        Ok(pending)
    }

    /// Sends the next part of the request.
    fn push(&mut self, bell: &Bell) -> Result<(), LinkFault> {
        self.pending = None;
        let outgoing = self.outgoing.as_ref();
        let (head, part) = outgoing
            .and_then(|o| o.part(o.next))
            .ok_or_else(|| garbled("no part is left to send"))?;
        self.pending = Some(self.ask(head, part, bell)?);
        Ok(())
    }
}

impl Control for Client {
    type Out = Request;
    type In = Reply;

    fn put(&mut self, request: &Request, bell: &Bell) -> Result<(), LinkFault> {
        self.incoming = Incoming::default();
        self.outgoing = Some(Outgoing { bytes: encode(request)?, next: 0 });
        self.push(bell)
    }

    fn take(&mut self, bell: &Bell) -> Result<Option<Reply>, LinkFault> {
        let Some(pending) = &self.pending else {
            return Err(garbled("nothing was asked"));
        };
        if pending.number_of_server_connections() == 0 {
            // A request sent before the server exists goes nowhere, and is no error.
            self.push(bell)?;
            return Ok(None);
        }
        let response = match pending.receive() {
            Ok(Some(response)) => response,
            Ok(None) => return Ok(None),
            Err(e) => return Err(fault("receiving a reply")(e)),
        };
        let (head, part) =
            Head::parse(response.payload()).ok_or_else(|| garbled("no such kind"))?;
        match head.kind {
            Kind::Taken => {
                drop(response);
                if let Some(outgoing) = &mut self.outgoing {
                    outgoing.next += 1;
                }
                self.push(bell)?;
                Ok(None)
            }
            Kind::Part if self.incoming.take(head, part)? => {
                drop(response);
                self.pending = None;
                self.outgoing = None;
                decode(&std::mem::take(&mut self.incoming).bytes).map(Some)
            }
            Kind::Part => {
                drop(response);
                let pull = Head { kind: Kind::Pull, index: self.incoming.next, count: head.count };
                self.pending = None;
                self.pending = Some(self.ask(pull, &[], bell)?);
                Ok(None)
            }
            Kind::Pull => Err(garbled("a reply of the wrong kind")),
        }
    }

    /// Its parts go with [`Control::take`].
    fn gone(&mut self, _bell: &Bell) -> Result<bool, LinkFault> {
        Ok(true)
    }

    fn goodbye(&self) -> bool {
        false
    }
}
