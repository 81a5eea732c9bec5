use super::claims::Chip;
use super::sequences::json::Said;
use super::sequences::{Method, Sequence, Sequences, Tallies, TallyRow, Track};
use super::write::small_enough;
use super::*;
use crate::figure::{Axis, Entry, Figure, Mark, Marker, Panel, Range, Style, Symbol};
use crate::results::{MethodSeries, TrackSeries};
use crate::table::layout::{Cell, Group, Link, Row, TableLayout};
use base64::Engine;
use proptest::prelude::*;
use sha2::{Digest, Sha256};
use trackfail_core::direction::Direction;
use trackfail_engine::spec::table::Latex;
use trackfail_methods::score::TrackScore;

const HOSTILE: &str = "</script><script>alert(\"x\")</script><img src=x onerror='alert(1)'> & {{ 7*7 }} | `a` *b* \u{202e}abc\u{0}";

fn figure(name: &str) -> FigureView {
    let points = (1..=9).map(|k| (f64::from(k), f64::from(k * k))).collect();
    let marks = vec![Mark::Line { points, style: Style::nth(0), marker: Some(Marker::nth(0)) }];
    let (x, y) = (Axis::new("threshold", Range::Auto), Axis::new("F-score", Range::Auto));
    let curves = Figure {
        title: name.into(),
        rows: vec![vec![Panel { x, y, marks, ..Panel::default() }]],
        legend: vec![Entry::new(Symbol::Line(Style::nth(0), None), name)],
        ..Figure::default()
    };
    FigureView {
        name: name.into(),
        caption: "F-score against the threshold.".into(),
        svg: curves.to_svg().expect("a figure"),
        narrow: String::new(),
        file: "figures/sweep.svg".into(),
        endings: vec!["svg", "png", "column.svg"],
    }
}

fn cell(ours: &str, published: &str, difference: &str, best: bool) -> Cell {
    let some = |s: &str| (!s.is_empty()).then(|| s.to_owned());
    Cell {
        value: ours.parse().ok(),
        ours: some(ours),
        published: some(published),
        difference: some(difference),
        best,
        ..Cell::default()
    }
}

fn claim(text: &str, outcome: ClaimOutcome, detail: &str) -> Finding {
    let chip = Chip { tracker: detail.into(), outcome };
    Finding {
        text: text.into(),
        outcome,
        required: false,
        is_check: false,
        is_met: true,
        counts: detail.into(),
        predicate: "a > b".into(),
        chips: vec![chip],
        details: vec![detail.into()],
    }
}

/// A page whose outside texts are all `name`.
fn page(name: &str) -> Page {
    let row = |label: &str, values: [(&str, &str, &str, bool); 3]| Row {
        label: label.into(),
        direction: Direction::HigherIsBetter,
        cells: values.iter().map(|v| cell(v.0, v.1, v.2, v.3)).collect(),
    };
    Page {
        title: "Tracking error detection on OTB".into(),
        home: "../../index.html".into(),
        experiment: "khalid2016/table1".into(),
        paper: "Khalid, Cavallaro and Rinner, BMVC 2016".into(),
        object: "Table 1".into(),
        data_note: format!("12 of 21 targets present; missing: {name}"),
        verdict: vec![format!("Largest F1 score: {name}.")],
        stretches: Vec::new(),
        downloads: true,
        warnings: vec![format!("thresholds were tuned on {name}")],
        summary: vec!["DTEF finds 30 of 42 failures.".into()],
        claims: vec![
            claim("DTEF has the highest recall", ClaimOutcome::Holds, ".714 >= .667"),
            claim(name, ClaimOutcome::DoesNotHold, name),
            claim("on D1", ClaimOutcome::CannotBeTested, "D1 is not public"),
        ],
        tables: vec![TableLayout {
            name: "Table 1".into(),
            caption: "12 of 21 targets, 42 failures.".into(),
            data: "12 of 21 targets".into(),
            corner: "measure".into(),
            columns: vec!["DTEF".into(), "NAIVE".into(), name.into()],
            latex: Latex::default(),
            groups: vec![Group {
                label: name.into(),
                key: String::new(),
                published_tracker: Some(name.into()),
                has_ours: true,
                rows: vec![
                    row(
                        "P",
                        [
                            (".120", ".110", "+.010", true),
                            (".113", ".111", "+.002", false),
                            ("", ".087", "", false),
                        ],
                    ),
                    row(
                        name,
                        [(".714", ".714", ".000", true), (".650", "", "", false), (name, "", "", false)],
                    ),
                ],
            }],
        }],
        links: false,
        figures: vec![figure("Sweep"), figure(name)],
        figures_beside: false,
        sequences: Tallies {
            unannotated: false,
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
        },
        series: "{}".into(),
        beside: false,
        failed: vec![FailedCell { cell: format!("{name} x ncc"), reason: name.into() }],
        provenance: vec![("trackfail".into(), "0.1.0".into()), (name.into(), "ab12".into())],
        provenance_head: 1,
    }
}

