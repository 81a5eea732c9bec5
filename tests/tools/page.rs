//! An experiment whose page has something of everything.

use super::trackfail;
use std::path::{Path, PathBuf};

const SPEC: &str = r#"
schema = 1
name = "mine/page"
title = "A page in a browser"
protocol = "khalid2016/1"
suites.test = "my-otb"
[[tracker]]
name = "still"
[[tracker]]
name = "still"
label = "still too"
[[method]]
name = "DTEF"
trackers = ["still"]
[[method]]
name = "hist"
signal.kind = "rgb-histogram"
detector = { kind = "level", below = 0.9 }
[[method]]
name = "oracle"
detector = { kind = "oracle" }
[[table]]
name = "t"
rows = ["recall", "precision", "events"]
columns = "method"
[[figure]]
name = "f"
kind = "strips"
stills = 3
panels = [["error"]]
[[claim]]
text = "The oracle finds all"
holds = "recall[oracle] == 1"
[[claim]]
text = "A threshold finds at most all"
holds = "recall[hist] <= 1"
[[claim]]
text = "A threshold finds more than all"
holds = "recall[hist] > 1"
"#;

/// The page of a run over sequences whose target goes back and forth, so that a tracker that stays where it is
/// loses it again and again.
pub fn page_of_a_run(root: &Path) -> PathBuf {
    for (name, frames, attributes) in [("Ant", 60, "OCC"), ("Bee", 90, "OCC,SV"), ("Cat", 75, "SV")] {
        let folder = root.join("d/otb").join(name);
        std::fs::create_dir_all(folder.join("img")).unwrap();
        let mut truth = String::new();
        for t in 0..frames {
            let x = 3 * 20_u32.abs_diff(t % 40);
            let image = image::RgbImage::from_fn(96, 48, |u, v| {
                let inside = (x..x + 16).contains(&u) && (10..26).contains(&v);
                image::Rgb([u as u8, 5 * v as u8, if inside { 255 } else { 0 }])
            });
            image.save(folder.join(format!("img/{:04}.png", t + 1))).unwrap();
            // Pixels count from 1.
            truth += &format!("{},11,16,16\n", x + 1);
        }
        std::fs::write(folder.join("groundtruth_rect.txt"), truth).unwrap();
        std::fs::write(folder.join("attributes.txt"), attributes).unwrap();
    }
    std::fs::write(root.join("a.toml"), SPEC).unwrap();
    for words in [&["data", "add", "my-otb", "otb", "--format", "otb"][..], &["run", "a.toml", "--quiet"]] {
        trackfail().current_dir(root).args(words).args(["--data-root", "d"]).assert().success();
    }
    root.join("reports/mine/page/index.html")
}
