use super::*;
use crate::table::build;
use crate::table::layout::Cell;
use crate::table::render::tests::sample;

#[test]
fn a_table_by_hand() {
    let text = latex("a/b", &sample());
    assert!(text.contains("\\caption{A \\& B\\_1. 12 of 21 targets.}"));
    // The paper leaves zeros out, so the columns are flush right.
    assert!(text.contains("\\begin{tabular}{lrr}"), "{text}");
    assert!(text.contains("Precision $\\uparrow$ & {\\bfseries .120\\textdagger{}} & {.100} \\\\"), "{text}");
    let escaped = "é{\\ifdefined\\Umathcode \u{5d0}\u{5d1}\\else ??\\fi}b";
    assert_eq!(latex_escape("é\u{5d0}\u{5d1}b"), escaped);
}

#[test]
fn siunitx_aligns_numbers_with_a_digit_before_the_point() {
    let mut layout = sample();
    let cells = &mut layout.groups[0].rows[0].cells;
    cells[0].ours = Some("0.120".into());
    cells[0].published = Some("12".into());
    cells[0].difference = Some("-0.010".into());
    let text = latex("a/b", &layout);
    assert!(text.contains("\\begin{tabular}{lS[table-format=+2.3]r}"), "{text}");
    assert!(text.contains("& \\bfseries 0.120{\\textdagger} &") && text.contains("difference & -0.010 &"));
    assert_eq!([digits("-0.5"), digits("-.5")], [Some((1, 1, true)), Some((0, 1, true))]);
    for none in ["", ".", ".a", "5.", "0.1±0.2", "1e5", "--1", "nan", "1.2.3"] {
        assert_eq!(digits(none), None, "{none}");
    }
}

#[test]
fn labels_of_all_experiments_differ() {
    assert_eq!(label("khalid2016/table1", "table1"), "tab:khalid2016-table1");
    assert_eq!(label("khalid2016/table1", "counts"), "tab:khalid2016-table1-counts");
    assert_eq!(label("quickstart", "pairs"), "tab:quickstart-pairs");
    assert!(latex("a/b", &sample()).contains(&format!("\\label{{tab:a-b-{}}}", sample().name)));
}

#[test]
fn numbers_have_a_minus_and_words_a_hyphen() {
    assert_eq!(upright("-.035"), "$-$.035");
    assert_eq!(upright("[-.113, -0.2]"), "{[}$-$.113, $-$0.2{]}");
    let words = ["Two-MChi", "2010-2015", "-"];
    assert_eq!(words.map(upright), words);
    // Two of them would be a dash.
    assert_eq!(["a--b", "2--.5"].map(upright), ["a-{}-b", "2-{}-.5"]);
}

/// Part with lines whose cells are named like their columns, in groups of these sizes.
fn part_of(columns: &[&str], groups: &[usize]) -> Part {
    let row = |k: usize| {
        let cell = |c: &&str| Cell { ours: Some(format!("{c} {k}")), ..Cell::default() };
        (format!("row {k}"), columns.iter().map(cell).collect())
    };
    let groups = groups.iter().map(|n| build::group("", "group".into(), (0..*n).map(row)));
    let layout = build::table("", String::new(), "method", columns.iter().copied(), groups.collect());
    part(&layout, &(0..columns.len()).collect::<Vec<_>>(), |_| true)
}

#[test]
fn bounds_are_one_column_that_stays_with_its_value() {
    let columns =
        ["reads", "AUROC", "95 % from", "95 % to", "a", "b", "c", "95 % from", "95 % to", "d", "e", "f"];
    let part = part_of(&columns, &[1]);
    assert_eq!(part.columns, ["reads", "AUROC", "95 %", "a", "b", "c", "95 %", "d", "e", "f"]);
    assert_eq!(part.lines[0].cells[2].0, "[95 % from 0, 95 % to 0]");
    assert_eq!(part.side_by_side(Width::Column), [0..5, 5..10]);
    let ends_in_interval = part_of(&["a", "b", "c", "d", "e", "95 % from", "95 % to", "f"], &[1]);
    assert_eq!(ends_in_interval.side_by_side(Width::Column), [0..6, 6..7]);
    assert_eq!(part.side_by_side(Width::Text).len(), 1);
}

// A sheet has 47 lines; a group that goes over its end has its heading again.
#[test]
fn a_long_table_is_several() {
    let lines = |groups: &[usize], below| {
        part_of(&["F"], groups).sheets(below).iter().map(|sheet| sheet.len()).collect::<Vec<_>>()
    };
    assert_eq!(lines(&[30, 40, 5], 1), [45, 30]);
    assert_eq!(lines(&[30], 2), [21, 9]);
    assert_eq!(lines(&[46], 1), [46]);
    let part = part_of(&["F"], &[30, 40, 5]);
    let second = part.tabular(part.sheets(1)[1], 0..1);
    assert_eq!(second.matches("\\multicolumn{2}{l}{\\textit{group}}").count(), 2);
}
