use super::claims::Tested;
use super::sequences::json::Said;
use super::sequences::{Method, Sequence, Sequences, Tallies, TallyRow, Track};
use super::write::small_enough;
use super::*;
use crate::results::{MethodSeries, TrackSeries};
use crate::table::build::{group, table};
use crate::table::layout::{Cell, Link, TableLayout};
use base64::prelude::{BASE64_STANDARD, Engine};
use proptest::prelude::*;
use sha2::{Digest, Sha256};
use trackfail_core::direction::Direction;
use trackfail_dataset::text::visible;
use trackfail_methods::score::TrackScore;
use trackfail_testing::hostile::{self, assert_is_text, markup};

fn figure(name: &str) -> FigureView {
    FigureView {
        name: name.into(),
        caption: "F-score against the threshold.".into(),
        svg: "<svg xmlns=\"http://www.w3.org/2000/svg\"><path d=\"M0 0H28\"/></svg>".into(),
        file: "figures/sweep.svg".into(),
        endings: vec!["svg", "png", "column.svg"],
        ..FigureView::default()
    }
}

/// Page in which all texts from outside are `name`.
fn page(name: &str) -> Page {
    let some = |s: &str| (!s.is_empty()).then(|| s.to_owned());
    let cell = |(ours, published, difference): (&str, &str, &str)| Cell {
        value: ours.parse().ok(),
        ours: some(ours),
        published: some(published),
        difference: some(difference),
        ..Cell::default()
    };
    let row = |label: &str, cells: [(&str, &str, &str); 3]| {
        let mut cells = cells.map(cell).to_vec();
        cells[0].best = true;
        (label.to_string(), cells)
    };
    let rows = vec![
        row("P", [(".120", ".110", "+.010"), (".113", ".111", "+.002"), ("", ".087", "")]),
        row(name, [(".714", ".714", ".000"), (".650", "", ""), (name, "", "")]),
    ];
    let mut group = group("", name.into(), rows);
    group.published_tracker = some(name);
    group.rows.iter_mut().for_each(|row| row.direction = Direction::HigherIsBetter);
    let caption = "12 of 21 targets, 42 failures.".to_string();
    let claim = |text: &str, outcome: ClaimOutcome, detail: &str| {
        let tracker = detail.into();
        let one = Tested { tracker, outcome, is_met: true, fails_beyond_chance: false, lines: vec![] };
        Finding {
            text: text.into(),
            predicate: "a > b".into(),
            required: false,
            is_check: false,
            is_met: true,
            outcome,
            counts: detail.into(),
            details: vec![detail.into()],
            tested: vec![one; 2],
        }
    };
    Page {
        title: format!("Detection on {name}"),
        home: "../../index.html".into(),
        experiment: "khalid2016/table1".into(),
        paper: "Khalid, Cavallaro and Rinner, BMVC 2016".into(),
        object: "Table 1".into(),
        data_note: format!("12 of 21 targets present; missing: {name}"),
        verdict: vec![format!("Largest F1 score: {name}.")],
        downloads: true,
        warnings: vec![format!("thresholds were tuned on {name}")],
        stretches: vec![vec!["from".into()], vec![name.into()]],
        summary: vec!["DTEF finds 30 of 42 failures.".into(), name.into()],
        claims: vec![
            claim("DTEF has the highest recall", ClaimOutcome::Holds, ".714 >= .667"),
            claim(name, ClaimOutcome::DoesNotHold, name),
            claim("on D1", ClaimOutcome::CannotBeTested, "D1 is not public"),
        ],
        tables: vec![table("Table 1", caption, "measure", ["DTEF", "NAIVE", name], vec![group])],
        figures: vec![figure("Sweep"), figure(name)],
        sequences: Tallies {
            note: name.into(),
            methods: vec!["DTEF".into(), name.into()],
            attributes: vec![name.into()],
            rows: vec![TallyRow {
                sequence: name.into(),
                tracker: name.into(),
                attributes: name.into(),
                marks: "0".into(),
                cells: vec!["2 / 1 / 3".into(), String::new()],
                ..TallyRow::default()
            }],
            totals: vec!["2 / 1 / 3".into(), String::new()],
            ..Tallies::default()
        },
        series: "{}".into(),
        failed: vec![(format!("{name} x ncc"), name.into())],
        provenance: vec![("trackfail".into(), "0.1.0".into()), (name.into(), "ab12".into())],
        provenance_head: 1,
        ..Page::default()
    }
}

