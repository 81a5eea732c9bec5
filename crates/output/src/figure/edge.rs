//! The two ends of what lasts for some frames.

/// Beginning or end of a loss or an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// It begins.
    Begins,
    /// It ends.
    Ends,
}
