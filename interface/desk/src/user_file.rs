//! Reading what a user names: a regular file of sensible size, refused at once if it is neither.
//!
//! A pipe or a terminal may never end, `/dev/zero` never does, and a file of gigabytes that was
//! named by mistake would fill the memory before its first fault is found.

use std::{
    fs::File,
    io::{Error, ErrorKind, Read as _, Result},
    path::Path,
};

/// Longest text, bytes: patches, studies, profiles, vehicles, run records. A hundred times the
/// largest shipped one.
pub const LONGEST_TEXT: u64 = 4 << 20;

/// All bytes of the regular file at `path`.
///
/// # Errors
/// Those of the system; [`ErrorKind::InvalidInput`] for what is no regular file, and
/// [`ErrorKind::FileTooLarge`] for more than `most` bytes.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let too_large = |bytes: u64| {
        let text = format!("it has {bytes} bytes, and {most} are the most");
        Err(Error::new(ErrorKind::FileTooLarge, text))
    };
    // Asked before it is opened: opening a pipe that nobody writes waits for ever.
    let about = std::fs::metadata(path)?;
    if !about.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is no regular file"));
    }
    if about.len() > most {
        return too_large(about.len());
    }
    let mut bytes = Vec::new();
    // Some files of the system state a length of zero, and a file may grow.
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return too_large(bytes.len() as u64);
    }
    Ok(bytes)
}

/// The text of the regular file at `path`, at most [`LONGEST_TEXT`] bytes.
///
/// # Errors
/// As [`read`], and [`ErrorKind::InvalidData`] for what is not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path, LONGEST_TEXT)?).map_err(|error| {
        let text = format!("it is not UTF-8 text at byte {}", error.utf8_error().valid_up_to());
        Error::new(ErrorKind::InvalidData, text)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_file_of_sensible_size_is_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("text"), "abc").unwrap();
        assert_eq!(read_text(&at("text")).unwrap(), "abc");
        let kind = |path: &Path, most| read(path, most).unwrap_err().kind();
        assert_eq!(kind(&at("text"), 2), ErrorKind::FileTooLarge);
        assert_eq!(kind(&at("none"), 9), ErrorKind::NotFound);
        assert_eq!(kind(folder.path(), 9), ErrorKind::InvalidInput);
        assert_eq!(kind(Path::new("/dev/zero"), 9), ErrorKind::InvalidInput);
        let pipe = std::process::Command::new("mkfifo").arg(at("pipe")).status();
        assert!(pipe.unwrap().success());
        assert_eq!(kind(&at("pipe"), 9), ErrorKind::InvalidInput);
        // Ten gigabytes of nothing.
        let hole = File::create(at("hole")).unwrap();
        hole.set_len(10_000_000_000).unwrap();
        let error = read_text(&at("hole")).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        assert!(error.to_string().contains("10000000000"), "{error}");
        std::fs::write(at("text"), b"ab\xff").unwrap();
        let error = read_text(&at("text")).unwrap_err();
        assert!(error.to_string().contains("byte 2"), "{error}");
    }
}
