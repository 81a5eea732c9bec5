use super::*;
use crate::spec::check::tests::SPEC;
use crate::spec::parse;
use trackfail_testing::assert_says;

const HEAD: &str =
    "schema = 1\nname = \"a\"\ntitle = \"A\"\nprotocol = \"khalid2016/1\"\nsuites.test = \"synthetic-vot\"\n";
const TRACKER: &str = "[[tracker]]\nname = \"still\"\n";
const METHOD: &str = "[[method]]\nname = \"RAW\"\n";

fn refused(text: &str) -> SpecError {
    let start = || text.chars().take(300).collect::<String>();
    let e = parse("a.toml", text).err().unwrap_or_else(|| panic!("read: {}", start()));
    // Nobody wants to read more, and a word of the file must not fill the screen.
    assert!(e.to_string().chars().count() < 2400, "{}", e.message.len());
    e
}

/// Experiment with `more` appended after its tracker and its method.
fn whole(more: &str) -> String {
    format!("{HEAD}{TRACKER}{METHOD}{more}")
}

/// Experiment in which the lines of the tracker and of the method are replaced.
fn with(tracker: &str, method: &str) -> String {
    format!("{HEAD}[[tracker]]\n{tracker}\n[[method]]\n{method}\n")
}

fn many(count: usize, item: impl Fn(usize) -> String) -> String {
    (0..count).map(item).collect()
}

#[test]
fn long_files_are_refused_unread() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.toml");
    std::fs::File::create(&path).unwrap().set_len(100 << 20).unwrap();
    let error = read_text(&path).unwrap_err();
    assert_eq!((error.file, error.line), (path.display().to_string(), 1));
    assert_eq!(error.message, "an experiment file has at most 4194304 bytes");
    std::fs::File::create(&path).unwrap().set_len(MAX_BYTES as u64).unwrap();
    assert_eq!(read_text(&path).unwrap().len(), MAX_BYTES);
    std::fs::write(&path, b"a\nb\xFF\n").unwrap();
    assert_eq!(read_text(&path).unwrap_err().line, 2);
    assert!(read_text(&dir.path().join("b.toml")).is_err() && read_text(dir.path()).is_err());
    assert!(refused(&" ".repeat(MAX_BYTES + 1)).message.contains("at most 4194304 bytes"));
    #[cfg(unix)]
    assert!(read_text(Path::new("/dev/zero")).unwrap_err().message.contains("at most"));
}

// A hundred methods that are like one with a long grid would be 200 MB of text.
#[test]
fn values_taken_from_other_methods_have_a_limit() {
    let grid = "0, ".repeat(100_000);
    let like = |count| many(count, |k| format!("[[method]]\nname = \"m{k}\"\nlike = \"a\"\n"));
    let head = format!("{HEAD}{TRACKER}[[method]]\nname = \"a\"\nsignal = {{ kind = \"box-motion\" }}\n");
    let of = |count| {
        format!("{head}detector = {{ kind = \"level\" }}\ngrid = {{ above = [{grid}] }}\n{}", like(count))
    };
    assert_says(refused(&of(100)), "methods take more than 4194304 bytes from those that they are `like`");
    // Too long a list of methods is told as such.
    assert!(!refused(&of(300)).message.contains("bytes"));
}

#[test]
fn deep_nesting_is_refused() {
    let n = 200_000;
    for text in [
        format!("a = {}", "[".repeat(n)),
        format!("a = {}{}", "[".repeat(n), "]".repeat(n)),
        format!("a = {}", "{a=".repeat(n)),
        format!("{}a = 1", "a.".repeat(n)),
        format!("[{}a]", "a.".repeat(n)),
        format!("[[{}a]]", "a.".repeat(n)),
        format!("{HEAD}{TRACKER}{METHOD}signal = {}1", "{ kind = ".repeat(n)),
        format!("{HEAD}{TRACKER}deep = {}{}\n{METHOD}", "[".repeat(n), "]".repeat(n)),
    ] {
        refused(&text);
    }
}

