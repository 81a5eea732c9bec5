//! An experiment whose page has something of everything.

use super::{Place, experiment};

const SPEC: &str = r#"
tracker = [{ name = "still" }, { name = "still", label = "still too" }]
method = [
    { name = "DTEF", trackers = ["still"] },
    { name = "hist", signal.kind = "rgb-histogram", detector = { kind = "level", below = 0.9 } },
    { name = "oracle", detector = { kind = "oracle" } },
]
table = [{ name = "t", rows = ["recall", "precision", "events"], columns = "method" }]
figure = [{ name = "f", kind = "strips", stills = 3, panels = [["error"]] }]
claim = [
    { text = "The oracle finds all", holds = "recall[oracle] == 1" },
    { text = "A threshold finds at most all", holds = "recall[hist] <= 1" },
    { text = "A threshold finds more than all", holds = "recall[hist] > 1" },
]
"#;

/// The page of a run over sequences whose target goes back and forth, so that a tracker that stays where it is
/// loses it again and again: `reports/mine/page/index.html`.
pub fn page_of_a_run() -> Place {
    let place = Place::with(&[("a.toml", &experiment("mine/page", "my-otb", SPEC))]);
    for (name, frames, attributes) in [("Ant", 60, "OCC"), ("Bee", 90, "OCC,SV"), ("Cat", 75, "SV")] {
        let folder = format!("d/otb/{name}");
        let left = |t: u32| 3 * 20_u32.abs_diff(t % 40);
        place.frames(&format!("{folder}/img/0000.png"), frames, (96, 48), |t, x, y| {
            let inside = (left(t)..left(t) + 16).contains(&x) && (10..26).contains(&y);
            [x as u8, 5 * y as u8, if inside { 255 } else { 0 }]
        });
        // Pixels count from 1.
        let truth: String = (0..frames).map(|t| format!("{},11,16,16\n", left(t) + 1)).collect();
        place.write(&format!("{folder}/groundtruth_rect.txt"), truth);
        place.write(&format!("{folder}/attributes.txt"), attributes);
    }
    place.run("data add my-otb otb --format otb --data-root d").ends(0);
    place.run("run a.toml --quiet --data-root d").ends(0);
    place
}