#[test]
fn the_same_page_gives_the_same_bytes() {
    let p = page(HOSTILE);
    assert_eq!(render(&p).expect("a page"), render(&p).expect("a page"));
    assert_eq!(markdown(&p).expect("a page"), markdown(&p).expect("a page"));
}

#[test]
fn hostile_names_are_text() {
    let html = render(&page(HOSTILE)).expect("a page");
    assert!(!html.contains("<script>alert") && !html.contains("<img") && !html.contains("49 |"));
    assert!(html.contains("&lt;script&gt;alert(&quot;x&quot;)"));
    assert!(!html.contains('\u{202e}') && !html.contains('\u{0}'));
    // Everything else is markup of the template, whatever the names are.
    let tags = |name: &str| {
        let mut page = Page { figures: vec![], ..page(name) };
        link(&mut page, name);
        render(&page).expect("a page").matches('<').count()
    };
    assert_eq!(tags(HOSTILE), tags("Girl"));
}

#[test]
fn the_page_loads_nothing() {
    let html = render(&page("Girl")).expect("a page");
    assert_eq!(html.matches("http://").count(), 2, "the namespaces of two figures");
    assert_eq!(html.matches("xmlns=\"http://www.w3.org/2000/svg\"").count(), 2);
    for word in ["https://", "<link", "@import", "url(", "src="] {
        assert!(!html.contains(word), "{word}");
    }
    assert!(html.contains("default-src 'none'") && !html.contains("file:"));
    let beside = Page { beside: true, ..page("Girl") };
    assert!(render(&beside).expect("a page").contains("img-src data: 'self' file:; script-src 'sha256-"));
}

#[test]
fn only_the_pages_own_script_is_allowed_and_only_where_it_is_there() {
    let html = render(&page("Girl")).expect("a page");
    assert_eq!(html.matches("<script").count(), 2, "series and program");
    let program =
        html.split("<script>").nth(1).and_then(|rest| rest.split("</script>").next()).expect("a program");
    let digest = base64::engine::general_purpose::STANDARD.encode(Sha256::digest(program));
    assert!(html.contains(&format!("script-src 'sha256-{digest}'\"")));
    assert!(!render(&Page::default()).expect("a page").contains("<script"));
}

#[test]
fn verdicts_are_counted_at_the_top() {
    let html = render(&page("Girl")).expect("a page");
    let top = html.split("<nav").next().expect("a top").replace('\n', "");
    let count = |class: &str, words: &str| {
        top.contains(&format!("<span class=\"{class}\"><strong class=\"verdict\">1</strong> {words}</span>"))
    };
    assert!(count("holds", "holds") && count("does-not-hold", "does not hold"), "{top}");
    assert!(count("cannot-be-tested", "cannot be tested"), "{top}");
}

#[test]
fn ids_and_their_references_match() {
    let html = render(&page("Girl")).expect("a page");
    let values = |attribute: &str| -> Vec<String> {
        let parts = html.split(attribute).skip(1);
        parts.filter_map(|p| p.split('"').next()).map(str::to_owned).collect()
    };
    let mut ids = values(" id=\"");
    let all = ids.len();
    ids.sort();
    ids.dedup();
    assert_eq!(ids.len(), all, "ids are unique");
    for reference in values("href=\"#").into_iter().chain(values("aria-labelledby=\"")) {
        assert!(ids.contains(&reference), "{reference}");
    }
}

#[test]
fn values_differences_and_missing_values_are_shown() {
    let html = render(&page("RAW")).expect("a page");
    assert!(html.contains("<strong><bdi>.120</bdi></strong>"));
    assert!(html.contains("published <bdi>.110</bdi>") && html.contains("difference <bdi>+.010</bdi>"));
    assert_eq!(html.matches("title=\"no value\"").count(), 1);
    for words in ["Holds:", "Does not hold:", "Cannot be tested:"] {
        assert!(html.contains(words), "{words}");
    }
    assert!(html.contains("<th scope=\"rowgroup\" class=\"group\" colspan=\"4\">"));
}

