//! A run's state on disk, from which it goes on after it was killed.
//!
//! One file holds all of it, so that nothing can be torn: a head (what it is, its format, the build
//! that wrote it), the state, and the SHA-256 of all that. It is written beside its name, brought to
//! the disk and renamed: there is the last one whole, or none. Files that grow with the run are cut
//! to where they were ([`Seam`]). It refuses a file that is damaged, cut off or of another build,
//! whose numbers could be others; what the state belongs to is for who reads it to judge.

use crate::{run_dir::RunDirError, user_file};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use sha2::{Digest, Sha256};
use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::{self, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    sync::OnceLock,
};

/// What a checkpoint begins with; the number is that of its format.
const MARK: &[u8] = b"hybrid-computer checkpoint 1\n";
/// Part of the mark that no format changes.
const NAME: &[u8] = b"hybrid-computer checkpoint ";
/// Bytes of a SHA-256.
const DIGEST: usize = 32;
/// Longest checkpoint: delay lines remember a lot.
const MOST_BYTES: u64 = 1 << 30;
/// Bytes before a seam by which a file is known again.
const TAIL: u64 = 256;

/// SHA-256 of the running program.
fn build() -> io::Result<[u8; DIGEST]> {
    static BUILD: OnceLock<[u8; DIGEST]> = OnceLock::new();
    if let Some(build) = BUILD.get() {
        return Ok(*build);
    }
    let build = Sha256::digest(fs::read("/proc/self/exe")?).into();
    Ok(*BUILD.get_or_init(|| build))
}

/// Writes a run's state.
pub fn write(path: &Path, state: &impl Serialize) -> Result<(), RunDirError> {
    let failed = |cause| RunDirError::Write { path: path.to_owned(), cause };
    let other = |e: bincode::error::EncodeError| failed(io::Error::other(e));
    let mut bytes = MARK.to_vec();
    bytes.extend(build().map_err(failed)?);
    let state = bincode::serde::encode_to_vec(state, bincode::config::standard()).map_err(other)?;
    bytes.extend((state.len() as u64).to_le_bytes());
    bytes.extend(state);
    bytes.extend(Sha256::digest(&bytes));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".{name}.partial"));
    let put = || {
        let mut file = File::create(&partial)?;
        file.write_all(&bytes)?;
        file.sync_all()?;
        fs::rename(&partial, path)?;
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
        File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
    };
    put().map_err(|cause| {
        // Half a file is of no use to anybody; if this fails too, the reason is the same.
        let _ = fs::remove_file(&partial);
        failed(cause)
    })
}

/// Reads a run's state.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<T, RunDirError> {
    let failed = |cause| RunDirError::Read { path: path.to_owned(), cause };
    let bytes = user_file::read(path, MOST_BYTES).map_err(failed)?;
    let body = body(&bytes, &build().map_err(failed)?)
        .map_err(|reason| RunDirError::Refused(format!("`{}` {reason}", path.display())))?;
    let (state, _) = bincode::serde::decode_from_slice(body, bincode::config::standard())
        .map_err(|e| failed(io::Error::other(e)))?;
    Ok(state)
}

/// The state in a checkpoint of this build; else why it is none.
fn body<'b>(bytes: &'b [u8], build: &[u8; DIGEST]) -> Result<&'b [u8], &'static str> {
    let cut_off = "is cut off: the run cannot go on from it; start it anew";
    let Some(rest) = bytes.strip_prefix(MARK) else {
        return Err(if MARK.starts_with(bytes) {
            cut_off
        } else if bytes.starts_with(NAME) {
            "is a checkpoint of another format; go on with the build that began the run, or start it anew"
        } else {
            "is no checkpoint"
        });
    };
    let (by, rest) = rest.split_at_checked(DIGEST).ok_or(cut_off)?;
    let (length, rest) = rest.split_at_checked(size_of::<u64>()).ok_or(cut_off)?;
    let length = length.try_into().map_or(u64::MAX, u64::from_le_bytes);
    let whole = length.checked_add(DIGEST as u64);
    let damaged = "is damaged: its check sum is that of other contents; start the run anew";
    match whole {
        Some(whole) if whole == rest.len() as u64 => {}
        Some(whole) if whole > rest.len() as u64 => return Err(cut_off),
        _ => return Err(damaged),
    }
    let (body, digest) = rest.split_at(rest.len() - DIGEST);
    if Sha256::digest(&bytes[..bytes.len() - DIGEST])[..] != *digest {
        return Err(damaged);
    }
    if by != build {
        return Err(
            "was written by another build of this program, whose numbers may be others; go on with the build that began the run, or start it anew",
        );
    }
    Ok(body)
}

/// Where a file that grows with a run stood at a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seam {
    length: u64,
    /// Its last bytes.
    tail: Vec<u8>,
}

