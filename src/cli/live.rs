//! Trackers that are named on the command line, to follow frames that nobody has annotated.

use super::Failure;
use crate::plugin::{self, Entry};
use crate::spec::error::Source;
use crate::tracker::process;
use crate::tracker::{TRACKERS, TrackerConfig};
use std::sync::Arc;

/// A tracker and its line in the list.
pub type Named = (&'static Entry<dyn TrackerConfig>, Arc<dyn TrackerConfig>);

/// The built-in tracker of a kind; `params` is a TOML table.
///
/// # Errors
/// `Usage` for a tracker or parameters that there are not, and for one that needs more than frames.
pub fn live_tracker(kind: &str, params: &str) -> Result<Named, Failure> {
    let kinds = || TRACKERS.iter().map(|e| e.kind);
    let Some(entry) = plugin::find(TRACKERS, kind) else {
        return Err(Failure::Usage(plugin::unknown("tracker", kind, kinds())));
    };
    if entry.kind == process::ENTRY.kind {
        let message = "a program of one's own is not run here: of a TraX server let the client start it, and give \
                       its boxes to `detect`";
        return Err(Failure::Usage(message.into()));
    }
    // Known before its own parameters are: those of such trackers mean nothing here.
    if entry.build_from_text(entry.example).is_ok_and(|example| example.needs_truth()) {
        let kind = entry.kind;
        return Err(Failure::Usage(format!(
            "`{kind}` answers from ground truth or result files of known sequences; it cannot follow frames that nobody has annotated"
        )));
    }
    let setup = entry.build_from_text(params).map_err(|e| {
        let source = Source::new("--params", params);
        Failure::Usage(source.error(e.span.unwrap_or(0..0), e.message).to_string())
    })?;
    Ok((entry, Arc::from(setup)))
}
