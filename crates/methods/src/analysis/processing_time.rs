//! `processing-time`: the time that detection takes on a track, split by stage, for methods side by side (SanMiguel and
//! Cavallaro, CVIU 131, 2015, Table 5).
//!
//! | stage | what is timed |
//! |---|---|
//! | `signal` | the signal that the method reads, from the tracker's answers |
//! | `detection` | the detector, without its runs of the tracker |
//! | `reverse tracking` | the tracker run backwards |
//! | `total` | the three together |
//! | `tracking` | the tracker itself, the same for all methods; not in the total |
//!
//! All times are milliseconds per frame of the sequence, on one thread: medians over `repeats` passes over
//! all tracks. Frames are decoded before the clock starts. The time of a reverse run is what a program needs
//! that detects while it tracks: the time to bring the tracker to the start of the reverse run is not
//! counted. `ratio` is the median over the repeats of the last method's total over the first one's.
//!
//! These are the only results that depend on a clock: they differ from run to run and are never stored. `reverse
//! runs` and `reverse frames` beside them are counts per 1000 frames, which do not differ.

use super::prelude::*;
use trackfail_core::num::summary;

/// `processing-time` in the list of analyses.
pub const ENTRY: Entry<dyn Analysis> =
    Entry::of::<Params>("processing-time", 1, "milliseconds a frame that methods cost, by stage")
        .example("{ methods = [\"ARTE\", \"ARTE*\"] }");

/// Parameters of `processing-time`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Names of methods in the experiment, each at most once; methods with a grid are refused.
    pub methods: Vec<String>,
    /// Number of repeats, 1 to 1000.
    #[serde(default = "five")]
    pub repeats: usize,
}

fn five() -> usize {
    5
}

/// Time of one method on one track, in seconds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spent {
    /// Time of the signal.
    pub signal: f64,
    /// Time of the detector without the reverse runs of the tracker.
    pub detection: f64,
    /// Time of the reverse runs.
    pub reverse: f64,
    /// Number of reverse runs.
    pub runs: u64,
    /// Number of frames in all reverse runs.
    pub frames: u64,
}

/// Times of one pass over one track.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Timing {
    /// Index of the repeat, from 0.
    pub repeat: usize,
    /// Number of frames of the track.
    pub frames: usize,
    /// Time of the tracker, in seconds.
    pub tracking: f64,
    /// Times of the methods, in the order of the parameter `methods`.
    pub methods: Vec<Spent>,
}

impl PlainParams for Params {
    const RANGES: &'static [Range] = &[Range::within("repeats", 1.0, 1000.0)];

    fn check(&self) -> Result<(), ParamError> {
        let repeated = self.methods.iter().enumerate().any(|(k, m)| self.methods[..k].contains(m));
        let is_fine = (1..=20).contains(&self.methods.len()) && !repeated;
        ParamError::unless(is_fine, "methods", "1 to 20 different methods", format!("{:?}", self.methods))
    }
}

/// Median; `values` must not be empty.
fn median(mut values: Vec<f64>) -> f64 {
    summary::median(&mut values).unwrap_or_default()
}

impl Analysis for Params {
    fn reads(&self) -> Reads {
        Reads::Clock
    }

    fn timed(&self) -> (&[String], usize) {
        (&self.methods, self.repeats)
    }

    fn layout(&self, _: usize) -> Layout {
        let corner = "milliseconds a frame; runs per 1000";
        Layout::of(["ratio", "reverse-runs-ratio"]).table("stages", corner, self.methods.clone())
    }

