//! All errors of a file are reported at once, without errors that only follow from others.

use crate::spec::error::SpecError;
use crate::spec::parse;
use crate::testing::changed;

fn refused(text: &str) -> SpecError {
    parse("try.toml", text).err().unwrap_or_else(|| panic!("is not refused:\n{text}"))
}

/// Line and message of each error.
fn told(text: &str) -> Vec<(usize, String)> {
    let error = refused(text);
    std::iter::once(&error).chain(&error.others).map(|e| (e.line, e.message.clone())).collect()
}

/// A valid experiment.
pub const SPEC: &str = r#"schema = 1
name = "mine/try"
title = "A try"
protocol = "khalid2016/1"

[suites]
test = "synthetic-vot"

[[tracker]]
name = "ncc"
runs = 2

[[method]]
name = "A"
signal = { kind = "distribution-field", layers = 32 }
detector = { kind = "level", below = 0.9 }

[[method]]
name = "B"
signal = { kind = "rgb-histogram" }
detector = { kind = "level", below = 0.9 }
grid = { below = [0.5, 0.6] }

[[table]]
name = "t"
rows = ["recall"]
columns = "method"
methods = ["A", "B"]

[[table]]
name = "u"
rows = ["below"]
columns = "tracker"
methods = ["B"]

[[claim]]
text = "More"
holds = "recall[A] > recall[B, below=0.5, ncc]"
"#;

/// Errors of [`SPEC`] after texts in it are replaced.
fn with(changes: &[(&str, &str)]) -> Vec<(usize, String)> {
    told(&changes.iter().fold(SPEC.to_string(), |text, (from, to)| changed(&text, from, to)))
}

#[test]
fn every_error_is_told_with_its_line() {
    let found = with(&[
        ("title", "tittle"),
        ("khalid2016/1", "khalid2016/9"),
        ("synthetic-vot", "synthetic-vott"),
        ("runs = 2", "runs = \"two\"\nserach = 1.5"),
        ("layers = 32", "layers = \"many\", histroy = 3"),
        ("detector = { kind = \"level\", below = 0.9 }", "detector = { kind = \"level\", below = true }"),
        ("\"rgb-histogram\"", "\"rgb-histogramm\""),
        ("[\"recall\"]", "[\"recal\"]"),
        ("columns = \"tracker\"", "columns = 3"),
        ("recall[A]", "recall[C]"),
    ]);
    let expected = [
        (3, "unknown key `tittle`; did you mean `title`?"),
        (4, "did you mean `khalid2016/1`?"),
        (7, "did you mean `synthetic-vot`?"),
        (11, "`runs` must be a whole number from 1 to 1000, not \"two\""),
        (12, "did you mean `search`?"),
        (16, "did you mean `history`?"),
        (16, "`layers` must be a whole number, not \"many\" (Number M of layers in a field, 2 to 256)"),
        (17, "`below` must be a number or a table, not true"),
        (21, "did you mean `rgb-histogram`?"),
        (27, "did you mean `recall`?"),
        (34, "`columns` must be text in quotes, not 3"),
        (39, "unknown method `C`"),
    ];
    assert_eq!(found.len(), expected.len(), "{found:#?}");
    for ((line, message), (at, words)) in found.iter().zip(expected) {
        assert!(*line == at && message.contains(words), "{line}: {message}, not {at}: {words}");
    }
}

#[test]
fn what_only_follows_from_an_error_is_not_told() {
    let alone = |changes: &[(&str, &str)], line: usize, words: &str| {
        let found = with(changes);
        assert_eq!(found.len(), 1, "{found:#?}");
        assert!(found[0].0 == line && found[0].1.contains(words), "{found:#?}");
    };
    // Tables and claims refer to methods and axes of methods that are wrong.
    alone(&[("\"rgb-histogram\"", "\"histogramme\"")], 20, "unknown signal");
    let for_all = ("recall[A] > recall[B, below=0.5, ncc]", "for all below: recall[B] > 0");
    alone(&[("\"rgb-histogram\"", "\"histogramme\""), for_all], 20, "unknown signal");
    alone(&[("\"level\", below = 0.9 }\n\n", "\"levle\", below = 0.9 }\n\n")], 16, "did you mean `level`?");
    alone(&[("\"ncc\"\n", "\"nncc\"\nlabel = \"ncc\"\n")], 10, "unknown tracker");
    alone(&[("name = \"B\"\nsignal", "name = \"B\"\nlike = \"C\"\nsignal")], 20, "method before this one");
    let lines = "\nsignal = { kind = \"distribution-field\", layers = 32 }\ndetector = { kind = \"level\", below = 0.9 }";
    alone(&[(lines, "")], 14, "unknown published method");
    // A key that is wrong is not missing, too.
    alone(&[("\"mine/try\"", "3")], 2, "`name` must be text in quotes, not 3");
    alone(&[("name = \"t\"", "name = [1]")], 25, "`name` must be text in quotes, not a list");
    alone(&[("test = \"synthetic-vot\"", "test = 1")], 7, "`test` must be text in quotes, not 1");
    alone(&[("\"khalid2016/1\"", "1")], 4, "`protocol` must be text in quotes, not 1");
}

