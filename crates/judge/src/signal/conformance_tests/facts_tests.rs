//! Laws of the facts that signals give (direction, bounds, inputs), and of their parameters.

use super::{build, moments, response};
use crate::plugin::find;
use crate::region::{Rect, Region};
use crate::signal::{Direction, Reads, SIGNALS};
use crate::tracker::TrackerState;
use trackfail_testing::assert_says;

#[test]
fn every_signal_has_its_input_direction_and_bounds() {
    use Direction::{HigherIsBetter as High, LowerIsBetter as Low};
    use Reads::{Boxes, Companions, Confidence, Pixels, Posterior, Response};
    const MOST: f64 = f64::INFINITY;
    let expected = [
        ("box-motion", Boxes, Low, (0.0, 1000.0)),
        ("companion-overlap", Companions, High, (0.0, 1.0)),
        ("confidence", Confidence, High, (-MOST, MOST)),
        ("deep-verification", Pixels, Low, (-8.0, 8.0)),
        ("distribution-field", Pixels, High, (0.0, 0.0625)),
        ("effective-particles", Posterior, Low, (0.0, 1.0)),
        ("forward-backward", Pixels, Low, (0.0, 1.0)),
        ("object-color", Pixels, High, (-1.0, 1.0)),
        ("particle-entropy", Posterior, Low, (0.0, 1.0)),
        ("region-covariance", Pixels, Low, (0.0, MOST)),
        ("response-apce", Response, High, (0.0, MOST)),
        ("response-peak", Response, High, (-MOST, MOST)),
        ("response-psr", Response, High, (0.0, 1e6)),
        ("rgb-histogram", Pixels, High, (0.0, 1.0)),
        ("rgb-lbp-histogram", Pixels, High, (0.0, 1.0)),
        ("template-correlation", Pixels, High, (-1.0, 1.0)),
        ("uncertainty", Posterior, Low, (1e-12, MOST)),
        ("uncertainty-change", Posterior, Low, (0.0, MOST)),
        ("watchdog-agreement", Pixels, Low, (0.0, 1.0)),
    ];
    assert_eq!(SIGNALS.len(), expected.len());
    for (entry, (kind, reads, direction, bounds)) in SIGNALS.iter().zip(expected) {
        let signal = entry.build_from_text("{}").unwrap();
        let facts = signal.facts();
        assert_eq!((entry.kind, facts.reads, facts.direction), (kind, reads, direction));
        assert_eq!(facts.bounds, bounds, "{kind}");
    }
    for (kind, text, reads, direction, bounds) in [
        ("box-motion", "{ measure = \"border\" }", Pixels, High, (-1000.0, 1000.0)),
        ("box-motion", "{ measure = \"acceleration\" }", Boxes, Low, (0.0, 1000.0)),
        ("box-motion", "{ measure = \"scale\" }", Boxes, Low, (0.0, 1000.0)),
        ("box-motion", "{ measure = \"aspect\" }", Boxes, Low, (0.0, 1000.0)),
        ("companion-overlap", "{ companions = [{ tracker = \"kcf\" }] }", Pixels, High, (0.0, 1.0)),
        ("confidence", "{ scale = \"ratio\" }", Confidence, High, (-1000.0, 1000.0)),
        ("deep-verification", "{ here = [\"middle\", \"elsewhere\"] }", Pixels, High, (0.0, 1.0)),
        ("forward-backward", "{ measure = \"inliers\" }", Pixels, High, (0.0, 1.0)),
        ("particle-entropy", "{ good = \"high\" }", Posterior, High, (0.0, 1.0)),
        ("response-peak", "{ measure = \"second-peak\" }", Response, Low, (0.0, 1.0)),
        ("watchdog-agreement", "{ values = [\"overlap\", \"distance\"] }", Pixels, High, (0.0, 1.0)),
        ("watchdog-agreement", "{ values = [\"distance\"] }", Pixels, Low, (0.0, 3.0)),
    ] {
        let facts = build(kind, text).facts();
        assert_eq!((facts.reads, facts.direction, facts.bounds), (reads, direction, bounds), "{kind} {text}");
    }
}

