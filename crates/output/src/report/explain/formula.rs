//! How metrics come about from counts, in a line.

use trackfail_methods::score::{Counts, Metric, Pooled, Protocol};

/// How a metric comes about, with the counts filled in.
pub fn formula(metric: Metric, counts: Counts, protocol: Option<&Protocol>) -> String {
    metric.filled(&Pooled { counts, chance: protocol.map(|p| p.chance), ..Pooled::default() })
}
