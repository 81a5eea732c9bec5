//! Names of archive members: which of them can be a path, and what else is refused.
//!
//! A name that any of the systems this runs on would read as leading elsewhere, or could not store, is
//! refused on all of them, so that an archive is good everywhere or nowhere.

/// Longest name of a file or folder in bytes, as on most file systems.
const COMPONENT: usize = 255;

/// Start of the names that this program keeps for itself, such as [`MARKER`](super::MARKER).
const RESERVED: &str = ".trackfail";

/// Names that Windows keeps for devices, whatever extension follows.
const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "conin$", "conout$"];

/// Why a member, and with it its archive, is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MemberFault {
    /// Bytes that are no text.
    #[error("its name is not UTF-8")]
    NotUtf8,
    /// NUL, newline, escape ...
    #[error("its name has a control character")]
    Control,
    /// A separator on Windows only.
    #[error("its name has a backslash")]
    Backslash,
    /// A drive letter or a stream on Windows.
    #[error("its name has a colon")]
    Colon,
    /// A leading `/`.
    #[error("its path is absolute")]
    Absolute,
    /// `..`, or `.` where it means nothing.
    #[error("its path has a `.` or `..`")]
    Dots,
    /// Nothing, or two separators in a row.
    #[error("its name is empty or a part of it is")]
    Empty,
    /// A part that file systems do not take.
    #[error("a part of its name is longer than {COMPONENT} bytes")]
    Long,
    /// A device on Windows.
    #[error("its name is that of a device on Windows")]
    Device,
    /// A name of a file that this program writes itself.
    #[error("a part of its name starts with {RESERVED}, which this program keeps for itself")]
    Reserved,
    /// Windows drops such an end.
    #[error("a part of its name ends with a dot or a space")]
    End,
    /// Too many folders.
    #[error("its path has more than {0} parts")]
    Deep(usize),
    /// Not a file, not a folder.
    #[error("it is a {0}; only files and folders are unpacked")]
    Kind(&'static str),
    /// The same path again, also in other letters.
    #[error("the path is there twice, letters' case apart")]
    Twice,
    /// A file where other members need a folder.
    #[error("the path is a file and a folder")]
    FileAndFolder,
    /// A password would be needed.
    #[error("it is encrypted")]
    Encrypted,
    /// A compression that is not built in.
    #[error("it is packed by the method {0}, not stored or deflated")]
    Method(String),
    /// A member larger than [`Caps::member`](super::Caps).
    #[error("it has more than {0} bytes")]
    Large(u64),
    /// More in all than [`Caps::total`](super::Caps).
    #[error("with it the archive has more than {0} bytes")]
    Total(u64),
    /// More bytes for those packed than [`Caps::ratio`](super::Caps) allows.
    #[error("with it the archive unpacks to more than {0} times its size")]
    Ratio(u64),
    /// More than [`Caps::entries`](super::Caps).
    #[error("it is one of more than {0} members")]
    Many(u64),
    /// Another length than the archive says.
    #[error("{got} bytes, the archive says {declared}")]
    Length {
        /// Bytes that came out.
        got: u64,
        /// Bytes announced.
        declared: u64,
    },
    /// Bytes that belong to two members.
    #[error("it shares packed bytes with another member")]
    Overlap,
    /// Extended headers that change what other readers see.
    #[error("its header has `{0}`, which is not read here")]
    Header(String),
    /// Checksums, cut data.
    #[error("it is damaged ({0})")]
    Damaged(String),
}

/// The parts of a member's path, checked; none for the archive's own top folder (`./`).
///
/// # Errors
/// Every name that is not one or more plain names with `/` between them.
pub(super) fn parts(raw: &[u8], depth: usize) -> Result<Vec<String>, MemberFault> {
    let name = std::str::from_utf8(raw).map_err(|_| MemberFault::NotUtf8)?;
    if name.chars().any(char::is_control) {
        return Err(MemberFault::Control);
    }
    if name.contains('\\') {
        return Err(MemberFault::Backslash);
    }
    if name.contains(':') {
        return Err(MemberFault::Colon);
    }
    if name.starts_with('/') {
        return Err(MemberFault::Absolute);
    }
    if name.is_empty() {
        return Err(MemberFault::Empty);
    }
    // `tar -c .` writes `./` before every path.
    let name = name.strip_suffix('/').unwrap_or(name);
    let name = if name == "." { "" } else { name.strip_prefix("./").unwrap_or(name) };
    if name.is_empty() {
        return Ok(Vec::new());
    }
    let parts: Vec<String> = name.split('/').map(String::from).collect();
    parts.iter().try_for_each(|p| check(p))?;
    if parts.len() > depth {
        return Err(MemberFault::Deep(depth));
    }
    Ok(parts)
}