#[test]
fn parameters_that_make_no_sense_are_refused() {
    for (kind, text, words) in [
        ("companion-overlap", "{ at_most = 0 }", "at_most"),
        ("confidence", "{ early = 0 }", "`early` must be"),
        ("confidence", "{ scale = \"ratio\", first = 1.0 }", "`first` must be"),
        ("confidence", "{ first = nan }", "`first` must be"),
        ("deep-verification", "{ here = [] }", "`here` must be"),
        ("deep-verification", "{ here = [\"score\", \"score\"] }", "`here` must be"),
        ("deep-verification", "{ v3 = [\"score\", \"score\"] }", "`v3` must be"),
        ("distribution-field", "{ support_u = 4 }", "odd"),
        ("forward-backward", "{ window = 4 }", "odd and from 3 to 63"),
        ("forward-backward", "{ window = 62 }", "odd and from 3 to 63"),
        ("rgb-lbp-histogram", "{ red_bins = 256, green_bins = 256, blue_bins = 8 }", "262144 bins"),
        ("uncertainty", "{ components = [] }", "`components` must be"),
        ("uncertainty", "{ components = [1, 0, 1] }", "`components` must be"),
        ("uncertainty-change", "{ components = [1, 1] }", "`components` must be"),
        ("watchdog-agreement", "{ values = [] }", "`values` must be"),
        ("watchdog-agreement", "{ values = [\"score\", \"score\"] }", "`values` must be"),
    ] {
        assert_says(find(SIGNALS, kind).unwrap().build_from_text(text).err().unwrap().message, words);
    }
    let kcf = "tracker = \"kcf\"";
    for (companions, words) in [
        ("[]", "a list with a companion"),
        ("\"others\"", "must be \"given\" or a list"),
        ("[{}]", "must be \"given\" or a list"),
        (&*format!("[{{ {kcf}, results = \"a\" }}]"), "must be \"given\" or a list"),
        ("[{ tracker = \"kfc\" }]", "did you mean `kcf`"),
        ("[{ tracker = \"still\" }]", "companion still: a companion must follow the target"),
        (&*format!("[{{ {kcf}, params = {{ padding = -1 }} }}]"), "companion kcf"),
        (&*format!("[{{ {kcf}, restart_margin = 2.0 }}]"), "restart_margin"),
        (&*format!("[{{ {kcf} }}], at_most = 2"), "at_most"),
    ] {
        let text = format!("{{ companions = {companions} }}");
        let refused = find(SIGNALS, "companion-overlap").unwrap().build_from_text(&text).err().unwrap();
        assert_says(refused.message, words);
    }
}

/// A state has what it was given, and the likelihood of a posterior stands for a confidence.
#[test]
fn an_input_is_in_the_states_that_have_it() {
    use Reads::{Boxes, Companions, Confidence, Pixels, Posterior, Response};
    let bare = TrackerState::tracked(Region::Rect(Rect::new(0.0, 0.0, 4.0, 4.0)));
    let with = |k: usize| match k {
        0 => bare.clone(),
        1 => TrackerState { posterior: Some(moments(1)), ..bare.clone() },
        2 => TrackerState { response: Some(response(1)), ..bare.clone() },
        _ => TrackerState { confidence: Some(0.5), ..bare.clone() },
    };
    for (reads, expected) in [
        (Pixels, [true; 4]),
        (Boxes, [true; 4]),
        (Companions, [true; 4]),
        (Posterior, [false, true, false, false]),
        (Response, [false, false, true, false]),
        (Confidence, [false, true, false, true]),
    ] {
        assert_eq!(std::array::from_fn::<bool, 4, _>(|k| reads.is_in(&with(k))), expected, "{reads:?}");
        let is_common = [Pixels, Boxes].contains(&reads);
        assert_eq!(reads.need_of_tracker().is_none(), is_common, "{reads:?}");
    }
}
