//! The page of `trackfail detect --report` in a real browser: strip, viewer, thumbnails, by mouse and by keyboard.

use crate::browser::Browser;
use crate::tools::{needs, trackfail};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The page of a track on a rendered video that jumps away in frames 41 to 60, has no box in frames 81 to 90 and jumps
/// again.
fn page(root: &Path, more: &[&str]) -> PathBuf {
    let suite = root.join("suite");
    trackfail()
        .args(["data", "render", "synthetic-otb", "--sequence", "Girl"])
        .arg(&suite)
        .assert()
        .success();
    let truth = std::fs::read_to_string(suite.join("Girl/groundtruth_rect.txt")).unwrap();
    let line = |(t, line): (usize, &str)| match t + 1 {
        41..=60 => "2,2,9,9".to_string(),
        81..=90 => "nan,nan,nan,nan".to_string(),
        _ => line.to_string(),
    };
    let lines: Vec<String> = truth.lines().enumerate().map(line).collect();
    let (boxes, page) = (root.join("boxes.txt"), root.join("page.html"));
    std::fs::write(&boxes, lines.join("\n")).unwrap();
    let mut command = trackfail();
    command.args(["detect", "--absent", "--boxes"]).arg(&boxes).arg("--report").arg(&page).args(more);
    command.arg("--frames").arg(suite.join("Girl/img")).assert().success();
    // Nothing beside the page is needed.
    std::fs::remove_dir_all(&suite).unwrap();
    page
}

const READOUT: &str = "document.getElementById('readout').textContent";
const METHODS: [&str; 4] = ["--method", "Displacement", "--method", "CovF"];

fn frame(browser: &mut Browser) -> i64 {
    let text = browser.text(READOUT);
    text.split(' ').nth(1).and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{text}"))
}

#[needs(chromium)]
#[test]
fn the_page_of_a_users_track_works_from_disk() {
    let root = tempfile::tempdir().unwrap();
    let page = page(root.path(), &METHODS);
    assert!(std::fs::metadata(&page).unwrap().len() < 3_000_000);
    let mut browser = Browser::start();
    let own = format!("file://{}", page.display());
    for (width, dark) in [(1400, false), (1400, true), (390, false), (390, true)] {
        browser.screen(width, 900, dark);
        browser.open(&page);
        browser.becomes(&format!("{READOUT}.startsWith('Frame ')"));
        let widths = browser.value("[document.documentElement.scrollWidth, innerWidth]");
        assert!(widths[0].as_i64() <= widths[1].as_i64(), "{widths}");
        works(&mut browser);
        assert_eq!(browser.complaints(|url| url == own), Vec::<String>::new());
        browser.picture(&format!("user-page-{width}-{}", if dark { "dark" } else { "light" }));
    }
    browser.call("Emulation.setScriptExecutionDisabled", json!({"value": true}));
    browser.open(&page);
    let text = browser.text("document.body.innerText");
    assert!(
        text.contains("Lost since frame 41, 2 times in all; not surely found again.")
            && text.contains("Displacement"),
        "{text}"
    );
    assert!(!text.contains("one frame, with") && !text.contains("Show only"), "{text}");
}

fn works(browser: &mut Browser) {
    // It opens at the first loss, with its picture and the box of its state.
    assert_eq!(frame(browser), 41);
    assert!(browser.text(READOUT).contains(" · lost · score "));
    let text = browser.text("document.body.innerText");
    for words in ["Lost since frame 41, 2 times in all; not surely found again.", "Losses", "Frame by frame"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    for words in ["tracking error", "false alarm", "ground truth", "hit", "Show only", "sum of rows"] {
        assert!(!text.contains(words), "{words}: {text}");
    }
    let boxes = "[...document.querySelectorAll('#stage .box')].map(b => b.classList[1]).join(' ')";
    assert_eq!(browser.text(boxes), "lost");
    let width = "(async () => { const i = new Image(); i.src = document.querySelector('#stage image').href.baseVal; await i.decode(); return i.width; })()";
    assert_eq!(browser.value(width), 160);

    // By keyboard: to the change after it, a frame back, to where there is no box, to the ends.
    browser.value("document.querySelector('.strip').focus()");
    browser.press("n");
    assert_eq!(frame(browser), 51);
    assert_eq!(browser.text(boxes), "tracking");
    browser.press("ArrowLeft");
    assert_eq!((frame(browser), browser.text(boxes)), (50, "lost".into()));
    browser.press("Home");
    assert_eq!(frame(browser), 1);
    for _ in 0..84 {
        browser.press("ArrowRight");
    }
    assert_eq!((frame(browser), browser.text(boxes)), (85, "absent".into()));
    assert!(browser.text(READOUT).contains(" · absent · "));

    // Shades, marks and thumbnails are those of the method that is shown.
    let count = |selector: &str| format!("document.querySelectorAll('{selector}').length");
    let losses = browser.value(&count("#strip rect.lost")).as_i64().unwrap();
    assert!(losses >= 1 && browser.value(&count("#strip rect.absent")) == 1);
    let marks = browser.value(&count("#strip .jump")).as_i64().unwrap();
    let listed = browser.value(&count("#marks button")).as_i64().unwrap();
    assert!(marks == listed && marks >= 2, "{marks} {listed}");
    let told = "document.querySelector('#sequence-table tr.open').cells[4].textContent";
    assert_eq!(browser.text(told), losses.to_string());
    let thumbnails =
        "[...document.querySelectorAll('#thumbnails button')].map(b => b.textContent).join(', ')";
    let thumbnails = browser.text(thumbnails);
    assert!(thumbnails.starts_with("1 tracking, 41 lost, 51 tracking"), "{thumbnails}");
    browser.click("document.querySelectorAll('#thumbnails button')[1]", 0.5);
    assert_eq!(frame(browser), 41);

    // By mouse: a place of the strip, another method.
    browser.click("document.getElementById('strip')", 0.5);
    let middle = frame(browser);
    assert!(middle > 41, "{middle}");
    browser.click("document.querySelectorAll('#sequence-table tbody td')[4]", 0.5);
    browser.becomes("document.getElementById('show-method').selectedOptions[0].text === 'CovF'");
    browser.click("document.querySelectorAll('#sequence-table tbody td')[3]", 0.5);
    browser.becomes("document.getElementById('show-method').selectedOptions[0].text === 'Displacement'");
}