// The law: whichever word or number of an experiment is a long one, the message is short.
#[test]
fn long_words_are_shortened_in_messages() {
    let long = "x".repeat(4000);
    let is_word = |c: char| c.is_ascii_alphanumeric() || "_-/.".contains(c);
    let starts = SPEC.char_indices().filter(|(at, c)| is_word(*c) && !SPEC[..*at].ends_with(is_word));
    for (at, _) in starts {
        let (before, rest) = SPEC.split_at(at);
        let after = rest.trim_start_matches(is_word);
        let may_be_long = ["title = \"", "title = \"A ", "text = \""].iter().any(|key| before.ends_with(key));
        match parse("a.toml", &format!("{before}{long}{after}")) {
            Ok(_) => assert!(may_be_long, "{before}"),
            Err(e) => assert!(!e.to_string().contains(&long[..2400]), "{e}"),
        }
    }
    let long = "x".repeat(1 << 20);
    let with = |tracker: &str| with(tracker, "name = \"RAW\"");
    for text in [
        with(&format!("name = \"still\"\n{long} = 1")),
        with(&format!("name = \"still\"\nlabel = \"{long}\"")),
        with(&format!("name = \"{long}\"")),
        with(&format!("name = \"replay\"\nresults = \"../{long}\"")),
        whole(&format!("[[claim]]\ntext = \"t\"\nholds = \"{long}\"")),
        whole("").replace("schema = 1", &format!("schema = {}", "1".repeat(1 << 20))),
    ] {
        refused(&text);
    }
}

#[test]
fn huge_numbers_are_refused() {
    let still = |line: &str| with(&format!("name = \"still\"\n{line}"), "name = \"RAW\"");
    let detector =
        |text: &str| whole(&format!("signal.kind = \"rgb-histogram\"\ndetector = {{ kind = {text} }}\n"));
    let level = |below: &str| detector(&format!("\"level\", below = {below}"));
    let trained =
        |grid: &str| level(&format!("{{ train = \"test\", maximise = \"recall\", grid = {{ {grid} }} }}"));
    let arma =
        |order: &str| detector(&format!("\"arma-forecast\", horizon = 5, threshold = 1, order = {order}"));
    for text in [
        format!("{HEAD}seed = -1\n{TRACKER}{METHOD}"),
        format!("{HEAD}seed = 18446744073709551616\n{TRACKER}{METHOD}"),
        still("runs = 1001"),
        still("runs = 0"),
        still("runs = 4294967296"),
        still("runs = 1e300"),
        level("inf"),
        level("nan"),
        level("1e999"),
        level("0") + "grid = { below = [nan] }",
        trained("from = 0, to = 1e300, step = 1e-300"),
        trained("from = 1, to = 0, step = 0"),
        arma("[1000000, 9], window = 20"),
        arma("[1, 1], window = 9223372036854775807"),
    ] {
        refused(&text);
    }
}

#[test]
fn long_lists_are_refused() {
    let methods = |n| many(n, |i| format!("[[method]]\nname = \"m{i}\"\ndetector.kind = \"never\"\n"));
    let trackers = |n| many(n, |i| format!("[[tracker]]\nname = \"still\"\nlabel = \"t{i}\"\n"));
    assert!(parse("a", &format!("{HEAD}{}{}", trackers(256), methods(256))).is_ok());
    let repeated = trackers(256).replace("\nlabel", "\nruns = 1000\nlabel");
    let numbers = many(300_000, |i| format!("{i},"));
    let grid = format!(
        "detector = {{ kind = \"level\", below = 1 }}\nsignal.kind = \"rgb-histogram\"\ngrid.below = [{numbers}]"
    );
    let trained = |i| {
        format!(
            "[[method]]\nname = \"m{i}\"\nsignal.kind = \"rgb-histogram\"\ndetector = {{ kind = \"level\", \
             below = {{ train = \"test\", maximise = \"recall\", grid = {{ from = 0, to = 0.999, step = 0.001 }} }} }}\n"
        )
    };
    assert!(parse("a", &format!("{HEAD}{TRACKER}{}", many(20, trained))).is_ok());
    let roles = many(17, |i| format!("suites.r{i} = \"synthetic-vot\"\n"));
    let list = |item: &str, n: usize| vec![format!("\"{item}\""); n].join(",");
    let table = |i: usize, rows: usize| {
        format!("[[table]]\nname = \"t{i}\"\nrows = [{}]\ncolumns = \"method\"\n", list("recall", rows))
    };
    let figure = |more: &str| whole(&format!("[[figure]]\nname = \"f\"\nkind = \"strips\"\n{more}"));
    let shown = format!("methods = [{}]", list("RAW", 257));
    let claims = many(1025, |_| "[[claim]]\ntext = \"t\"\nholds = \"1 > 0\"\n".into());
    let sequences = format!("panels = [[\"error\"]]\nsequences = [{}]", list("ball", 65));
    for (text, words) in [
        (
            format!("{HEAD}{}{METHOD}", trackers(60_000)),
            "`tracker` must be a list of at most 256, not a list of 60000",
        ),
        (format!("{HEAD}{TRACKER}{}", methods(60_000)), "not a list of 60000"),
        (format!("{HEAD}{repeated}{}", methods(9)), "2304000 cells a sequence"),
        (whole(&grid), "this makes 300000"),
        (format!("{HEAD}{TRACKER}{}", many(200, trained)), "more than 20000 detectors"),
        (
            format!("{HEAD}{roles}{TRACKER}{METHOD}"),
            "`suites` must be a table of at most 16, not a table of 18",
        ),
        (whole(&many(257, |i| table(i, 1))), "not a list of 257"),
        (whole(&table(0, 65)), "`rows` must be a list of at most 64, not a list of 65"),
        (whole(&(table(0, 1) + &shown)), "`methods` must be a list of at most 256, not a list of 257"),
        (figure(&format!("panels = [[{}]]", list("error", 65))), "a list of 65"),
        (figure(&format!("panels = [{}]", "[],".repeat(65))), "a list of 65"),
        (figure(&format!("panels = [{}]", "[\"error\", \"error\"],".repeat(33))), "`panels`, at most 64"),
        (figure(&sequences), "`sequences` must be a list of at most 64, not a list of 65"),
        (whole(&claims), "`claim` must be a list of at most 1024, not a list of 1025"),
    ] {
        assert_says(refused(&text).message, words);
    }
}