/// HTML of a page. Rendering it again must give the same text.
fn html(page: &Page) -> String {
    let html = render(page).unwrap();
    assert_eq!(html, render(page).unwrap());
    html
}

/// Fails unless a word is text in the page and in its Markdown.
fn assert_is_text_everywhere(word: &str) {
    let of = |word: &str| {
        let mut page = page(word);
        link(&mut page, word);
        page
    };
    let shown = visible(word);
    assert_is_text(word, &shown, |word| markup(&render(&of(word)).unwrap()));
    assert_is_text(word, &shown, |word| hostile::markdown(&markdown(&of(word)).unwrap()));
}

#[test]
fn hostile_words_are_text() {
    hostile::words().iter().for_each(|word| assert_is_text_everywhere(word));
}

#[test]
fn the_page_loads_nothing_and_runs_only_its_own_script() {
    let html = html(&page("Girl"));
    assert_eq!(html.matches("http://").count(), 2, "the namespaces of two figures");
    assert_eq!(html.matches("xmlns=\"http://www.w3.org/2000/svg\"").count(), 2);
    for word in ["https://", "<link", "@import", "url(", "src=", "file:"] {
        assert!(!html.contains(word), "{word}");
    }
    assert_eq!(html.matches("<script").count(), 2, "series and program");
    let program = html.split("<script>").nth(1).and_then(|rest| rest.split("</script>").next()).unwrap();
    let digest = BASE64_STANDARD.encode(Sha256::digest(program));
    assert!(html.contains("default-src 'none'") && html.contains(&format!("script-src 'sha256-{digest}'\"")));
    let beside = Page { beside: true, ..page("Girl") };
    assert!(self::html(&beside).contains("img-src data: 'self' file:; script-src 'sha256-"));
    let empty = self::html(&Page::default());
    assert!(empty.contains("<main") && !empty.contains("<section") && !empty.contains("<script"));
    assert_eq!(markdown(&Page::default()).unwrap(), "#\n");
}

#[test]
fn ids_and_their_references_match() {
    let html = html(&page("Girl"));
    let values = |attribute: &str| -> Vec<String> {
        let parts = html.split(attribute).skip(1);
        parts.filter_map(|p| p.split('"').next()).map(str::to_owned).collect()
    };
    let ids = values(" id=\"");
    assert!(ids.iter().enumerate().all(|(k, id)| !ids[..k].contains(id)), "{ids:?}");
    for reference in values("href=\"#").into_iter().chain(values("aria-labelledby=\"")) {
        assert!(ids.contains(&reference), "{reference}");
    }
}

#[test]
fn values_verdicts_and_downloads_are_shown() {
    let mut page = page("RAW");
    let named = |name: &str| TableLayout { name: name.into(), groups: vec![], ..page.tables[0].clone() };
    let more = ["uncertainty-success_auc", "f-score"].map(named);
    page.tables.extend(more);
    let html = html(&page);
    for words in [
        "<strong><bdi>.120</bdi></strong>",
        "published <bdi>.110</bdi>",
        "difference <bdi>+.010</bdi>",
        "Holds:",
        "Does not hold:",
        "Cannot be tested:",
        "<th scope=\"rowgroup\" class=\"group\" colspan=\"4\">",
        "· for a column <a href=\"figures/sweep.column.svg\" download>SVG</a>",
        // A metric in a heading is in words.
        ">uncertainty, success AUC</h3>",
        ">f-score</h3>",
    ] {
        assert!(html.contains(words), "{words}");
    }
    assert_eq!(html.matches("title=\"no value\"").count(), 1);
    let top = html.split("<nav").next().unwrap().replace('\n', "");
    for (class, words) in
        [("holds", "holds"), ("does-not-hold", "does not hold"), ("cannot-be-tested", "cannot be tested")]
    {
        let count = format!("<span class=\"{class}\"><strong class=\"verdict\">1</strong> {words}</span>");
        assert!(top.contains(&count), "{top}");
    }
}

