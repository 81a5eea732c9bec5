//! Trackers named on the command line, for frames without annotations.

use super::Failure;
use crate::plugin::{self, Configured, Entry};
use crate::spec::error::SourceFile;
use crate::tracker::process;
use crate::tracker::{TRACKERS, TrackerConfig};

/// Entry of a tracker in the list, and its configuration.
pub type NamedTracker = (&'static Entry<dyn TrackerConfig>, Configured<dyn TrackerConfig>);

/// Built-in tracker of a kind; `params` is a TOML table.
///
/// # Errors
/// `Usage` for an unknown tracker, wrong parameters, or a tracker that needs more than frames.
pub fn live_tracker(kind: &str, params: &str) -> Result<NamedTracker, Failure> {
    let kinds = || TRACKERS.iter().map(|e| e.kind);
    let Some(entry) = plugin::find(TRACKERS, kind) else {
        return Err(Failure::usage(plugin::unknown("tracker", kind, kinds())));
    };
    if entry.kind == process::ENTRY.kind {
        let message = "external programs are not run here: let the client start a TraX server, and give its boxes to \
                       `detect`";
        return Err(Failure::usage(message));
    }
    // Checked before the parameters, which are of no use for such a tracker.
    if entry.build_from_text(entry.example).is_ok_and(|example| example.facts().needs_truth) {
        let kind = entry.kind;
        return Err(Failure::usage(format!(
            "`{kind}` answers from ground truth or result files of known sequences; it cannot follow frames without annotations"
        )));
    }
    let config = entry.build_from_text(params).map_err(|e| {
        let source = SourceFile::new("--params", params);
        Failure::usage(source.error(e.span.unwrap_or(0..0), e.message).to_string())
    })?;
    Ok((entry, config))
}
