//! Spellings of a text that must be read alike.

/// The same text with a byte order mark, and with the line ends of Windows.
pub fn other_spellings(data: &[u8]) -> Vec<Vec<u8>> {
    let Ok(text) = std::str::from_utf8(data) else { return Vec::new() };
    if text.starts_with(['\u{1}', '\u{feff}']) || text.contains('\r') {
        return Vec::new();
    }
    vec![format!("\u{feff}{text}").into_bytes(), text.replace('\n', "\r\n").into_bytes()]
}
