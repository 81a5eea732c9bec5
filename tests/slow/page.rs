//! The page of an experiment in a real browser: sorting, filters, strips and viewer, from disk, by mouse and
//! by keyboard, on a desk and on a phone, light and dark.

use crate::browser::{Browser, PICTURE_WIDTH, READOUT};
use crate::tools::page::page_of_a_run;
use crate::tools::{Place, needs};
use serde_json::json;
use trackfail::region::{Rect, Region};
use trackfail::report::sequences::json::{Said, beside, embedded};
use trackfail::report::sequences::{Method, Sequence, Sequences, Track};
use trackfail::report::{FigureView, Page, render};
use trackfail::results::{MethodSeries, TrackSeries};
use trackfail::score::protocol;
use trackfail_testing::{assert_says, hostile};

/// Scores of a tracker that loses its target in frames 20 to 29 of 60, and of a method that says so.
fn series(names: [&str; 2]) -> Sequences {
    let frames = 60;
    let lost = |t: usize| (20..30).contains(&t);
    let series = TrackSeries {
        rects: (0..frames).map(|t| Rect::new(t as f64, 10.0, 20.0, 30.0)).collect(),
        error: (0..frames).map(|t| if lost(t) { 1.0 } else { 0.25 }).collect(),
        ..TrackSeries::default()
    };
    let said = |from: usize| {
        let alarm: Vec<bool> = (0..frames).map(|t| (from..from + 10).contains(&t) || t == 55).collect();
        let score = alarm.iter().map(|a| if *a { 0.0051 } else { 0.0032 }).collect();
        let method = MethodSeries { score, alarm, changes: vec![0; frames], ..MethodSeries::default() };
        let judged = series.judge(protocol("khalid2016/1").unwrap(), &method.alarm, &method.changes);
        Said::new(&series, &method, &judged, Some(0.004))
    };
    let truth =
        (0..frames).map(|t| Some(Region::Rect(Rect::new(t as f64 + 2.5, 12.0, 20.0, 30.0)))).collect();
    let sequence = |name: &str| Sequence {
        name: name.into(),
        first: 1,
        size: Some((160, 120)),
        attributes: vec![names[0].into(), name.into()],
        truth: Vec::clone(&truth),
        ..Sequence::default()
    };
    let method =
        |name: &str| Method { name: name.into(), thresholds: vec![Some(0.004); 2], counted: name.into() };
    let track = |sequence, tracker| {
        let said = [(0, said(22)), (1, said(40))];
        Track::new([sequence, tracker], &series, &series.rects, said.into_iter().collect())
    };
    Sequences {
        trackers: names.map(String::from).into(),
        methods: names.map(method).into(),
        sequences: names.map(sequence).into(),
        tracks: vec![track(0, 0), track(0, 1), track(1, 0), track(1, 1)],
        ..Sequences::default()
    }
}

const VERDICTS: &str = "1 holds · 0 undecided · 1 does not hold";

const SHOWN: &str = "document.querySelectorAll('#sequence-table tbody tr:not([hidden])').length";

fn choose(browser: &mut Browser, id: &str, text: &str) {
    let text = serde_json::to_string(text).unwrap();
    browser.value(&format!(
        "(() => {{ const e = document.getElementById('{id}'); \
         e.value = e.options ? [...e.options].find(o => o.text === {text}).value : {text}; \
         e.dispatchEvent(new Event(e.options ? 'change' : 'input')); }})()"
    ));
}

#[needs(chromium)]
#[test]
fn a_page_works_from_disk() {
    let mut browser = Browser::start();
    let place = page_of_a_run();
    let page = place.path("reports/mine/page/index.html");
    let own = format!("file://{}", page.parent().unwrap().display());
    browser.on_all_screens("page", &page, &own, |browser, dark| {
        browser.becomes(&format!("{READOUT}.startsWith('Frame ')"));
        let ground = browser.text("getComputedStyle(document.body).backgroundColor");
        assert_eq!(ground, if dark { "rgb(22, 22, 24)" } else { "rgb(255, 255, 255)" });
        assert_eq!(browser.text(FAINT), "");
        works(browser);
        assert_eq!(browser.text(FAINT), "");
    });
    // All numbers are there without JavaScript, and nothing that does not work.
    browser.call("Emulation.setScriptExecutionDisabled", json!({"value": true}));
    browser.open(&page);
    let text = browser.text("document.body.innerText");
    assert_says(&text, "sum of rows shown");
    assert_says(&text, VERDICTS);
    // The target of a number's link is there as well, and the command that explains the number is in its title.
    let link = "document.querySelector('a.origin')";
    assert_eq!(browser.value(&format!("document.querySelector({link}.hash).id === 'sequences'")), true);
    assert!(browser.text(&format!("{link}.title")).contains("trackfail explain mine/page/t recall "));
    assert!(!text.contains("Show only") && !text.contains("one frame, with") && !text.contains("↕"));
    browser.picture("page-without-javascript");
}