impl Seam {
    /// The end of `file`, by then on the disk; `path` is its name.
    pub fn at_end(file: &File, path: &Path) -> Result<Seam, RunDirError> {
        let failed = |cause| RunDirError::Write { path: path.to_owned(), cause };
        hold(file, path)?;
        file.sync_data().map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let tail = tail(&File::open(path).map_err(failed)?, length).map_err(failed)?;
        Ok(Seam { length, tail })
    }

    /// Opens the file there: what was written later is cut off.
    pub fn reopen(&self, path: &Path) -> Result<File, RunDirError> {
        let failed = |cause| RunDirError::Write { path: path.to_owned(), cause };
        let file = OpenOptions::new().read(true).write(true).open(path).map_err(failed)?;
        hold(&file, path)?;
        let is_same = file.metadata().map_err(failed)?.len() >= self.length
            && tail(&file, self.length).map_err(failed)? == self.tail;
        if !is_same {
            return Err(RunDirError::Refused(format!(
                "`{}` is not as the checkpoint left it: the run cannot go on in it; start it anew",
                path.display()
            )));
        }
        file.set_len(self.length).map_err(failed)?;
        (&file).seek(SeekFrom::Start(self.length)).map_err(failed)?;
        Ok(file)
    }
}

/// Keeps a file to the run that writes it, as long as that has it open: a second one that goes on in
/// it would overwrite the first one's rows.
fn hold(file: &File, path: &Path) -> Result<(), RunDirError> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(RunDirError::Refused(format!(
            "`{}` is still being written: its run is under way (perhaps stopped, by Ctrl-Z); end that one first",
            path.display()
        ))),
        Err(TryLockError::Error(cause)) => Err(RunDirError::Write { path: path.to_owned(), cause }),
    }
}

/// The last bytes of the first `length` of a file.
fn tail(mut file: &File, length: u64) -> io::Result<Vec<u8>> {
    let size = length.min(TAIL);
    file.seek(SeekFrom::Start(length - size))?;
    let mut tail = Vec::new();
    file.take(size).read_to_end(&mut tail)?;
    Ok(tail)
}

/// The checkpoint of a run that has no directory, beside what it writes.
pub fn beside(output: &Path) -> PathBuf {
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    output.with_file_name(format!("{name}.checkpoint"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(folder: &tempfile::TempDir) -> (PathBuf, Vec<u8>) {
        let path = folder.path().join("c");
        write(&path, &("state", vec![0.1_f64, f64::NAN])).unwrap();
        let bytes = fs::read(&path).unwrap();
        (path, bytes)
    }

    fn refusal(path: &Path, bytes: &[u8]) -> String {
        fs::write(path, bytes).unwrap();
        read::<(String, Vec<f64>)>(path).unwrap_err().to_string()
    }

    #[test]
    fn what_is_damaged_cut_off_or_foreign_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (path, bytes) = written(&folder);
        let (text, numbers): (String, Vec<f64>) = read(&path).unwrap();
        assert!(text == "state" && numbers[0] == 0.1 && numbers[1].is_nan());
        for cut in 0..bytes.len() {
            let reason = refusal(&path, &bytes[..cut]);
            assert!(reason.contains("cut off"), "{cut}: {reason}");
        }
        for place in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0x10;
            let reason = refusal(&path, &damaged);
            let known = ["damaged", "cut off", "no checkpoint", "another format"];
            assert!(known.iter().any(|k| reason.contains(k)), "{place}: {reason}");
        }
        assert!(refusal(&path, &[&bytes[..], &[0]].concat()).contains("damaged"));
        assert!(refusal(&path, b"rows").contains("no checkpoint"));
        let mut foreign = bytes[..bytes.len() - DIGEST].to_vec();
        foreign[MARK.len()] ^= 1;
        let digest = Sha256::digest(&foreign);
        foreign.extend(digest);
        assert!(refusal(&path, &foreign).contains("another build"));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_goes_on_where_it_was_and_another_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows");
        let mut file = File::create(&path).unwrap();
        file.write_all(&[7; 1000]).unwrap();
        let seam = Seam::at_end(&file, &path).unwrap();
        file.write_all(b"later").unwrap();
        let reason = seam.reopen(&path).unwrap_err().to_string();
        assert!(reason.contains("under way"), "{reason}");
        drop(file);
        seam.reopen(&path).unwrap().write_all(b"again").unwrap();
        let mut expected = vec![7; 1000];
        expected.extend(b"again");
        assert_eq!(fs::read(&path).unwrap(), expected);
        for other in [vec![7; 999], vec![8; 2000]] {
            fs::write(&path, &other).unwrap();
            let reason = seam.reopen(&path).unwrap_err().to_string();
            assert!(reason.contains("not as the checkpoint left it"), "{reason}");
            assert_eq!(fs::read(&path).unwrap(), other);
        }
    }
}