// On paper a table of 17 columns has a sheet on its side, and what is folded stays so: digests, numbers of claims, long tables.
#[test]
fn only_what_is_open_is_printed() {
    let mut page = page("RAW");
    let table = &mut page.tables[0];
    table.columns = (0..17).map(|k| k.to_string().into()).collect();
    table.groups[0].rows.iter_mut().for_each(|row| row.cells.resize(17, Cell::default()));
    let html = render(&page).expect("a page");
    assert!(html.contains("<details class=\"table wide sheet\" open style=\"--columns: 20\">"), "{html}");
    let style = html.split("@media print").nth(1).expect("a style for paper");
    assert!(
        style.contains("details.table.sheet[open] { page: sheet; }") && !style.contains("details-content")
    );
}

// By hand: two cells of the row are second, as the third one is better than both.
#[test]
fn a_tie_for_the_second_place_is_marked() {
    let mut page = page("RAW");
    let cells = &mut page.tables[0].groups[0].rows[1].cells;
    cells.iter_mut().for_each(|c| c.best = false);
    cells[2].best = true;
    let html = |second: [&str; 2]| {
        let mut page = page.clone();
        let cells = &mut page.tables[0].groups[0].rows[1].cells;
        for (cell, text) in cells.iter_mut().zip(second) {
            cell.second = true;
            cell.ours = Some(text.into());
        }
        render(&page).expect("a page").matches("</em><span class=\"tied\"").count()
    };
    assert_eq!((html([".650", ".650"]), html([".650", ".640"])), (2, 0));
    // A second cell of another row is of another parameter, unless rows are trackers.
    let [first, second] = page.tables[0].groups[0].rows.as_mut_slice() else { panic!("two rows") };
    for row in [&mut *first, &mut *second] {
        row.cells[1].second = true;
        row.cells[1].ours = Some(".650".into());
    }
    let ties = |page: &Page| render(page).expect("a page").matches("</em><span class=\"tied\"").count();
    assert_eq!(ties(&page), 0);
    page.tables[0].groups[0].rows.iter_mut().for_each(|row| row.direction = Direction::Neither);
    assert_eq!(ties(&page), 2);
}

#[test]
fn a_figure_for_a_column_can_be_had() {
    let html = render(&page("RAW")).expect("a page");
    let link = "· for a column <a href=\"figures/sweep.column.svg\" download>SVG</a>";
    assert!(html.contains(link), "{html}");
}

#[test]
fn an_empty_page_is_rendered() {
    let html = render(&Page::default()).expect("a page");
    assert!(html.contains("<main") && !html.contains("<section"));
    assert_eq!(markdown(&Page::default()).expect("a page"), "#\n");
}

#[test]
fn markdown_by_hand() {
    let md = markdown(&page("a|b")).expect("a page");
    assert!(md.contains("| measure | DTEF | NAIVE | a&#124;b |\n|:--|--:|--:|--:|\n"));
    assert!(md.contains("| P | **.120** | .113 |  |\n| P published (a&#124;b) | .110 | .111 | .087 |\n"));
    assert!(md.contains("![Sweep](<figures/sweep.svg>)"));
    assert!(
        md.contains("| on D1 | **cannot be tested (D1 is not public)** | a &gt; b<br>D1 is not public |")
    );
}

#[test]
fn parts_that_do_not_fit_are_errors() {
    let mut p = page("RAW");
    p.tables[0].groups[0].rows[0].cells.pop();
    assert!(matches!(render(&p), Err(ReportError::Row { got: 2, expected: 3, .. })));
    for series in ["</script>", "a & b", "\u{2028}"] {
        let p = Page { series: series.into(), ..page("RAW") };
        assert!(matches!(render(&p), Err(ReportError::NotPacked)), "{series:?}");
    }
    for svg in [
        "",
        "<svg ><script>1</script></svg>",
        "<svg onload=\"x()\"></svg>",
        "<svg ><image href=\"https://example.org/\"/></svg>",
        "<svg ><g id=\"a\"/></svg>",
        "<p></p>",
    ] {
        let mut p = page("RAW");
        p.figures[0].svg = svg.into();
        assert!(matches!(render(&p), Err(ReportError::NotAFigure(_))), "{svg}");
    }
}

/// Links every cell of the page's tables.
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
    link(&mut p, HOSTILE);
    let html = render(&p).expect("a page");
    assert_eq!(
        html.matches(
            "<a class=\"origin\" href=\"#sequences\" data-t=\"0\" data-m=\"1\" title=\"recall of &lt;"
        )
        .count(),
        6
    );
    assert!(
        html.contains("&#10;TP &#x2f; (TP + FN) = 2 &#x2f; (2 + 1)&#10;trackfail explain t recall DTEF\">"),
        "{html}"
    );
    // Tables without links, and pages without sequences, have numbers all the same.
    p.tables.push(without);
    assert_eq!(render(&p).expect("a page").matches("class=\"origin\"").count(), 6);
    p.sequences.rows.clear();
    let html = render(&p).expect("a page");
    assert!(!html.contains("class=\"origin\"") && html.contains("<strong><bdi>.120</bdi></strong>"));
}