#[test]
fn the_place_is_marked_below_the_line() {
    let text = SPEC.replacen("below = 0.9", "bellow = 0.9", 1);
    let shown = refused(&text).to_string();
    let [message, line, mark] = shown.lines().collect::<Vec<_>>()[..] else { panic!("{shown}") };
    assert!(message.starts_with("try.toml:16: unknown key `bellow`"), "{shown}");
    assert_eq!(line, r#"16 | detector = { kind = "level", bellow = 0.9 }"#);
    assert_eq!(mark, "   |                              ^^^^^^");
    let twice = refused(&text.replacen("\"rgb-histogram\"", "\"rgb\"", 1)).to_string();
    assert!(twice.starts_with("try.toml: 2 errors\ntry.toml:16: "), "{twice}");
}

#[test]
fn all_that_is_no_toml_is_told_line_by_line() {
    let found = told("schema = \nname = \"a\ntitle = 'b'\nseed = = 3\n");
    assert_eq!(found.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [1, 2, 4], "{found:#?}");
}

#[test]
fn of_very_many_errors_the_first_are_shown() {
    let many: String = (0..200)
        .map(|k| format!("\n[[table]]\nname = \"x{k}\"\nrows = [\"recal\"]\ncolumns = \"method\"\n"))
        .collect();
    let shown = refused(&(SPEC.to_string() + &many)).to_string();
    assert!(shown.starts_with("try.toml: 200 errors\n") && shown.ends_with("\nand 180 more"), "{shown}");
}

#[test]
fn all_errors_of_a_table_a_figure_and_a_claim_are_told() {
    let figure =
        "[[figure]]\nname = \"f\"\nkind = \"sweep\"\nmetric = \"recal\"\nx = \"belo\"\nwidth = \"colum\"\n\n";
    let published = "[[published]]\ntable = \"t\"\ntracker = \"ncc\"\nrow = \"recal\"\nvalues = { AA = \"1\", B = \"x\" }\n\n";
    let rows = "rows = [\n\"recal\",\n\"precison\"]\ncolumns = \"metod\"";
    let errors = with(&[
        ("rows = [\"recall\"]\ncolumns = \"method\"", rows),
        ("methods = [\"A\", \"B\"]", "methods = [\"AA\", \"BB\"]"),
        ("[[claim]]", &format!("{figure}[[claim]]")),
        ("recall[A] > recall[B,", "recal[A] > recall[BB,"),
    ]);
    let told = |errors: &[(usize, String)]| {
        errors.iter().map(|(_, message)| message.split('`').nth(1).unwrap()).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(told(&errors), "recal precison metod AA BB recal belo colum recal BB", "{errors:?}");
    let errors = with(&[("[[claim]]", &format!("{published}[[claim]]"))]);
    assert_eq!(told(&errors), "recal AA x", "{errors:?}");
}

#[test]
fn a_mark_stands_below_the_word() {
    let marked = |from: &str, to: &str| {
        let error = refused(&SPEC.replacen(from, to, 1));
        let (line, mark) = error.excerpt.split_once('\n').unwrap();
        let at = mark.find('^').unwrap();
        line[at..at + mark.matches('^').count()].to_string()
    };
    assert_eq!(marked("rows = [\"recall\"]", "rows = [\"recall\", \"recal\"]"), "\"recal\"");
    assert_eq!(marked("> recall[B,", "> recal[B,"), "recal");
    assert_eq!(marked("> recall[B,", "> recall[BB,"), "BB");
}

#[test]
fn a_value_of_a_wrong_type_is_told_with_what_is_wanted() {
    let rows = [
        (
            "runs = 2",
            "runs = -3",
            "`runs` must be a whole number from 1 to 1000, not -3 (Repetitions, at least 1)",
        ),
        ("runs = 2", "runs = 0.5", "`runs` must be a whole number from 1 to 1000, not 0.5"),
        ("runs = 2", "search = true", "`search` must be a number, not true"),
        ("layers = 32", "layers = -1", "`layers` must be a whole number from 0 on, not -1"),
        ("layers = 32", "smoothing = \"anisotropc\"", "unknown smoothing `anisotropc`; did you mean"),
        ("layers = 32", "smoothing = [1]", "`smoothing` must be text in quotes, not a list"),
        ("[\"recall\"]", "\"recall\"", "`rows` must be a list of at most 64, not \"recall\""),
        ("{ kind = \"rgb-histogram\" }", "7", "`signal` must be a table or a list that is not empty, not 7"),
        ("below = [0.5, 0.6]", "below = []", "`below` must be a list that is not empty, not an empty list"),
        (
            "[suites]\ntest = \"synthetic-vot\"",
            "suites = \"x\"",
            "`suites` must be a table of at most 16, not \"x\"",
        ),
        ("holds = ", "hold = ", "unknown key `hold`; did you mean `holds`?"),
        // Keys that shorten a file are known.
        ("title", "extend = \"x\"\ntitle", "unknown key `extend`; did you mean `extends`?"),
        ("text = \"More\"\n", "", "`text` is missing"),
        ("[[claim]]", "[claim]", "write [[claim]]"),
    ];
    for (from, to, expected) in rows {
        let found = with(&[(from, to)]);
        assert!(found.len() == 1 && found[0].1.starts_with(expected), "{found:#?}");
    }
    let bounds = "detector = { kind = \"arma-forecast\", order = [1] }";
    let found = with(&[("detector = { kind = \"level\", below = 0.9 }", bounds)]);
    assert!(found[0].1.starts_with("`order` must be a list of 2, not a list of 1 ("), "{found:#?}");
    let found = with(&[("title", "zzz = 1\ntitle")]);
    assert!(found[0].1.contains("tracker-group, without"), "{found:#?}");
}

#[test]
fn a_file_in_which_all_is_wrong_is_refused_soon() {
    let keys: String = (0..5_000).map(|k| format!("key-{k} = 1\n")).collect();
    let error = refused(&(keys + SPEC));
    assert_eq!(1 + error.others.len(), 1000);
}
