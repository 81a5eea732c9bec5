//! `average-overlap`: the average overlap of trackers and their success rates at 0.5 and 0.75, as GOT-10k's toolkit has them.
//!
//! The measures, and which frames count, are in [`crate::score::average_overlap`]. The frames of all runs and
//! sequences have equal weights.
//!
//! Numbers: `ao`, `sr_50`, `sr_75`. Tables: `overall`, `sequences`.

use super::prelude::*;
use crate::score::average_overlap::{overlaps, rates};

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<AverageOverlap>(
    "average-overlap",
    1,
    "average overlap (AO) and success rates at .5 and .75 of trackers, as GOT-10k's toolkit computes them",
);

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct AverageOverlap {}

impl PlainParams for AverageOverlap {}

/// The numbers of the analysis, and the columns of its tables.
const NUMBERS: [TrackerMetric; 3] = [TrackerMetric::AO, TrackerMetric::SR_50, TrackerMetric::SR_75];

impl Analysis for AverageOverlap {
    fn reads(&self) -> Reads {
        Reads::Regions
    }

    fn layout(&self, _: usize) -> Layout {
        Layout::of_trackers(&NUMBERS).measures("sequences", "sequence", &NUMBERS)
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let of_sequences = populations[0].trajectories.chunk_by(|a, b| a.sequence == b.sequence);
        let sequences: Vec<(&str, Vec<f64>)> =
            of_sequences.map(|runs| (runs[0].sequence, runs.iter().flat_map(overlaps).collect())).collect();
        let all: Vec<f64> = sequences.iter().flat_map(|(_, overlaps)| overlaps).copied().collect();
        let mut values = Values::of_tracker(&rates(&all));
        if values.numbers.contains(&None) {
            return Err(AnalysisError::NoTrack);
        }
        let rows = sequences.iter().map(|(name, overlaps)| (name.to_string(), rates(overlaps).to_vec()));
        values.tables.push(rows.collect());
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_core::region::Rect;

    // By hand: one frame with overlap 1 in the first sequence, six with 1/2 in the two runs of the second: (1 + 3) / 7.
    #[test]
    fn frames_of_all_sequences_weigh_alike() {
        let rect = |h: f64| Region::Rect(Rect::new(5.0, 5.0, 10.0, h));
        let (whole, halves) = ([rect(10.0), rect(10.0)], [rect(10.0), rect(5.0), rect(5.0), rect(5.0)]);
        let truth = vec![Some(rect(10.0)); 4];
        let status = [Status::Initialized, Status::Tracked, Status::Tracked, Status::Tracked];
        let trajectory = |sequence, run, frames: usize, regions| Trajectory {
            sequence,
            run,
            regions,
            status: &status[..frames],
            truth: &truth[..frames],
            ..Trajectory::default()
        };
        let trajectories = vec![
            trajectory("a", 0, 2, &whole[..]),
            trajectory("b", 0, 4, &halves[..]),
            trajectory("b", 1, 4, &halves[..]),
        ];
        let population = Population { suite: "s", tracks: vec![], trajectories, timings: vec![] };
        let found = ENTRY.build_from_text("{}").unwrap().analyze(&[population]).unwrap();
        let number = |name: &str| found.number(name).unwrap();
        assert_eq!((number("ao"), number("sr_50"), number("sr_75")), (4.0 / 7.0, 1.0 / 7.0, 1.0 / 7.0));
        assert_eq!(found.tables[1].rows[1], ("b".to_string(), vec![Some(0.5), Some(0.0), Some(0.0)]));
        assert!(ENTRY.build_from_text("{ more = 1 }").is_err());
    }
}
