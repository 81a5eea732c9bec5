//! The page of `trackfail detect --report` in a real browser: strip, viewer, thumbnails, by mouse and by keyboard.

use crate::browser::{Browser, PICTURE_WIDTH, READOUT};
use crate::tools::{Place, needs};
use serde_json::json;

/// The page of a track on a rendered video that jumps away in frames 41 to 60, has no box in frames 81 to 90 and jumps
/// again.
fn page() -> Place {
    let place = Place::new();
    let truth = place.render("synthetic-otb", "Girl");
    let line = |(t, line): (usize, &String)| match t + 1 {
        41..=60 => "2,2,9,9".to_string(),
        81..=90 => "nan,nan,nan,nan".to_string(),
        _ => line.clone(),
    };
    let lines: Vec<String> = truth.iter().enumerate().map(line).collect();
    place.write("boxes.txt", lines.join("\n"));
    let detect = "detect --absent --boxes boxes.txt --report page.html --frames suite/Girl/img";
    place.run(&format!("{detect} --method Displacement --method CovF")).ends(0);
    // Nothing beside the page is needed.
    std::fs::remove_dir_all(place.path("suite")).unwrap();
    place
}

#[needs(chromium)]
#[test]
fn the_page_of_a_users_track_works_from_disk() {
    let place = page();
    let page = place.path("page.html");
    assert!(std::fs::metadata(&page).unwrap().len() < 3_000_000);
    let mut browser = Browser::start();
    let own = format!("file://{}", page.display());
    browser.on_all_screens("user-page", &page, &own, |browser, _| {
        browser.becomes(&format!("{READOUT}.startsWith('Frame ')"));
        works(browser);
    });
    browser.call("Emulation.setScriptExecutionDisabled", json!({"value": true}));
    browser.open(&page);
    let text = browser.text("document.body.innerText");
    assert!(text.contains("Lost since frame 41, 2 times in all") && text.contains("Displacement"), "{text}");
    assert!(!text.contains("one frame, with") && !text.contains("Show only"), "{text}");
}

fn works(browser: &mut Browser) {
    // It opens at the first loss, with its picture and the box of its state.
    assert_eq!(browser.frame(), 41);
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
    assert_eq!(browser.value(PICTURE_WIDTH), 160);

    // By keyboard: to the change after it, a frame back, to where there is no box, to the ends.
    browser.focus("document.querySelector('.strip')");
    browser.press("n");
    assert_eq!(browser.frame(), 51);
    assert_eq!(browser.text(boxes), "tracking");
    browser.press("ArrowLeft");
    assert_eq!((browser.frame(), browser.text(boxes)), (50, "lost".into()));
    browser.press("Home");
    assert_eq!(browser.frame(), 1);
    (0..84).for_each(|_| browser.press("ArrowRight"));
    assert_eq!((browser.frame(), browser.text(boxes)), (85, "absent".into()));
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
    let all = "[...document.querySelectorAll('#thumbnails button')].map(b => b.textContent).join(', ')";
    let thumbnails = browser.text(all);
    assert!(thumbnails.starts_with("1 tracking, 41 lost, 51 tracking"), "{thumbnails}");
    browser.click("document.querySelectorAll('#thumbnails button')[1]");
    assert_eq!(browser.frame(), 41);

    // By mouse: a place of the strip, another method.
    browser.click("document.getElementById('strip')");
    let middle = browser.frame();
    assert!(middle > 41, "{middle}");
    browser.click("document.querySelectorAll('#sequence-table tbody td')[4]");
    browser.becomes("document.getElementById('show-method').selectedOptions[0].text === 'CovF'");
    browser.click("document.querySelectorAll('#sequence-table tbody td')[3]");
    browser.becomes("document.getElementById('show-method').selectedOptions[0].text === 'Displacement'");
}
