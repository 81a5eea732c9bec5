use super::*;
use crate::table::render::tests::sample;

#[test]
fn escapes_everything_special() {
    let text = latex("a/b", &sample());
    assert!(text.contains("\\caption{A \\& B\\_1. 12 of 21 targets.}"));
    // The paper leaves zeros out, so the columns are flush right.
    assert!(text.contains("\\begin{tabular}{lrr}"), "{text}");
    assert!(text.contains("Precision $\\uparrow$ & {\\bfseries .120\\textdagger{}} & {.100} \\\\"), "{text}");
    assert_eq!(latex_escape("\\{$}^~"), "\\textbackslash{}\\{\\$\\}\\textasciicircum{}\\textasciitilde{}");
    assert_eq!(latex_escape("a--b é"), "a-{}-b é");
    assert_eq!(latex_escape("a\u{5d0}\u{5d1}b"), "a{\\ifdefined\\Umathcode \u{5d0}\u{5d1}\\else ??\\fi}b");
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
    assert_eq!(digits("-0.5"), Some((1, 1, true)));
    for none in ["", ".5", "5.", "0.1±0.2", "1e5", "--1", "nan", "1.2.3"] {
        assert_eq!(digits(none), None, "{none}");
    }
    assert!(is_bare("-.5") && !is_bare("0.5") && !is_bare(".") && !is_bare(".a"));
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
    assert_eq!(
        (upright("Two-MChi"), upright("2010-2015"), upright("-")),
        ("Two-MChi".into(), "2010-2015".into(), "-".into())
    );
}