// On paper a table of 17 columns has a sheet on its side, and what is folded stays so: digests, numbers of claims, long tables.
#[test]
fn only_what_is_open_is_printed() {
    let mut page = page("RAW");
    let table = &mut page.tables[0];
    table.columns = (0..17).map(|k| k.to_string().into()).collect();
    table.groups[0].rows.iter_mut().for_each(|row| row.cells.resize(17, Cell::default()));
    let html = html(&page);
    assert!(html.contains("<details class=\"table wide sheet\" open style=\"--columns: 20\">"), "{html}");
    let style = html.split("@media print").nth(1).unwrap();
    let sheet = "details.table.sheet[open] { page: sheet; }";
    assert!(style.contains(sheet) && !style.contains("details-content"));
}

// By hand: two cells of the row are second, as the third one is better than both.
#[test]
fn a_tie_for_the_second_place_is_marked() {
    let ties = |page: &Page| html(page).matches("</em><span class=\"tied\"").count();
    let mut page = page("RAW");
    let second = |cell: &mut Cell, text: &str| (cell.second, cell.ours) = (true, Some(text.into()));
    let cells = &mut page.tables[0].groups[0].rows[1].cells;
    cells.iter_mut().for_each(|c| c.best = false);
    cells[2].best = true;
    for (texts, tied) in [([".650", ".650"], 2), ([".650", ".640"], 0)] {
        let mut page = page.clone();
        let cells = &mut page.tables[0].groups[0].rows[1].cells;
        cells.iter_mut().zip(texts).for_each(|(cell, text)| second(cell, text));
        assert_eq!(ties(&page), tied);
    }
    // A second cell of another row is of another parameter, unless rows are trackers.
    page.tables[0].groups[0].rows.iter_mut().for_each(|row| second(&mut row.cells[1], ".650"));
    assert_eq!(ties(&page), 0);
    page.tables[0].groups[0].rows.iter_mut().for_each(|row| row.direction = Direction::Neither);
    assert_eq!(ties(&page), 2);
}

#[test]
fn markdown_by_hand() {
    let md = markdown(&page("a|b")).unwrap();
    for part in [
        "| measure | DTEF | NAIVE | a&#124;b |\n|:--|--:|--:|--:|\n",
        "| P | **.120** | .113 |  |\n| P published (a&#124;b) | .110 | .111 | .087 |\n",
        "![Sweep](<figures/sweep.svg>)",
        "| on D1 | **cannot be tested (D1 is not public)** | a &gt; b<br>D1 is not public |",
    ] {
        assert!(md.contains(part), "{part}");
    }
}

#[test]
fn parts_that_do_not_fit_are_errors() {
    let refused = |change: &dyn Fn(&mut Page), why: &str| {
        let mut page = page("RAW");
        change(&mut page);
        trackfail_testing::assert_says(render(&page).unwrap_err(), why);
    };
    let pop = |page: &mut Page| drop(page.tables[0].groups[0].rows[0].cells.pop());
    refused(&pop, "row `P` of table `Table 1` has 2 cells for 3 columns");
    for series in ["</script>", "a & b", "\u{2028}"] {
        refused(&|page| page.series = series.into(), "not packed");
    }
    for svg in [
        "",
        "<svg ><script>1</script></svg>",
        "<svg onload=\"x()\"></svg>",
        "<svg ><image href=\"https://example.org/\"/></svg>",
        "<svg ><g id=\"a\"/></svg>",
        "<p></p>",
    ] {
        refused(&|page| page.figures[0].svg = svg.into(), "`Sweep` is not an SVG");
    }
}

/// Adds a link to all cells of the page's tables.
fn link(p: &mut Page, name: &str) {
    let link = Link {
        number: format!("recall of {name}"),
        formula: "TP / (TP + FN) = 2 / (2 + 1)".into(),
        command: "trackfail explain t recall DTEF".into(),
        tracker: Some(0),
        method: Some(1),
        attribute: None,
    };
    p.links = true;
    let rows = p.tables.iter_mut().flat_map(|t| &mut t.groups).flat_map(|g| &mut g.rows);
    rows.flat_map(|row| &mut row.cells).for_each(|cell| cell.link = Some(link.clone()));
}

