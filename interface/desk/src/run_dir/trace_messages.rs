//! The messages of a trace's Arrow stream, looked at before the Arrow library sees them.
//!
//! Every message must be whole and declare buffers that lie within its own body, so that
//! no damaged length can make the library allocate or index beyond the file. The stream
//! ends before the first message that is not whole, as that of a killed run does. One
//! message is held in memory at a time.

use std::io::{self, Read};
use std::path::Path;

use arrow_ipc::MessageHeader;

use super::RunDirError;

/// Why a stream cannot be read on.
pub(super) enum Fault {
    /// It is no trace, or was damaged.
    Damaged(&'static str),
    /// The file cannot be read.
    Io(io::Error),
}

impl Fault {
    /// The same, of the trace at `path`.
    pub fn told_of(self, path: &Path) -> RunDirError {
        match self {
            Fault::Damaged(reason) => RunDirError::not_a_trace(path, reason),
            Fault::Io(cause) => RunDirError::read(path)(cause),
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Fault {
        Fault::Io(error)
    }
}

/// Whole messages of `source`, as one stream of bytes.
pub(super) struct Messages<R> {
    source: R,
    /// The message at hand, and how much of it has been read.
    message: Vec<u8>,
    taken: usize,
    /// Whole messages so far, the schema included.
    count: u64,
    /// Columns that the schema declares.
    columns: usize,
    /// Whether the end mark was met.
    ended: bool,
    /// Nothing follows: the end mark, a torn message, or a fault.
    over: bool,
    fault: Option<Fault>,
}

impl<R: Read> Messages<R> {
    pub fn new(source: R) -> Messages<R> {
        Messages {
            source,
            message: Vec::new(),
            taken: 0,
            count: 0,
            columns: 0,
            ended: false,
            over: false,
            fault: None,
        }
    }

    /// Reads the first message; false when there is none that is whole.
    pub fn begin(&mut self) -> Result<bool, Fault> {
        self.next_message()?;
        Ok(self.count > 0)
    }

    /// Whether the run ended the stream itself.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// What ended the stream, if it was a fault.
    pub fn take_fault(&mut self) -> Option<Fault> {
        self.fault.take()
    }

    /// Marker, metadata length, metadata, body. Without a further whole message nothing
    /// follows.
    fn next_message(&mut self) -> Result<(), Fault> {
        const MARKER: [u8; 4] = [0xff; 4];
        self.message.clear();
        self.taken = 0;
        self.over = true;
        if !self.take(8)? {
            return Ok(());
        }
        if self.message[..4] != MARKER {
            return Err(Fault::Damaged(
                "it does not begin as an Arrow stream, or a message of it is overwritten",
            ));
        }
        let length = [4, 5, 6, 7].map(|i| self.message[i]);
        let length = u64::try_from(i32::from_le_bytes(length))
            .map_err(|_| Fault::Damaged("a message has a negative length"))?;
        if length == 0 {
            self.ended = true;
            self.message.clear();
            return Ok(());
        }
        if !self.take(length)? {
            return Ok(());
        }
        let message = arrow_ipc::root_as_message(&self.message[8..])
            .map_err(|_| Fault::Damaged("a message's metadata is damaged"))?;
        let body = u64::try_from(message.bodyLength())
            .map_err(|_| Fault::Damaged("a body has a negative length"))?;
        let (kind, metadata) = (message.header_type(), self.message.len());
        if !self.take(body)? {
            return Ok(());
        }
        let message = arrow_ipc::root_as_message(&self.message[8..metadata])
            .map_err(|_| Fault::Damaged("a message's metadata is damaged"))?;
        match (self.count, kind) {
            (0, MessageHeader::Schema) => {
                let schema = message.header_as_schema();
                let schema = schema.ok_or(Fault::Damaged("it has no schema"))?;
                self.columns = schema.fields().map_or(0, |fields| fields.len());
            }
            (1.., MessageHeader::RecordBatch) => {
                let batch = message.header_as_record_batch();
                let batch = batch.ok_or(Fault::Damaged("a batch is damaged"))?;
                check_batch(batch, self.columns, body)?;
            }
            _ => {
                return Err(Fault::Damaged("it holds messages that a trace never holds"));
            }
        }
        self.count += 1;
        self.over = false;
        Ok(())
    }

    /// Reads `length` further bytes of a message; false, and nothing is left of the
    /// message, when the file ends before.
    fn take(&mut self, length: u64) -> io::Result<bool> {
        let got = self.source.by_ref().take(length).read_to_end(&mut self.message)?;
        let whole = got as u64 == length;
        if !whole {
            self.message.clear();
        }
        Ok(whole)
    }
}

impl<R: Read> Read for Messages<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.message.len()
            && !self.over
            && let Err(fault) = self.next_message()
        {
            self.message.clear();
            self.fault = Some(fault);
        }
        let rest = &self.message[self.taken..];
        let n = rest.len().min(into.len());
        into[..n].copy_from_slice(&rest[..n]);
        self.taken += n;
        Ok(n)
    }
}

/// Each column of a batch is one node and two buffers (validity, then 8 bytes a row), all
/// within the body and uncompressed.
fn check_batch(batch: arrow_ipc::RecordBatch<'_>, columns: usize, body: u64) -> Result<(), Fault> {
    const DAMAGED: Fault = Fault::Damaged("a batch's buffers do not fit its rows");
    let (nodes, buffers) = (batch.nodes().ok_or(DAMAGED)?, batch.buffers().ok_or(DAMAGED)?);
    let rows = batch.length();
    let whole = nodes.len() == columns
        && buffers.len() == 2 * columns
        && batch.compression().is_none()
        && (0..=(body / 8) as i64).contains(&rows)
        && nodes.iter().all(|node| node.length() == rows && node.null_count() == 0)
        && buffers.iter().enumerate().all(|(i, buffer)| {
            let (offset, length) = (buffer.offset(), buffer.length());
            let enough = i % 2 == 0 || length == rows * 8;
            offset >= 0
                && length >= 0
                && enough
                && offset.checked_add(length).is_some_and(|end| end <= body as i64)
        });
    if whole { Ok(()) } else { Err(DAMAGED) }
}