fn check(part: &str) -> Result<(), MemberFault> {
    if part.is_empty() {
        return Err(MemberFault::Empty);
    }
    if part == "." || part == ".." {
        return Err(MemberFault::Dots);
    }
    if part.len() > COMPONENT {
        return Err(MemberFault::Long);
    }
    if part.ends_with(['.', ' ']) {
        return Err(MemberFault::End);
    }
    if part.to_lowercase().starts_with(RESERVED) {
        return Err(MemberFault::Reserved);
    }
    let stem = part.split('.').next().unwrap_or_default().trim_end_matches(' ').to_lowercase();
    let port = ["com", "lpt"].iter().find_map(|p| stem.strip_prefix(p)).unwrap_or_default();
    let numbered =
        port.chars().count() == 1 && port.contains(|c: char| c.is_ascii_digit() || "¹²³".contains(c));
    if numbered || DEVICES.contains(&stem.as_str()) {
        return Err(MemberFault::Device);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::path::{Component, Path};

    #[test]
    fn plain_names_are_taken() {
        let long = "x".repeat(255);
        for (raw, wanted) in [
            ("David/img/0001.jpg", vec!["David", "img", "0001.jpg"]),
            ("David/", vec!["David"]),
            ("./a/b", vec!["a", "b"]),
            ("./", vec![]),
            (".", vec![]),
            (".hidden", vec![".hidden"]),
            ("..a/b..c", vec!["..a", "b..c"]),
            ("a b/é.txt", vec!["a b", "é.txt"]),
            ("console/com/com10/lptx", vec!["console", "com", "com10", "lptx"]),
            (long.as_str(), vec![long.as_str()]),
        ] {
            assert_eq!(parts(raw.as_bytes(), 4).unwrap(), wanted, "{raw}");
        }
    }

    #[test]
    fn every_other_name_is_refused() {
        let long = "x".repeat(256);
        let wide = "é".repeat(128);
        for (raw, reason) in [
            (&b"a\xff"[..], MemberFault::NotUtf8),
            (b"\xc0\xae\xc0\xae/a", MemberFault::NotUtf8),
            (b"a\0b", MemberFault::Control),
            (b"a\x1b[2J", MemberFault::Control),
            ("a\u{85}".as_bytes(), MemberFault::Control),
            (b"a\nb", MemberFault::Control),
            (b"..\\a", MemberFault::Backslash),
            (b"\\\\host\\a", MemberFault::Backslash),
            (b"C:a", MemberFault::Colon),
            (b"C:/a", MemberFault::Colon),
            (b"a.jpg:stream", MemberFault::Colon),
            (b"/etc/passwd", MemberFault::Absolute),
            (b"//host/a", MemberFault::Absolute),
            (b"/", MemberFault::Absolute),
            (b"../a", MemberFault::Dots),
            (b"a/../../b", MemberFault::Dots),
            (b"a/..", MemberFault::Dots),
            (b"..", MemberFault::Dots),
            (b"a/./b", MemberFault::Dots),
            (b"././a", MemberFault::Dots),
            (b"./../a", MemberFault::Dots),
            (b"", MemberFault::Empty),
            (b"a//b", MemberFault::Empty),
            (b".//etc/passwd", MemberFault::Empty),
            (b"a//", MemberFault::Empty),
            (long.as_bytes(), MemberFault::Long),
            (wide.as_bytes(), MemberFault::Long),
            (b"a./b", MemberFault::End),
            (b"a /b", MemberFault::End),
            (b"...", MemberFault::End),
            (b"a/NUL", MemberFault::Device),
            (b"con.txt", MemberFault::Device),
            (b"Com1.tar.gz", MemberFault::Device),
            ("lpt\u{b2}".as_bytes(), MemberFault::Device),
            (b"aux .c", MemberFault::Device),
            (b"a/.trackfail-complete", MemberFault::Reserved),
            (b".TrackFail/lock", MemberFault::Reserved),
            (b"1/2/3/4/5", MemberFault::Deep(4)),
        ] {
            assert_eq!(parts(raw, 4), Err(reason), "{}", String::from_utf8_lossy(raw));
        }
    }

    proptest! {
        // The standard library's own reading of paths is the judge.
        #[test]
        fn a_name_that_is_taken_stays_inside(raw in prop_oneof![
            proptest::collection::vec(any::<u8>(), 0..40),
            "[./\\\\:aA ~\u{0}é]{0,12}".prop_map(String::into_bytes),
        ]) {
            let Ok(parts) = parts(&raw, 8) else { return Ok(()) };
            let path = parts.iter().fold(Path::new("/root").to_path_buf(), |p, part| p.join(part));
            let inside: Vec<Component> = path.components().collect();
            prop_assert!(path.starts_with("/root"));
            prop_assert_eq!(inside.len(), parts.len() + 2);
            prop_assert!(inside[1..].iter().all(|c| matches!(c, Component::Normal(_))));
            prop_assert!(parts.iter().all(|p| !p.contains(['/', '\\', ':', '\0']) && p.len() <= 255));
        }
    }
}