fn works(browser: &mut Browser) {
    assert_says(browser.text("document.querySelector('.verdicts').innerText"), VERDICTS);
    headings_sort(browser);
    number_leads_to_its_sequences(browser);
    folded_table_opens(browser);
    filters_hide_rows(browser);
    viewer_moves(browser);
    marks_are_the_counts(browser);
    picture_is_shown(browser);
    link_leads_to_a_frame(browser);
    it_plays(browser);
}

/// The link of a frame opens it, by names; one to what is not there changes nothing.
fn link_leads_to_a_frame(browser: &mut Browser) {
    browser.value("location.hash = '#sequence=Bee&tracker=still+too&method=hist&frame=33'");
    browser.becomes(&format!("{READOUT}.startsWith('Frame 33 ')"));
    let chosen = "['show-sequence', 'show-tracker', 'show-method'].map(id => { \
                  const e = document.getElementById(id); return e.options[e.selectedIndex].text; }).join(' / ')";
    assert_eq!(browser.text(chosen), "Bee / still too / hist");
    let link = "document.getElementById('link').hash";
    assert_eq!(browser.text(link), "#sequence=Bee&tracker=still+too&method=hist&frame=33");
    browser.focus("document.querySelector('.strip')");
    browser.press("ArrowRight");
    assert!(browser.text(link).ends_with("frame=34"), "{}", browser.text(link));
    browser.value("location.hash = '#sequence=Nobody&frame=2'");
    assert_eq!(browser.text(chosen), "Bee / still too / hist");
    browser.value("location.hash = ''");
}

/// Playing goes on by itself to the end and stops there.
fn it_plays(browser: &mut Browser) {
    let before = browser.frame();
    let button = "document.getElementById('play')";
    choose(browser, "speed", "60 frames/s");
    browser.click(button);
    browser.becomes(&format!("Number({READOUT}.split(' ')[1]) > {before}"));
    assert_eq!(browser.text(&format!("{button}.ariaPressed")), "true");
    browser.becomes(&format!("{button}.ariaPressed === 'false'"));
    assert_eq!(browser.frame(), 90);
}

/// Sorting by keyboard: largest first, smallest first, the first order.
fn headings_sort(browser: &mut Browser) {
    let labels = "[...document.querySelectorAll('#sequence-table tbody tr')].map(r => r.cells[2].textContent).join(' ')";
    let as_it_was = browser.text(labels);
    let mut counts: Vec<usize> = as_it_was.split(' ').map(|n| n.parse().unwrap()).collect();
    counts.sort_unstable();
    let joined = |all: &[usize]| all.iter().map(usize::to_string).collect::<Vec<_>>().join(" ");
    let head = "document.querySelector('#sequence-table thead th:nth-child(3)')";
    browser.focus(&format!("{head}.querySelector('button')"));
    let order = &format!("{head}.ariaSort");
    browser.press("Enter");
    assert_eq!(browser.text(order), "descending");
    assert_eq!(browser.text(labels), joined(&counts.iter().rev().copied().collect::<Vec<_>>()));
    browser.press("Enter");
    assert_eq!((browser.text(order), browser.text(labels)), ("ascending".into(), joined(&counts)));
    browser.press("Enter");
    assert_eq!((browser.value(order).is_null(), browser.text(labels)), (true, as_it_was));
    // A row's heading sorts the columns; the first row is a recall.
    let heads =
        "[...document.querySelectorAll('table.both thead th')].map(t => t.innerText.split(' ')[0]).join(' ')";
    let before = browser.text(heads);
    let row = "document.querySelector('table.both tbody tr:not(:has(.group))')";
    let values =
        format!("[...{row}.cells].slice(1).map(c => c.dataset.v === undefined ? -1 : Number(c.dataset.v))");
    let button = format!("{row}.querySelector('th button')");
    for (order, sign) in [("descending", ">="), ("ascending", "<=")] {
        browser.click(&button);
        assert_eq!(browser.text(&format!("{row}.cells[0].ariaSort")), order);
        let is_sorted = format!("{values}.every((v, k, all) => k === 0 || all[k - 1] {sign} v)");
        assert_eq!(browser.value(&is_sorted), true);
    }
    browser.click(&button);
    assert_eq!(browser.text(heads), before);
}

