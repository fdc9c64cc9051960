use super::{remains::SHARED_MEMORY, *};

fn base() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

#[test]
fn the_last_side_to_leave_removes_everything() {
    for digital_leaves_first in [true, false] {
        let base = base();
        let digital = Session::create_in(base.path(), Side::Digital, Some("one")).unwrap();
        let analog = Session::join_in(base.path(), Side::Analog, "one").unwrap();
        assert_eq!(digital.prefix(), analog.prefix());
        let root = digital.root().to_owned();
        let leak = Path::new(SHARED_MEMORY).join(format!("{}leak", digital.prefix()));
        fs::write(&leak, "x").unwrap();
        let (first, last) =
            if digital_leaves_first { (digital, analog) } else { (analog, digital) };
        drop(first);
        assert!(root.exists() && leak.exists());
        assert!(last.partner().unwrap().is_none());
        drop(last);
        assert!(!root.exists() && !leak.exists() && !base.path().exists());
    }
}

#[test]
fn a_place_is_taken_once() {
    let base = base();
    let _digital = Session::create_in(base.path(), Side::Digital, Some("one")).unwrap();
    assert!(matches!(
        Session::create_in(base.path(), Side::Digital, Some("one")),
        Err(SessionError::InUse { .. })
    ));
    let _analog = Session::join_in(base.path(), Side::Analog, "one").unwrap();
    assert!(matches!(
        Session::join_in(base.path(), Side::Analog, "one"),
        Err(SessionError::Taken { side: Side::Analog, .. })
    ));
}

#[test]
fn sessions_are_found_by_name() {
    let base = base();
    assert!(matches!(
        Session::join_in(base.path(), Side::Digital, "x"),
        Err(SessionError::Unknown { .. })
    ));
    let _serving = Session::create_in(base.path(), Side::Analog, Some("lab-1")).unwrap();
    let other = Session::create_in(base.path(), Side::Digital, None).unwrap();
    let list = Session::list_in(base.path()).unwrap();
    assert_eq!(list.len(), 2);
    let lab = list.iter().find(|i| i.name == "lab-1").unwrap();
    assert_eq!((lab.analog, lab.digital), (Some(std::process::id()), None));
    let error = Session::join_in(base.path(), Side::Digital, "lab").unwrap_err();
    assert!(error.to_string().contains("lab-1"), "{error}");
    assert_ne!(other.name(), "lab-1");
    for name in ["", "a/b", "..", "a b", "ä", &"x".repeat(49)] {
        assert!(matches!(
            Session::create_in(base.path(), Side::Digital, Some(name)),
            Err(SessionError::Name { .. })
        ));
    }
}

#[test]
fn stale_and_half_made_sessions_are_swept() {
    let base = base();
    let path = base.path().canonicalize().unwrap();
    // Killed right after mkdir; killed with lock files that name a pid in use by
    // another process (ours); and a folder that is none of ours.
    fs::create_dir(root_of(&path, "half")).unwrap();
    let dead = root_of(&path, "dead");
    fs::create_dir(&dead).unwrap();
    fs::write(lock_path(&dead, Side::Digital), std::process::id().to_string()).unwrap();
    let leak = |root: &Path| {
        let leak = Path::new(SHARED_MEMORY).join(format!("{}leak", make_prefix(root).unwrap()));
        fs::write(&leak, "x").unwrap();
        leak
    };
    let first = leak(&dead);
    let foreign = path.join("foreign");
    fs::create_dir(&foreign).unwrap();
    assert!(matches!(
        Session::join_in(&path, Side::Analog, "dead"),
        Err(SessionError::Deserted { side: Side::Digital, .. })
    ));
    assert!(!dead.exists() && !first.exists());
    fs::create_dir(&dead).unwrap();
    let second = leak(&dead);
    assert!(Session::list_in(&path).unwrap().is_empty());
    let session = Session::create_in(&path, Side::Digital, Some("new")).unwrap();
    assert!(!dead.exists() && !second.exists() && !root_of(&path, "half").exists());
    drop(session);
    assert!(foreign.exists());
}