/// 100 sequences, 10 methods and a tracker, whose series fill 6 million characters.
fn large() -> Sequences {
    let frames = 1200;
    let names = |word: &str, n: usize| (0..n).map(|k| format!("{word} {k}")).collect::<Vec<_>>();
    let series = TrackSeries { error: vec![0.5; frames], ..TrackSeries::default() };
    let said = |m: usize| {
        let score = (0..frames).map(|t| ((t * 7919 + m * 104_729) % 10_007) as f64 / 10_007.0).collect();
        let method = MethodSeries { score, ..MethodSeries::default() };
        (m, Said::new(&series, &method, &TrackScore::default(), None))
    };
    let track = |s: usize| Track::new([s, 0], &series, &[], (0..10).map(said).collect());
    let method = |name| Method { name, thresholds: vec![None], counted: String::new() };
    Sequences {
        unannotated: false,
        trackers: names("tracker", 1),
        methods: names("method", 10).into_iter().map(method).collect(),
        sequences: names("sequence", 100)
            .into_iter()
            .map(|name| Sequence { name, ..Sequence::default() })
            .collect(),
        tracks: (0..100).map(track).collect(),
        note: String::new(),
    }
}

#[test]
fn a_page_stays_small_whatever_is_in_it() {
    let most = 5 << 20;
    let all = large();
    let made = |p: &mut Page| {
        let folder = tempfile::tempdir().expect("a folder");
        p.sequences = all.tallies();
        let html = small_enough(p, folder.path(), &all, most).expect("a page");
        assert!(html.len() <= most && html.matches("<tr data-s=").count() == 100, "{}", html.len());
        let files = std::fs::read_dir(folder.path().join("data")).expect("files").count();
        assert!(files >= 3 && html.contains(&format!("in {files} files in the folder data")));
        html
    };
    // The series are too much: they are beside the page, the figures in it.
    let mut p = page("Girl");
    let html = made(&mut p);
    assert!(html.contains("xmlns=\"http://www.w3.org/2000/svg\"") && !html.contains("<img"));
    // So are the figures.
    let mut p = page("Girl");
    p.figures[0].file = "figures/a #1 \"b\".svg".into();
    p.figures[0].svg = p.figures[0].svg.replacen("</svg>", &format!("<g>{}</g></svg>", " ".repeat(most)), 1);
    let html = made(&mut p);
    assert!(
        html.contains("<img src=\"figures/a%20%231%20%22b%22.svg\" alt=\"F-score against the threshold.\"")
    );
    assert!(html.contains("img-src data: 'self' file:") && !html.contains("xmlns="));
    // And so is what is behind the numbers.
    let mut p = page("Girl");
    link(&mut p, &"long".repeat(most / 8));
    assert!(!made(&mut p).contains("class=\"origin\""));
    // A small one is in one piece.
    let mut p = page("Girl");
    let html =
        small_enough(&mut p, std::path::Path::new("/nowhere"), &Sequences::default(), most).expect("a page");
    assert!(html.contains("xmlns=") && !html.contains("file:"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn no_name_changes_the_structure(name in "\\PC{0,40}|[<>&\"'|`*_\\[\\]{}%#\\\\\\n\\x00-\\x1f]{0,40}") {
        // The name stands where our number does, and a number has its value beside it.
        prop_assume!(!name.is_empty() && name.parse::<f64>().is_err());
        let mut plain = page("Girl");
        plain.figures.clear();
        link(&mut plain, "Girl");
        let mut p = page(&name);
        p.figures.clear();
        link(&mut p, &name);
        let (html, expected) = (render(&p).expect("a page"), render(&plain).expect("a page"));
        prop_assert_eq!(html.matches('<').count(), expected.matches('<').count());
        prop_assert_eq!(html.matches('"').count(), expected.matches('"').count());
        let (md, expected) = (markdown(&p).expect("a page"), markdown(&plain).expect("a page"));
        prop_assert_eq!(md.matches('|').count(), expected.matches('|').count());
        prop_assert_eq!(md.lines().count(), expected.lines().count());
        prop_assert_eq!(md.matches('<').count(), expected.matches('<').count());
    }
}
