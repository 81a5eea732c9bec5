//! Time of the trackers with correlation filters on whole sequences of OTB, one thread; frames are decoded before.
//!
//! The sequences `otb/CarScale`, `otb/Woman` and `otb/FaceOcc1` are taken from the first folder of the path list
//! `TRACKFAIL_DATA` that has them; those that are nowhere are left out. `benches/peers/opencv_sequences.py` times OpenCV's
//! trackers on the same frames. A pass takes seconds, so that one is enough: a JSON line has its seconds and the success
//! AUC of its boxes, as the OTB toolkit computes it.

use std::path::PathBuf;
use std::time::Instant;
use trackfail::dataset::Sequence;
use trackfail::dataset::format::otb;
use trackfail::image::Frame;
use trackfail::plugin::Entry;
use trackfail::region::{Rect, Region};
use trackfail::score::success::RULES;
use trackfail::tracker::{RunContext, TrackerConfig, dsst, kcf, samf};

const SEQUENCES: [&str; 3] = ["CarScale", "Woman", "FaceOcc1"];
const TRACKERS: [(&str, &Entry<dyn TrackerConfig>); 3] =
    [("kcf", &kcf::ENTRY), ("dsst", &dsst::ENTRY), ("samf", &samf::ENTRY)];

/// A sequence, or nothing when its files are not here.
fn sequence(name: &str) -> Option<Sequence> {
    let roots = std::env::var_os("TRACKFAIL_DATA")?;
    let folders = std::env::split_paths(&roots).map(|root: PathBuf| root.join("otb").join(name));
    let folder = { folders }.find(|folder| folder.is_dir())?;
    Some(otb::load(&folder, &Default::default()).unwrap_or_else(|e| panic!("{e}")))
}

/// The box of each frame.
fn track(setup: &dyn TrackerConfig, sequence: &Sequence, frames: &[Frame]) -> Vec<Option<Rect>> {
    let context = RunContext { sequence, start_frame: 0, run: 0, seed: 1, data_roots: &[] };
    let first = sequence.truth[0].as_ref().expect("the first frame is annotated");
    let (mut tracker, state) = setup.start(&context, &frames[0], first).expect("it starts");
    let rest = frames[1..].iter().map(|f| tracker.update(f).expect("it goes on").region.rect());
    std::iter::once(state.region.rect()).chain(rest).map(Some).collect()
}

/// Names of the measurements that are possible here, and a pass of each that a name was asked for.
fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let list = arguments.iter().any(|a| a == "--list");
    let wanted = arguments.iter().find_map(|a| a.strip_prefix('^')?.strip_suffix('$'));
    for name in SEQUENCES {
        let Some(sequence) = sequence(name) else { continue };
        let asked = TRACKERS.map(|(kind, entry)| (format!("{kind}/{name}"), entry));
        let asked = asked.iter().filter(|(name, _)| wanted.is_none_or(|w| w == name));
        if list {
            asked.for_each(|(name, _)| println!("{name}: benchmark"));
            continue;
        }
        let frame = |t| sequence.frame(t).unwrap_or_else(|e| panic!("{e}"));
        let mut frames = Vec::new();
        for (name, entry) in asked {
            if frames.is_empty() {
                frames.extend((0..sequence.len()).map(frame));
            }
            let setup = entry.build_from_text("{}").expect("defaults are valid");
            let start = Instant::now();
            let boxes = track(&*setup, &sequence, &frames);
            let seconds = start.elapsed().as_secs_f64();
            let truth: Vec<_> = sequence.truth.iter().map(|t| t.as_ref().map(Region::rect)).collect();
            let auc = RULES[0].of_boxes(&boxes, &truth).auc();
            println!(r#"{{"bench": "{name}", "seconds": {seconds:.4}, "auc": {auc:.4}}}"#);
        }
    }
}