/// A folded table opens when a link leads to it.
fn folded_table_opens(browser: &mut Browser) {
    let last = "[...document.querySelectorAll('details.table')].at(-1)";
    browser.value(&format!("{last}.open = false"));
    browser.click("document.querySelector('.contents li:last-child a')");
    assert_eq!(browser.value(&format!("{last}.open")), true);
}

/// Filters of the table of sequences, and the button that clears them.
fn filters_hide_rows(browser: &mut Browser) {
    let all = browser.value(SHOWN).as_u64().unwrap();
    choose(browser, "by-tracker", "still too");
    assert_eq!(browser.value(SHOWN), all / 2);
    choose(browser, "by-method", "DTEF");
    assert_eq!(browser.value(SHOWN), 0);
    choose(browser, "by-tracker", "all");
    assert_eq!(browser.value(SHOWN), all / 2);
    let shown =
        "[...document.querySelector('#sequence-table thead').rows[0].cells].filter(c => !c.hidden).length";
    assert_eq!(browser.value(shown), 5);
    let attribute = browser.text("document.querySelector('#by-attribute').options[1].text");
    choose(browser, "by-attribute", &attribute);
    let listed = format!(
        "[...document.querySelectorAll('#sequence-table tbody tr:not([hidden])')]\
         .every(r => r.cells[3].textContent.split(', ').includes('{attribute}'))"
    );
    assert!(browser.value(&listed) == true && browser.value(SHOWN).as_u64().unwrap() > 0);
    choose(browser, "by-sequence", "no such name");
    assert_eq!(browser.value(SHOWN), 0);
    browser.click("document.getElementById('clear')");
    assert_eq!(browser.value(SHOWN), all);
}

/// The viewer by keyboard, then by mouse: a mark of the strip, a place of the strip, an entry of the list.
fn viewer_moves(browser: &mut Browser) {
    choose(browser, "show-method", "hist");
    browser.becomes(&format!("{READOUT}.startsWith('Frame ')"));
    browser.focus("document.querySelector('.strip')");
    browser.press("Home");
    let first = browser.frame();
    browser.press("ArrowRight");
    assert_eq!(browser.frame(), first + 1);
    browser.press("ArrowLeft");
    assert_eq!(browser.frame(), first);
    let marks = "[...document.querySelectorAll('#strip .jump')].map(g => Number(g.dataset.f))";
    browser.press("n");
    let next = "(() => { const row = document.querySelector('#sequence-table tr.open').dataset; \
        const said = JSON.parse(document.getElementById('series').textContent).data[`${row.s}-${row.t}`].said[1]; \
        return Math.min(...said.marks.flatMap(m => m.slice(0, 2)).filter(f => f > 0)); })()";
    assert_eq!(browser.frame(), first + browser.value(next).as_i64().unwrap());
    browser.press("p");
    browser.press("End");
    let last = browser.frame();
    browser.click("document.querySelector('[data-do=back]')");
    assert_eq!(browser.frame(), last - 1);
    assert_eq!(browser.text("document.querySelector('.strip').ariaValueNow"), (last - 1).to_string());

    // By mouse: a mark of the strip, a place of the strip, an entry of the list.
    let mark = browser.value(&format!("{marks}.at(-1)")).as_i64().unwrap();
    browser.click("document.querySelector('#strip .jump:last-of-type .hit-area')");
    assert_eq!(browser.frame(), first + mark);
    browser.click("document.getElementById('strip')");
    let middle = browser.frame();
    assert!((last / 4..=3 * last / 4).contains(&middle), "{middle} of {last}");
    browser.click("document.querySelector('#marks button')");
    assert_eq!(browser.frame(), first + browser.value(&format!("{marks}[0]")).as_i64().unwrap());
}