#[test]
fn numbers_lead_to_their_sequences() {
    let mut p = page("Girl");
    let without = p.tables[0].clone();
    link(&mut p, "<b>");
    let html = html(&p);
    let link =
        "<a class=\"origin\" href=\"#sequences\" data-t=\"0\" data-m=\"1\" title=\"recall of &lt;b&gt;&#10;";
    assert_eq!(html.matches(link).count(), 6);
    let origin = "&#10;TP &#x2f; (TP + FN) = 2 &#x2f; (2 + 1)&#10;trackfail explain t recall DTEF\">";
    assert!(html.contains(origin), "{html}");
    // Tables without links, and pages without sequences, have numbers all the same.
    p.tables.push(without);
    assert_eq!(self::html(&p).matches("class=\"origin\"").count(), 6);
    p.sequences.rows.clear();
    let html = self::html(&p);
    assert!(!html.contains("class=\"origin\"") && html.contains("<strong><bdi>.120</bdi></strong>"));
}

/// 100 sequences, 10 methods and one tracker, with 6 million characters of series.
fn large() -> Sequences {
    let frames = 1200;
    let series = TrackSeries { error: vec![0.5; frames], ..TrackSeries::default() };
    let said = |m: usize| {
        let score = (0..frames).map(|t| ((t * 7919 + m * 104_729) % 10_007) as f64 / 10_007.0).collect();
        let method = MethodSeries { score, ..MethodSeries::default() };
        (m, Said::new(&series, &method, &TrackScore::default(), None))
    };
    let method = |k| Method { name: format!("method {k}"), thresholds: vec![None], ..Method::default() };
    Sequences {
        trackers: vec!["tracker".into()],
        methods: (0..10).map(method).collect(),
        sequences: vec![Sequence::default(); 100],
        tracks: (0..100).map(|s| Track::new([s, 0], &series, &[], (0..10).map(said).collect())).collect(),
        ..Sequences::default()
    }
}

#[test]
fn a_page_stays_small_whatever_is_in_it() {
    let most = 5 << 20;
    let all = large();
    let made = |mut p: Page| {
        let folder = tempfile::tempdir().unwrap();
        p.sequences = all.tallies();
        let html = small_enough(&mut p, folder.path(), &all, most).unwrap();
        assert!(html.len() <= most && html.matches("<tr data-s=").count() == 100, "{}", html.len());
        let files = std::fs::read_dir(folder.path().join("data")).unwrap().count();
        assert!(files >= 3 && html.contains(&format!("in {files} files in the folder data")));
        html
    };
    // The series are too much: they are beside the page, the figures in it.
    let html = made(page("Girl"));
    assert!(html.contains("xmlns=\"http://www.w3.org/2000/svg\"") && !html.contains("<img"));
    // So are the figures.
    let mut p = page("Girl");
    p.figures[0].file = "figures/a #1 \"b\".svg".into();
    p.figures[0].svg = p.figures[0].svg.replacen("</svg>", &format!("<g>{}</g></svg>", " ".repeat(most)), 1);
    let html = made(p);
    let image = "<img src=\"figures/a%20%231%20%22b%22.svg\" alt=\"F-score against the threshold.\"";
    assert!(html.contains(image) && html.contains("img-src data: 'self' file:") && !html.contains("xmlns="));
    // And so is what is behind the numbers.
    let mut p = page("Girl");
    link(&mut p, &"long".repeat(most / 8));
    assert!(!made(p).contains("class=\"origin\""));
    // A small one is in one piece.
    let mut p = page("Girl");
    let html = small_enough(&mut p, std::path::Path::new("/nowhere"), &Sequences::default(), most).unwrap();
    assert!(html.contains("xmlns=") && !html.contains("file:"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_word_is_text(word in "\\PC{0,40}|[<>&\"'|`*_\\[\\]{}%#\\\\\\n\\x00-\\x1f]{0,40}") {
        // The word stands where our number does, and a number has its value beside it.
        prop_assume!(!word.is_empty() && word == word.trim() && word.parse::<f64>().is_err());
        assert_is_text_everywhere(&word);
    }
}
