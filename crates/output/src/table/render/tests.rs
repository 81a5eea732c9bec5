use super::*;
use crate::table::build;
use crate::table::latex::latex;
use crate::table::layout::Label;
use trackfail_methods::score::Metric;
use trackfail_testing::hostile::{self, assert_is_text};

pub fn sample() -> TableLayout {
    let cell = |ours: &str, published: &str, best| Cell {
        value: ours.parse().ok(),
        ours: Some(ours.into()),
        published: Some(published.into()),
        difference: Some("+.010".into()),
        best,
        failed: usize::from(best),
        ..Cell::default()
    };
    let cells = vec![cell(".120", ".110", true), cell(".100", ".090", false)];
    let rows = [(Label::of_metric(Metric::PRECISION), cells)];
    let group = Group {
        published_tracker: Some("SP".into()),
        ..build::group("Struck", "Struck (3 events)".into(), rows)
    };
    let caption = "A & B_1. 12 of 21 targets.".to_string();
    TableLayout {
        data: "12 of 21 targets".into(),
        ..build::table("table1", caption, "metric", ["DT|EF", "ARTE*"], vec![group])
    }
}

/// The sample with all its texts a word.
pub fn of_word(word: &str) -> TableLayout {
    let mut table = sample();
    let text = || word.to_string();
    (table.caption, table.data, table.corner, table.columns[0]) = (text(), text(), text(), word.into());
    let group = &mut table.groups[0];
    (group.label, group.key, group.published_tracker) = (text(), text(), Some(text()));
    group.rows[0].label = word.into();
    let cell = &mut group.rows[0].cells[0];
    (cell.ours, cell.published, cell.difference) = (Some(text()), Some(text()), Some(text()));
    table
}

/// A text as LaTeX shows it to [`hostile::latex`].
pub fn in_latex(word: &str) -> String {
    visible(word).replace('"', "''").replace('\u{fffd}', "?")
}

#[test]
fn any_word_is_text_in_csv_markdown_and_latex() {
    let csv = |word: &str| {
        let fields = hostile::csv(&String::from_utf8(csv(&of_word(word)).unwrap()).unwrap());
        fields.iter().map(|row| row.join("\u{1}")).collect::<Vec<_>>().join("\u{2}")
    };
    for word in hostile::words() {
        assert_is_text(&word, &word, csv);
        assert_is_text(&word, &visible(&word), |word| hostile::markdown(&markdown(&of_word(word))));
        assert_is_text(&word, &in_latex(&word), |word| hostile::latex(&latex("a/b", &of_word(word))));
    }
}

#[test]
fn markdown_shows_ours_published_and_difference() {
    let expected = "\
**A &amp; B\\_1. 12 of 21 targets.**

| metric | DT&#124;EF | ARTE\\* |
|:--|--:|--:|
| **Struck (3 events)** | | |
| Precision ↑ | **.120†** | .100 |
| Precision published (SP) | .110 | .090 |
| Precision difference | +.010 | +.010 |
";
    assert_eq!(markdown(&sample()), expected);
    let mut side_by_side = sample();
    side_by_side.groups[0].published_tracker = None;
    assert!(markdown(&side_by_side).contains("\n| Precision published | .110 | .090 |\n"));
}

#[test]
fn files_for_programs_have_a_row_for_each_cell_and_empty_fields_where_nothing_is() {
    let mut table = sample();
    let text = |table: &TableLayout| String::from_utf8(csv(table).unwrap()).unwrap();
    let expected = "group,published_tracker,row,column,ours,published,difference,data\n\
                    Struck,SP,precision,DT|EF,0.12,.110,+.010,12 of 21 targets\n\
                    Struck,SP,precision,ARTE*,0.1,.090,+.010,12 of 21 targets\n";
    assert_eq!(text(&table), expected);
    let group = &mut table.groups[0];
    (group.key, group.published_tracker) = (String::new(), None);
    group.rows[0].cells[1] = Cell { value: Some(0.1), ..Cell::default() };
    assert!(text(&table).ends_with("\n,,precision,ARTE*,0.1,,,12 of 21 targets\n"));
    let bytes = parquet(&table).unwrap();
    assert_eq!(bytes, parquet(&table).unwrap());
    let read = TableRow::read(bytes).unwrap();
    assert_eq!(TableRow::rows(&read).unwrap(), rows(&table).collect::<Vec<_>>());
    table.groups.clear();
    let none = TableRow::read(parquet(&table).unwrap()).unwrap();
    assert!(TableRow::rows(&none).unwrap().is_empty());
}

// Columns and rows that have no room are told of; anchors and counts stand on the page.
#[test]
fn a_terminal_has_as_many_columns_and_rows_as_fit() {
    let mut table = sample();
    table.caption = "One. Two. † Three.".into();
    let whole = plain(&table, 100, 50);
    assert!(whole.starts_with("One. † Three.\n") && !whole.contains("more"), "{whole}");
    let narrow = plain(&table, 40, 1);
    assert!(narrow.lines().take(2).all(|line| line.chars().count() <= 40), "{narrow}");
    assert!(narrow.contains("more rows and 1 more column on the page"), "{narrow}");
    table.columns.iter_mut().for_each(|column| column.kind = LabelKind::Anchor);
    assert_eq!(plain(&table, 100, 50), whole);
    assert_eq!(wrapped("a bb ccc", 5), "a bb\nccc");
}