#[test]
fn names_that_become_paths_stay_in_their_folder() {
    let long = "a".repeat(300);
    let paths = ["", ".", "..", "../a", "a/../b", "/a", "a/", "a//b", "./a", "a\\\\b", "a\\u0000b"];
    let words = "\\\\a|C:a|c:/a|a\\nb|\u{e9}|a\u{202e}b|A|a b|~|-/../a|a.|con ";
    for bad in paths.into_iter().chain(words.split('|')).chain([long.as_str()]) {
        let name = HEAD.replace("name = \"a\"", &format!("name = \"{bad}\""));
        let table = format!("[[table]]\nname = \"{bad}\"\nrows = [\"recall\"]\ncolumns = \"method\"\n");
        let figure = format!("[[figure]]\nname = \"{bad}\"\nkind = \"strips\"\npanels = [[\"error\"]]\n");
        for (text, line) in [
            (name + TRACKER + METHOD, 2),
            (whole(&table), 11),
            (whole(&figure), 11),
            (HEAD.replace("synthetic-vot", bad) + TRACKER + METHOD, 5),
        ] {
            assert_eq!(refused(&text).line, line, "{bad}");
        }
    }
    // Table and figure names are one word; experiments may have folders.
    refused(&whole("[[table]]\nname = \"a/b\"\nrows = [\"recall\"]\ncolumns = \"method\""));
    for bad in paths.into_iter().chain(["/etc/passwd"]) {
        let tracker = format!("name = \"replay\"\nresults = \"{bad}\"");
        assert_eq!(refused(&with(&tracker, "name = \"RAW\"")).line, 8, "{bad}");
    }
}

#[test]
fn labels_are_no_formulas_and_no_control_sequences() {
    for bad in
        ["=1", "+1", "-1", "@SUM(A1)", "a\\tb", "\\ra", "\\u001b[2J", "a\\u009bb", "a\u{202e}b", "a\u{2028}b"]
    {
        let never = format!("name = \"{bad}\"\ndetector.kind = \"never\"");
        let published = format!(
            "[[table]]\nname = \"t\"\nrows = [\"recall\"]\ncolumns = \"method\"\n\
             [[published]]\ntable = \"t\"\ntracker = \"{bad}\"\nrow = \"recall\"\nvalues.RAW = \".1\"\n"
        );
        for (text, line) in [
            (format!("{HEAD}{TRACKER}label = \"{bad}\"\n{METHOD}"), 8),
            (with("name = \"still\"", &never), 9),
            (whole(&published), 16),
        ] {
            assert_eq!(refused(&text).line, line, "{bad}");
        }
    }
    // SiamRPN++ is a tracker's name; panels of figures join methods by `+`.
    for good in ["\u{5d0}-1 <b>&'`$#", "SiamRPN++"] {
        assert!(parse("a", &format!("{HEAD}{TRACKER}label = \"{good}\"\n{METHOD}")).is_ok(), "{good}");
    }
    let joined = with("name = \"still\"", "name = \"A+B\"\ndetector.kind = \"never\"");
    assert_eq!(refused(&joined).line, 9);
}