/// The marks that the viewer draws are those that the table counts.
fn marks_are_the_counts(browser: &mut Browser) {
    let row = "document.querySelector('#sequence-table tr.open')";
    let column = "[...document.querySelector('#sequence-table thead tr').cells].findIndex(c => c.textContent.startsWith('hist'))";
    let counted = browser.text(&format!("{row}.cells[{column}].textContent"));
    let drawn = browser.text(
        "['hit', 'miss', 'false'].map(k => document.querySelectorAll(`#strip .mark.${k}`).length).join(' / ')",
    );
    assert_eq!(counted, drawn);
    let boxes = "[...document.querySelectorAll('#stage .box')].map(b => b.classList[1]).join(' ')";
    choose(browser, "show-tracker", "still");
    browser.becomes(&format!("{boxes}.includes('background')"));
    let boxes = browser.text(boxes);
    assert!(boxes.starts_with("background tracker"), "{boxes}");
}

/// A sequence with pictures shows one in the frame that it is of.
fn picture_is_shown(browser: &mut Browser) {
    let with_stills =
        "JSON.parse(document.getElementById('series').textContent).sequences.find(s => s.stills.length)";
    let name = browser.text(&format!("{with_stills}.name"));
    choose(browser, "show-sequence", &name);
    browser.becomes(&format!("document.querySelector('#show-sequence').selectedOptions[0].text === '{name}' && {READOUT}.startsWith('Frame')"));
    browser.focus("document.querySelector('.strip')");
    browser.press("Home");
    let still = browser.value(&format!("{with_stills}.stills[0]")).as_i64().unwrap();
    for _ in 0..still / 10 {
        browser.value("document.querySelector('.strip').dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowRight', shiftKey: true, bubbles: true}))");
    }
    (0..still % 10).for_each(|_| browser.press("ArrowRight"));
    assert_eq!(browser.value("document.querySelectorAll('#stage image').length"), 1);
    assert_eq!(browser.value(PICTURE_WIDTH), browser.value(&format!("{with_stills}.size[0]")));
}

/// From a number to its formula, its sequences and its strip, by keyboard, and back.
fn number_leads_to_its_sequences(browser: &mut Browser) {
    let link = "[...document.querySelectorAll('a.origin')].find(a => a.title.startsWith('Recall of hist on still too '))";
    let told = browser.text(&format!("{link}.title"));
    let [number, formula, command] = told.split('\n').collect::<Vec<_>>()[..] else { panic!("{told}") };
    assert_eq!(command, "trackfail explain mine/page/t recall hist --tracker 'still too'");
    browser.focus(link);
    browser.press("Enter");
    let text = |id: &str| format!("document.getElementById('explained-{id}').textContent");
    browser.becomes(&format!("{} === {link}.title.split('\\n')[0]", text("number")));
    browser.becomes("document.activeElement.id === 'explained'");
    assert_eq!([browser.text(&text("number")), browser.text(&text("formula"))], [number, formula]);
    assert!(browser.text(&text("by")).starts_with("counted by khalid2016/1: "));
    browser.becomes("document.getElementById('explained').getBoundingClientRect().top < innerHeight");
    let chosen = |id: &str| format!("document.getElementById('{id}').selectedOptions[0].text");
    for (id, name) in [("tracker", "still too"), ("method", "hist")] {
        for part in ["by", "show"] {
            assert_eq!(browser.text(&chosen(&format!("{part}-{id}"))), name);
        }
    }
    // The sum of the rows shown is what stands in the formula: TP / (TP + FN) = tp / (tp + fn).
    let sum = browser
        .text("[...document.querySelectorAll('#sequence-table tfoot td:not([hidden])')].at(-1).textContent");
    let counts: Vec<&str> = sum.split(" / ").collect();
    assert_eq!(formula, format!("TP / (TP + FN) = {0} / ({0} + {1})", counts[0], counts[1]));
    let top = "document.querySelector('#sequence-table tbody tr:not([hidden])')";
    assert_eq!(browser.value(&format!("{top}.classList.contains('open')")), true);
    browser.click("document.getElementById('explained-back')");
    assert_eq!(browser.value(&format!("document.activeElement === {link}")), true);
    browser.click("document.getElementById('clear')");
    assert_eq!(browser.value("document.getElementById('explained').hidden"), true);
    for _ in 0..2 {
        browser.click("document.querySelector('#sequence-table thead th[aria-sort] button')");
    }
    assert_eq!(browser.value("document.querySelectorAll('#sequence-table [aria-sort]').length"), 0);
}