    fn values(&self, populations: &[Population<'_>]) -> Result<Values, AnalysisError> {
        let timings = &populations[0].timings;
        let methods = self.methods.len();
        if timings.is_empty() || timings.iter().any(|t| t.methods.len() != methods) {
            return Err(AnalysisError::NotTimed);
        }
        // Sums over the tracks of each repeat, in milliseconds a frame.
        let a_frame = |seconds: &dyn Fn(&Timing) -> f64| -> Vec<f64> {
            let of_repeat = |repeat: usize| {
                let mine = || timings.iter().filter(|t| t.repeat == repeat);
                let frames: usize = mine().map(|t| t.frames).sum();
                1000.0 * mine().map(seconds).sum::<f64>() / frames.max(1) as f64
            };
            (0..self.repeats).filter(|r| timings.iter().any(|t| t.repeat == *r)).map(of_repeat).collect()
        };
        let total =
            |m: usize| a_frame(&|t| t.methods[m].signal + t.methods[m].detection + t.methods[m].reverse);
        let row = |name: &str, of: &dyn Fn(usize) -> f64| {
            (name.to_string(), (0..methods).map(|m| Some(of(m))).collect::<Vec<_>>())
        };
        let median_of = |of: fn(&Spent) -> f64| move |m: usize| median(a_frame(&|t| of(&t.methods[m])));
        let runs = median_of(|s| s.runs as f64);
        let rows = vec![
            row("signal", &median_of(|s| s.signal)),
            row("detection", &median_of(|s| s.detection)),
            row("reverse tracking", &median_of(|s| s.reverse)),
            row("total", &|m| median(total(m))),
            row("tracking", &|_| median(a_frame(&|t| t.tracking))),
            row("reverse runs", &runs),
            row("reverse frames", &median_of(|s| s.frames as f64)),
        ];
        let ratios = total(0).iter().zip(total(methods - 1)).map(|(first, last)| last / first).collect();
        let of_runs = (runs(0) > 0.0).then(|| runs(methods - 1) / runs(0));
        let numbers = vec![Some(median(ratios)), of_runs];
        Ok(Values { numbers, tables: vec![rows], ..Values::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trackfail_testing::{assert_near, assert_says};

    // By hand: two tracks of 100 and 300 frames, three repeats; 0.4 s in 400 frames are 1 ms a frame.
    #[test]
    fn medians_over_repeats_of_sums_over_tracks() {
        let timing = |repeat: usize, frames: usize, slow: f64| {
            let time = slow * frames as f64 / 400.0;
            let spent = |reverse: f64, runs: u64| Spent {
                signal: 0.2 * time,
                detection: 0.1,
                reverse,
                runs,
                frames: 40 * runs,
            };
            let methods = vec![spent(0.4 * slow, 2), spent(0.0, 1)];
            Timing { repeat, frames, tracking: 2.0 * time, methods }
        };
        let repeats = [1.0, 3.0, 2.0].into_iter().enumerate();
        let timings =
            repeats.flat_map(|(n, slow)| [100, 300].map(|frames| timing(n, frames, slow))).collect();
        let analysis = ENTRY.build_from_text(ENTRY.example).unwrap();
        let population = Population { suite: "s", tracks: vec![], trajectories: vec![], timings };
        let found = analysis.analyze(&[population]).unwrap();
        let close = |name: &str, expected: [f64; 2]| {
            let row = &found.tables[0].rows.iter().find(|row| row.0 == name).unwrap().1;
            assert_near(row.iter().map(|value| value.unwrap()), expected, 1e-12, name);
        };
        // The median repeat is the one with `slow` 2: .4 s, .2 s, 1.6 s and 0 s in 400 frames.
        close("signal", [1.0, 1.0]);
        close("detection", [0.5, 0.5]);
        close("reverse tracking", [4.0, 0.0]);
        close("total", [5.5, 1.5]);
        close("tracking", [10.0, 10.0]);
        close("reverse runs", [10.0, 5.0]);
        close("reverse frames", [400.0, 200.0]);
        // Totals are (.2 + .8) slow + .2 and .2 slow + .2: .4/1.2, .8/3.2 and .6/2.2, of which the last is the
        // median.
        let ratios = ["ratio", "reverse-runs-ratio"].map(|name| found.number(name).unwrap());
        assert_near(ratios, [0.6 / 2.2, 0.5], 1e-12, "");
    }

    #[test]
    fn parameters_are_checked() {
        for (text, key) in [
            ("{ methods = [] }", "methods"),
            ("{ methods = [\"A\", \"A\"] }", "methods"),
            ("{ methods = [\"A\"], repeats = 0 }", "repeats"),
        ] {
            assert_says(ENTRY.build_from_text(text).err().unwrap(), key);
        }
        assert!(median(vec![3.0, 1.0, 2.0]) == 2.0 && median(vec![4.0, 1.0]) == 2.5);
    }
}