#[test]
fn a_base_open_to_others_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let base = base();
    fs::set_permissions(base.path(), fs::Permissions::from_mode(0o777)).unwrap();
    let refused = |path: &Path| {
        matches!(
            Session::create_in(path, Side::Digital, None),
            Err(SessionError::ForeignBase { .. })
        )
    };
    assert!(refused(base.path()));
    fs::set_permissions(base.path(), fs::Permissions::from_mode(0o700)).unwrap();
    let link = base.path().join("link");
    std::os::unix::fs::symlink(base.path(), &link).unwrap();
    assert!(refused(&link));
    let file = base.path().join("file");
    fs::write(&file, "").unwrap();
    assert!(refused(&file));
}

#[test]
fn fifty_threads_create_and_leave_without_disturbing_each_other() {
    let base = base();
    let inner = base.path().join("inner");
    std::thread::scope(|scope| {
        for _ in 0..50 {
            scope.spawn(|| {
                for _ in 0..4 {
                    let digital = Session::create_in(&inner, Side::Digital, None).unwrap();
                    let analog = Session::join_in(&inner, Side::Analog, digital.name()).unwrap();
                    assert!(analog.partner().unwrap().is_some());
                    drop(digital);
                    assert!(analog.root().exists());
                }
            });
        }
    });
    assert!(!inner.exists());
}

#[test]
fn a_base_path_is_used_up_to_its_limit_and_refused_beyond() {
    let dir = base();
    let inside = |length: usize| {
        let room = length - dir.path().as_os_str().len() - 1;
        dir.path().join("x".repeat(room))
    };
    for (name, limit) in [(None, 77), (Some("x".repeat(48)), 43), (Some("a".into()), 90)] {
        let name = name.as_deref();
        let digital = Session::create_in(&inside(limit), Side::Digital, name).unwrap();
        drop(digital);
        let long = inside(limit + 1);
        let error = Session::create_in(&long, Side::Digital, name).unwrap_err();
        let text = error.to_string();
        assert!(
            text.contains(&format!("has {} bytes", limit + 1))
                && text.contains(&format!("at most {limit} bytes"))
                && text.contains(BASE_VARIABLE),
            "{text}"
        );
        assert!(!long.exists());
    }
    for odd in ["é", "a\tb", "a*", "a?b", "\"a\"", "a|b", "<a>"] {
        let path = dir.path().join(odd);
        let error = Session::create_in(&path, Side::Digital, None).unwrap_err();
        assert!(matches!(error, SessionError::BasePath { .. }), "{error}");
        assert!(!path.exists());
    }
    let plain = dir.path().join("A b,c;d!#%&'()+=@[]^`{}~$:-_.");
    drop(Session::create_in(&plain, Side::Digital, None).unwrap());
}

#[test]
fn prefixes_cannot_be_known_beforehand() {
    let base = base();
    let prefix = || {
        let session = Session::create_in(base.path(), Side::Analog, Some("lab")).unwrap();
        let prefix = session.prefix().to_owned();
        assert_eq!(prefix.len(), remains::PREFIX_LENGTH);
        prefix
    };
    assert_ne!(prefix(), prefix());
}

#[test]
fn a_namesake_that_followed_is_left_alone() {
    let base = base();
    let digital = Session::create_in(base.path(), Side::Digital, Some("one")).unwrap();
    let analog = Session::join_in(base.path(), Side::Analog, "one").unwrap();
    // The digital side has closed its end; the analog one, leaving first, removes all.
    analog.inherit();
    drop(analog);
    assert!(!digital.root().exists());
    let namesake = Session::create_in(base.path(), Side::Digital, Some("one")).unwrap();
    drop(digital);
    assert!(namesake.root().exists());
}

#[test]
fn what_a_partner_was_killed_removing_is_removed() {
    let base = base();
    let digital = Session::create_in(base.path(), Side::Digital, Some("one")).unwrap();
    let root = digital.root().to_owned();
    std::fs::remove_file(remains::lock_path(&root, Side::Digital)).unwrap();
    drop(digital);
    assert!(!root.exists());
}
