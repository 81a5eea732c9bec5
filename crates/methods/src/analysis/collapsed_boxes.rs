//! `collapsed-boxes`: frames in which a tracker's box has shrunk to a few pixels while the target has not.
//! Signals that read the pixels of such a box see almost nothing of the target, so an alarm there is about
//! the box and not about the target.
//!
//! ```text
//! collapsed in t:  min(w_t, h_t) < side  and  min(w*_t, h*_t) >= 2 side
//! ```
//!
//! `w`, `h` are the sides of the upright rectangle that stands for the tracker's region in pixels, `w*`, `h*`
//! those of the ground truth; frames without ground truth do not count. Few such frames are good. The table
//! `sequences` has a row for each sequence with such a frame; the runs of a sequence are counted together.
//! Our choice: the target must have at least twice the side, so that the box of a small target is not called
//! collapsed.

use super::prelude::*;

pub(crate) const ENTRY: Entry<dyn Analysis> = Entry::of::<Params>(
    "collapsed-boxes",
    1,
    "frames in which the tracker's box has shrunk to a few pixels and the target has not",
)
.example("{ side = 4.0 }");

#[derive(Debug, Clone, SmartDefault, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Side below which a box has collapsed, in pixels, above 0 and at most 1000.
    #[default(4.0)]
    pub side: f64,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::of("side").above(0.0).at_most(1000.0)];
}

impl Params {
    /// Number of collapsed frames, and number of frames with ground truth.
    fn count(&self, track: &Trajectory<'_>) -> [usize; 2] {
        let shorter = |region: &Region| {
            let rect = region.rect();
            rect.w.min(rect.h)
        };
        let known = track.regions.iter().zip(track.truth).filter_map(|(r, truth)| Some((r, truth.as_ref()?)));
        let is_collapsed = |(region, truth): &(&Region, &Region)| {
            shorter(region) < self.side && shorter(truth) >= 2.0 * self.side
        };
        [known.clone().filter(is_collapsed).count(), known.count()]
    }
}

impl Analysis for Params {
    fn reads(&self) -> Reads {
        Reads::Regions
    }

    fn layout(&self, _: usize) -> Layout {
        Layout::of(["collapsed", "frames"])
            .table("overall", "tracker", ["collapsed frames", "frames", "sequences"])
            .table("collapsed-sequences", "sequence", ["collapsed frames", "frames"])
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let of_sequences = populations[0].trajectories.chunk_by(|a, b| a.sequence == b.sequence);
        let sequences = of_sequences.map(|runs| {
            let counts = runs.iter().map(|track| self.count(track));
            (runs[0].sequence, counts.fold([0; 2], |sum, count| [sum[0] + count[0], sum[1] + count[1]]))
        });
        let sequences: Vec<(&str, [usize; 2])> = sequences.collect();
        let all = [0, 1].map(|k| sequences.iter().map(|(_, counts)| counts[k]).sum::<usize>() as f64);
        if all[1] == 0.0 {
            return Err(AnalysisError::NoTrack);
        }
        let hit = sequences.iter().filter(|(_, counts)| counts[0] > 0);
        let rows = hit.map(|(name, counts)| (name.to_string(), counts.map(|n| Some(n as f64)).to_vec()));
        let rows: Vec<Row> = rows.collect();
        let overall = [all[0], all[1], rows.len() as f64].map(Some).to_vec();
        Ok(Values {
            numbers: all.map(Some).to_vec(),
            tables: vec![vec![(String::new(), overall)], rows],
            ..Values::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_core::region::Rect;

    // By hand with sides below 4: a box of 3 x 9 on a target of 10 x 10 has collapsed, on one of 7 x 10 it has not, and a frame
    // without truth does not count.
    #[test]
    fn frames_by_hand() {
        let rect = |w: f64, h: f64| Region::Rect(Rect::new(1.0, 1.0, w, h));
        let regions = [rect(10.0, 10.0), rect(3.0, 9.0), rect(3.0, 9.0), rect(1.0, 1.0)];
        let truth = [Some(rect(10.0, 10.0)), Some(rect(10.0, 10.0)), Some(rect(7.0, 10.0)), None];
        let track = Trajectory {
            sequence: "a",
            regions: &regions,
            status: &[Status::Tracked; 4],
            truth: &truth,
            ..Trajectory::default()
        };
        let population =
            Population { suite: "s", tracks: vec![], trajectories: vec![track, track], timings: vec![] };
        let analysis = ENTRY.build_from_text("{}").unwrap();
        let found = analysis.analyze(&[population]).unwrap();
        assert_eq!(found.numbers, [("collapsed".to_string(), 2.0), ("frames".to_string(), 6.0)]);
        assert_eq!(found.tables[1].rows, [("a".to_string(), vec![Some(2.0), Some(6.0)])]);
        assert!(ENTRY.build_from_text("{ side = 0.0 }").is_err());
    }
}