/// Texts whose contrast with what is behind them is below 4.5.
const FAINT: &str = "(() => {
  const parts = text => text.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b].map(v => v / 255)
    .map(v => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
    .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = e => {
    for (; e; e = e.parentElement) {
      const colour = parts(getComputedStyle(e).backgroundColor);
      if (colour.length < 4 || colour[3] === 1) return colour;
    }
    return [255, 255, 255];
  };
  const seen = new Set();
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = texts.nextNode(); node; node = texts.nextNode()) {
    const e = node.parentElement;
    if (!node.data.trim() || e.closest('figure .sheet') || !e.getClientRects().length) continue;
    const style = getComputedStyle(e);
    const front = parts(e.closest('svg') ? style.fill : style.color);
    const [high, low] = [light(front), light(behind(e))].sort((a, b) => b - a);
    const contrast = (high + 0.05) / (low + 0.05);
    if (contrast < 4.5) seen.add(`${e.tagName}.${e.className}: ${contrast.toFixed(2)}`);
  }
  return [...seen].join(', ');
})()";

#[needs(chromium)]
#[test]
fn names_of_any_kind_are_text_and_break_nothing() {
    let mut browser = Browser::start();
    let long = hostile::words().concat();
    let all = series([&long, "<b>&'\"</b>"]);
    let page = Page {
        title: long.clone(),
        sequences: all.tallies(),
        series: embedded(&all, usize::MAX).unwrap(),
        ..Page::default()
    };
    let place = Place::new();
    place.write("a page with #, % and 'quotes'.html", render(&page).unwrap());
    let url = place.path("a page with %23, %25 and 'quotes'.html");
    for width in [390, 1400] {
        browser.screen(width, 900, false);
        browser.open(&url);
        browser.becomes(&format!("{READOUT}.startsWith('Frame 21 (21 of 60) · Oₜ 1, lost · score 0.0032, threshold 0.004 · no alarm · hit')"));
        browser.has_no_sideways_scroll();
        let shown = browser.text("document.querySelector('#show-sequence').options[0].text");
        assert!(shown.contains("</script><script>alert(") && shown.contains("\u{fffd}"), "{shown}");
        assert_eq!(browser.value("document.scripts.length"), 2);
        assert_eq!(browser.value("document.querySelectorAll('img, b').length"), 0);
        choose(&mut browser, "by-tracker", "<b>&'\"</b>");
        assert_eq!(browser.value(SHOWN), 2);
        assert_eq!(browser.complaints("file://"), Vec::<String>::new());
        browser.picture(&format!("names-{width}"));
    }
}

#[needs(chromium)]
#[test]
fn series_beside_the_page_are_loaded_from_disk_when_they_are_shown() {
    let mut browser = Browser::start();
    let all = series(["Girl", "Bolt"]);
    let place = Place::new();
    ["data", "figures"].iter().for_each(|name| drop(place.folder(name)));
    let (series, files) = beside(&all, |name, text| std::fs::write(place.path(name), text)).unwrap();
    assert_eq!(files, 2);
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"60\" height=\"40\"><rect width=\"60\" height=\"40\"/></svg>";
    let file = "figures/a #1 50%.svg".to_string();
    let figure =
        FigureView { name: "f".into(), svg: svg.into(), file: file.clone(), ..FigureView::default() };
    let page = Page {
        figures: vec![figure],
        figures_beside: true,
        sequences: all.tallies(),
        series,
        beside: true,
        ..Page::default()
    };
    place.write(&file, svg);
    place.write("index.html", render(&page).unwrap());
    browser.screen(1400, 900, true);
    browser.open(&place.path("index.html"));
    browser.becomes(&format!("{READOUT}.includes('hit')"));
    assert_eq!(browser.value("Object.keys(document.querySelectorAll('script[src]')).length"), 1);
    // So is a figure that is not in the page.
    browser.value("document.querySelector('figure img').scrollIntoView()");
    browser.becomes("document.querySelector('figure img').naturalWidth === 60");
    choose(&mut browser, "show-tracker", "Bolt");
    browser.becomes("document.querySelectorAll('script[src]').length === 2");
    browser.becomes(&format!("{READOUT}.includes('hit')"));
    browser.press("n");
    assert_eq!(browser.complaints("file://"), Vec::<String>::new());
    // Without its file a track cannot be shown, which the page says.
    std::fs::remove_dir_all(place.path("data")).unwrap();
    browser.open(&place.path("index.html"));
    browser.becomes(&format!("{READOUT}.includes('data/00-000.js is not beside this page')"));
}
