//! The transport's node counter, made by us before the transport makes it.
//!
//! iceoryx2 0.10 counts the nodes under a prefix in a small file which it opens to
//! all users (mode 0666, whatever the umask) and which hangs every later node if its
//! maker is killed between making and filling it. Where the file is there already,
//! the transport uses it as it is. So each side offers one that is complete and
//! private before it has a name; whoever comes second finds the first one's.
//!
//! It refuses a file that is not of this user's making. Name and content belong to the
//! pinned release; a test of the link looks at the modes of all shared memory.

use super::service::fault;
use crate::link::LinkFault;
use rustix::{
    fs::{AtFlags, CWD, FileType, Mode, OFlags, linkat, lstat},
    io::Errno,
};
use std::{fs::File, io::Write, os::fd::AsRawFd, path::Path};

/// What follows the prefix: a hash of the counter's type, `node`, release, kind.
const NAME: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";
/// Release 0.10.0 (16 bits each for major, minor and patch) where the transport
/// writes it, then the count.
const CONTENT: [u64; 2] = [10 << 16, 0];

/// Makes the counter of a session unless it is there.
pub(super) fn provide(shared_memory: &Path, prefix: &str) -> Result<(), LinkFault> {
    let path = shared_memory.join(format!("{prefix}{NAME}"));
    let doing = "making the transport's counter";
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let nameless = rustix::fs::open(shared_memory, flags, Mode::RUSR | Mode::WUSR);
    let mut file = File::from(nameless.map_err(fault(doing))?);
    let content: Vec<u8> = CONTENT.iter().flat_map(|word| word.to_ne_bytes()).collect();
    file.write_all(&content).map_err(fault(doing))?;
    let nameless = format!("/proc/self/fd/{}", file.as_raw_fd());
    match linkat(CWD, nameless, CWD, &path, AtFlags::SYMLINK_FOLLOW) {
        Ok(()) => Ok(()),
        Err(Errno::EXIST) => check(&path),
        Err(e) => Err(fault(doing)(e)),
    }
}

/// Accepts only what the partner made by [`provide`].
fn check(path: &Path) -> Result<(), LinkFault> {
    let found = lstat(path).map_err(fault("looking at the transport's counter"))?;
    let ours = FileType::from_raw_mode(found.st_mode) == FileType::RegularFile
        && found.st_uid == rustix::process::getuid().as_raw()
        && Mode::from_raw_mode(found.st_mode) == Mode::RUSR | Mode::WUSR
        && u64::try_from(found.st_size) == Ok(size_of_val(&CONTENT) as u64);
    if ours {
        Ok(())
    } else {
        Err(fault("looking at the transport's counter")(format!(
            "{} is not as this session makes it: somebody else made or changed it",
            path.display()
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn only_a_complete_file_of_ours_is_accepted() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(format!("p_{NAME}"));
        for _ in 0..2 {
            provide(dir.path(), "p_").unwrap();
            assert_eq!(fs::metadata(&path).unwrap().len(), 16);
        }
        fs::write(&path, "").unwrap();
        assert!(provide(dir.path(), "p_").is_err());
        fs::remove_file(&path).unwrap();
        std::os::unix::fs::symlink("/nowhere", &path).unwrap();
        assert!(provide(dir.path(), "p_").is_err());
    }
}
