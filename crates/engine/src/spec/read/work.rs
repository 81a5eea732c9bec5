//! The size of the work that an experiment asks for.

use crate::spec::error::{Source, SpecError};
use crate::spec::limits::MAX_CELLS;
use crate::spec::method::Method;
use std::ops::Range;

/// Refuses more cells than can be planned; `runs` is the number of trackers, each counted once a repetition.
pub(super) fn check_work(
    source: Source<'_>,
    span: Range<usize>,
    runs: u64,
    methods: &[Method],
) -> Result<(), SpecError> {
    let variants: usize = methods.iter().map(|m| m.variants.len()).sum();
    let cells = runs.saturating_mul(variants as u64);
    if cells <= MAX_CELLS as u64 {
        return Ok(());
    }
    let message = format!(
        "{runs} runs of trackers with {variants} methods make {cells} cells a sequence; at most {MAX_CELLS} \
         are planned"
    );
    Err(source.error(span, message))
}
