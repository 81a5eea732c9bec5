//! Scores: labels and ground truth in, counts and measures out. Pure functions.
//!
//! In the order in which they use each other:
//!
//! | module | does |
//! |---|---|
//! | [`overlap`] | gives the tracking error O_t |
//! | [`matching`] | pairs detections with events |
//! | [`counts`], [`chance`] | counts of protocols, and the counts expected of random detections |
//! | [`restarts`], `protocol` | treatment of restarts by protocols; rules under a versioned name |
//! | [`khalid2016`], [`sanmiguel2015`], [`segmentation`] | the exact rules of one paper each |
//! | [`frames`] | measures and protocols that judge a detector frame by frame |
//! | [`pooled`], [`metric`] | counts over a suite; the list of all metrics in tables |
//! | [`trajectory`], [`success`], [`average_overlap`], [`resets`], [`longterm`], [`oxuva`] | scores of trackers: OTB, GOT-10k, VOT, and with their confidence |
//! | [`tracker_metric`] | the list of the numbers of trackers |

pub mod average_overlap;
pub mod chance;
pub mod counts;
pub mod frames;
pub mod khalid2016;
pub mod longterm;
pub mod matching;
pub mod metric;
pub mod overlap;
pub mod oxuva;
pub mod pooled;
mod protocol;
pub mod resets;
pub mod restarts;
pub mod sanmiguel2015;
pub mod segmentation;
pub mod success;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
pub mod tracker_metric;
pub mod trajectory;

pub use counts::Counts;
pub use frames::FrameMeasures;
pub use metric::{METRICS, Metric};
pub use pooled::Pooled;
pub use protocol::{Protocol, TrackScore};
pub use restarts::Restarts;
pub use tracker_metric::{TRACKER_METRICS, TrackerMetric};

/// All protocols, by name.
pub static PROTOCOLS: &[Protocol] = &[
    khalid2016::PROTOCOL,
    khalid2016::NEW_TRACK,
    sanmiguel2015::SIGNED,
    sanmiguel2015::UNSIGNED,
    segmentation::PROTOCOL,
    frames::protocols::FRAMES,
    frames::protocols::FRAMES_CLEAR,
    frames::protocols::RANGE,
    frames::protocols::NAB,
];

/// Protocol of this name; `None` if it is unknown.
pub fn protocol(name: &str) -> Option<&'static Protocol> {
    PROTOCOLS.iter().find(|p| p.name == name)
}
