//! Experiments, data and results from somebody who means harm: texts stay texts, files stay in their folders.

use crate::tools::{needs, trackfail};
use polars::prelude::{Column, DataType, ParquetReader, ParquetWriter, SerReader};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use trackfail::results::Results;
use trackfail_testing::conditions::{LATEX, runs};

/// Markup, commands, terminal sequences and turned reading directions, 300 characters and more.
const HOSTILE: &str = "=\u{1b}[2J\u{1b}]0;x\u{7}</script><script>alert(1)</script><img src=x onerror='a()'>\
    \"&amp;{{ 7*7 }} | `rm` **b** [x](javascript:a()) ![i](http://example.org) \\input{/etc/passwd} \
    \\end{tabular} $x^2_3$ %c #1 ~ \u{202e}kcab\u{2066}\u{9b}31m\u{7f}\u{2028}\r\n- list\n\n# head\n1. one\n";

/// A text of the file in TOML's quotes.
fn quoted(text: &str) -> String {
    serde_json::to_string(text).unwrap().replace('\u{7f}', "\\u007f")
}

/// An experiment in which every free text is `text`; its results are looked for in a folder that is absent.
fn spec(text: &str) -> String {
    let text = quoted(&text.repeat(2));
    format!(
        "schema = 1\nname = \"mine/hostile\"\ntitle = {text}\npaper = {text}\nobject = {text}\nnote = {text}\n\
         protocol = \"khalid2016/1\"\n[suites]\ntest = \"synthetic-vot\"\n\
         [[tracker]]\nname = \"still\"\nlabel = \"<b>&'`$#_\\\\ \u{5d0}|*\"\n\
         [[tracker]]\nname = \"replay\"\nresults = \"no/<such> folder\"\nlabel = \"absent\"\n\
         [[method]]\nname = \"*<i>\"\nsignal.kind = \"rgb-histogram\"\ndetector = {{ kind = \"level\", below = 0.9 }}\n\
         [[table]]\nname = \"t\"\ncaption = {text}\nrows = [\"recall\", \"events\"]\ncolumns = \"method\"\n\
         [[figure]]\nname = \"f\"\nkind = \"strips\"\ncaption = {text}\nstills = 2\n\
         panels = [[\"error\"], [\"signal:*<i>\"], [\"score:*<i>\"]]\n\
         [[published]]\ntable = \"t\"\ntracker = \"<u>&%\"\nrow = \"recall\"\nvalues = {{ \"*<i>\" = \".5\" }}\n\
         [[claim]]\ntext = {text}\nholds = \"recall[*<i>] > 1\"\n"
    )
    .replace("[*<i>]", "[*<i>, absent]")
}

struct Ran {
    code: i32,
    stdout: String,
    stderr: String,
}

fn command(root: &Path, words: &[&str]) -> Ran {
    let mut command = trackfail();
    command.current_dir(root).args(words);
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let code = output.status.code().unwrap();
    // A panic exits with 101.
    assert!((0..=5).contains(&code), "{code} {}", String::from_utf8_lossy(&output.stderr));
    Ran { code, stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// Runs an experiment in `root`, its data root below it with a name as bad as a file's can be.
fn run(root: &Path, text: &str, data: &str) -> Ran {
    std::fs::create_dir_all(root.join(data)).unwrap();
    std::fs::write(root.join("a.toml"), spec(text)).unwrap();
    command(root, &["run", "a.toml", "--allow-missing", "--data-root", data])
}

/// A new folder with the results of a run with harmless texts, which is made once.
fn finished() -> tempfile::TempDir {
    static FILES: LazyLock<BTreeMap<PathBuf, Vec<u8>>> = LazyLock::new(|| {
        let root = tempfile::tempdir().unwrap();
        assert_eq!(run(root.path(), "word ", "d").code, 0);
        let entries = walkdir::WalkDir::new(root.path()).into_iter().map(Result::unwrap);
        entries
            .filter(|e| e.file_type().is_file())
            .map(|e| (e.path().strip_prefix(root.path()).unwrap().into(), std::fs::read(e.path()).unwrap()))
            .collect()
    });
    trackfail_testing::folder(FILES.iter())
}

fn report(root: &Path) -> Ran {
    command(root, &["report", "mine/hostile"])
}

fn read(root: &Path, name: &str) -> String {
    std::fs::read_to_string(root.join(name)).unwrap()
}

fn shows_only_text(text: &str) -> bool {
    let turns = |c| ('\u{202a}'..='\u{202e}').contains(&c) || ('\u{2066}'..='\u{2069}').contains(&c);
    !text.contains(|c: char| (c.is_control() && c != '\n') || turns(c))
}

/// Whether braces match and every command is one that a table of ours has.
fn is_our_latex(text: &str) -> bool {
    let body = text.strip_prefix("% needs \\usepackage{booktabs,graphicx,siunitx}\n").unwrap_or(text);
    // A line break of ours ends in `%`.
    let body = body.replace("%\n", "\n");
    is_plain_latex(&body) && body.matches("\\begin{").count() == 2 && body.matches("\\end{").count() == 2
}

/// The name and the number of a line of the file with all numbers.
fn number_of(line: &str) -> Option<(&str, &str)> {
    line.strip_prefix("\\tfset{")?.strip_suffix('}')?.split_once("}{")
}

/// Whether every line behind the comment and the two commands gives a plain name a number, and no name is given twice.
fn are_our_macros(text: &str) -> bool {
    let mut names = BTreeSet::new();
    let (head, numbers) = text.split_at(text.find("\n\\tfset{").map_or(0, |at| at + 1));
    head.lines().count() == 3
        && numbers.lines().all(|line| {
            let Some((name, number)) = number_of(line) else { return false };
            let plain = name.chars().all(|c| c.is_ascii_alphanumeric() || " _-.=+*:[]()/".contains(c));
            plain && names.insert(name) && number.len() < 40 && is_plain_latex(number)
        })
}

fn is_plain_latex(text: &str) -> bool {
    const COMMANDS: &str = " begin end begingroup endgroup centering caption label toprule midrule bottomrule bfseries textit sisetup \
        multicolumn textbackslash textasciitilde textasciicircum textless textgreater textdagger textbar pm \
        times uparrow downarrow ensuremath ifdefined Umathcode else fi normalsize small footnotesize setlength tabcolsep \
        setbox hbox ifdim wd linewidth resizebox box leavevmode par medskip ";
    let (mut depth, mut dollars) = (0_i32, 0);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\\' => {
                let mut word = String::new();
                while let Some(letter) = rest.next_if(char::is_ascii_alphabetic) {
                    word.push(letter);
                }
                let single = word.is_empty() && rest.next().is_some_and(|c| "\\{}$&#%_".contains(c));
                if !single && !COMMANDS.contains(&format!(" {word} ")) {
                    return false;
                }
            }
            '{' => depth += 1,
            '}' => depth -= 1,
            '$' => dollars += 1,
            '#' | '%' | '_' | '^' | '~' => return false,
            _ => {}
        }
        if depth < 0 {
            return false;
        }
    }
    depth == 0 && dollars % 2 == 0
}

/// The words that compile a file with an engine, without a question.
fn compile(engine: &str) -> Vec<&str> {
    match engine {
        "tectonic" => vec![engine],
        _ => vec![engine, "-interaction=nonstopmode", "-halt-on-error"],
    }
}

/// The folder of tables of a run with hostile texts, and its macros.
fn hostile_tables(root: &Path) -> (PathBuf, String) {
    assert_eq!(run(root, HOSTILE, "d").code, 0);
    let folder = root.join("results/mine/hostile/tables");
    let macros = std::fs::read_to_string(folder.join("macros.tex")).unwrap();
    (folder, macros)
}

#[test]
fn hostile_macros_are_numbers() {
    let root = tempfile::tempdir().unwrap();
    let (_, macros) = hostile_tables(root.path());
    assert!(are_our_macros(&macros), "{macros}");
    assert!(!are_our_macros(&macros.replacen("}{", "}{\\input{a}", 1)));
    let twice = macros.lines().last().unwrap_or_default();
    assert!(!are_our_macros(&format!("{macros}{twice}\n")));
}

#[needs(latex)]
#[test]
fn hostile_tables_compile() {
    let root = tempfile::tempdir().unwrap();
    let (folder, macros) = hostile_tables(root.path());
    let engine = LATEX.into_iter().find(|name| runs(name, &["--version"]));
    let engine = compile(engine.expect("the LaTeX that was there when this test was compiled has gone"));
    let names: Vec<String> =
        macros.lines().filter_map(|l| Some(format!("\\tf{{{}}}", number_of(l)?.0))).collect();
    let document = format!(
        "\\documentclass{{article}}\n\\usepackage{{booktabs,graphicx,siunitx}}\n\\input{{macros}}\n\\begin{{document}}\n\
         \\input{{t.tex}}\n\\input{{t.body.tex}}\n{}\n\
         \\end{{document}}\n",
        names.join(" "),
    );
    std::fs::write(folder.join("all.tex"), document).unwrap();
    let output =
        std::process::Command::new(engine[0]).args(&engine[1..]).arg("all.tex").current_dir(&folder).output();
    let output = output.unwrap();
    let told =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && folder.join("all.pdf").exists(), "{told}");
}

#[test]
fn hostile_texts_are_texts_everywhere() {
    let (bad, good) = (tempfile::tempdir().unwrap(), finished());
    let folder = if cfg!(windows) { "d" } else { "=<d>&\"'$#|`\u{1b}[31m\u{202e}\\x" };
    let hostile = run(bad.path(), HOSTILE, folder);
    assert_eq!(hostile.code, 0, "{}", hostile.stderr);
    assert!(shows_only_text(&hostile.stdout), "{:?}", hostile.stdout);
    assert!(
        ["<script>", "not there: "].iter().all(|words| hostile.stdout.contains(words)),
        "{}",
        hostile.stdout
    );

    // The page and the Markdown have the structure that they have with harmless texts.
    let pages = |name: &str| (read(bad.path(), name), read(good.path(), name));
    let (page, harmless) = pages("reports/mine/hostile/index.html");
    assert!(shows_only_text(&page) && page.matches("<script").count() == 2 && !page.contains("<img src=x"));
    assert_eq!(page.matches('<').count(), harmless.matches('<').count());
    assert!(page.contains("&lt;script&gt;alert(1)"));
    let (page, harmless) = pages("reports/mine/hostile/report.md");
    assert!(shows_only_text(&page) && !page.contains('<') | page.contains("<br>"));
    let cells = |text: &str| text.matches('|').count();
    assert_eq!((cells(&page), page.lines().count()), (cells(&harmless), harmless.lines().count()));
    let headings = |text: &str| text.lines().filter(|l| l.starts_with('#')).count();
    assert_eq!(headings(&page), headings(&harmless));
    assert!(page.contains("\\[x\\](javascript") && !page.contains("![i]"));

    let (table, harmless) = pages("results/mine/hostile/tables/t.tex");
    assert!(is_our_latex(&table) && shows_only_text(&table), "{table}");
    assert_eq!(table.lines().count(), harmless.lines().count());
    for bad in ["\\input{a}", "}"] {
        assert!(!is_our_latex(&harmless.replace("word", bad)), "{bad}");
    }
    let (table, harmless) = pages("results/mine/hostile/tables/t.md");
    assert!(shows_only_text(&table));
    assert_eq!(table.lines().count(), harmless.lines().count());
    let svg = read(bad.path(), "reports/mine/hostile/figures/f.svg");
    assert!(shows_only_text(&svg) && !svg.contains("<i>") && !svg.contains("<b>"));

    // The names in CSV files are no formulas; they are checked where they come in.
    for name in ["scores.csv", "measures.csv", "tables/t.csv"] {
        let text = read(bad.path(), &format!("results/mine/hostile/{name}"));
        for field in text.split([',', '\n']) {
            let field = field.trim_matches('"');
            let number = field.parse::<f64>().is_ok();
            assert!(number || !field.starts_with(['=', '+', '-', '@', '\t', '\r']), "{name}: {field}");
        }
    }
    // Rendered again from the results alone, everything stays as it is.
    let page = read(bad.path(), "reports/mine/hostile/index.html");
    assert_eq!(report(bad.path()).code, 0);
    assert_eq!(read(bad.path(), "reports/mine/hostile/index.html"), page);
}

#[test]
fn messages_do_not_reach_the_terminal_raw() {
    let root = tempfile::tempdir().unwrap();
    let name = if cfg!(windows) { "a.toml" } else { "\u{1b}[31m\u{202e}a.toml" };
    for text in ["\"\\u001b[2J\\u009b1m\" = 1", "schema = 1\nname = \"\\u001b]0;x\\u0007\"", "\u{1b}[2J"] {
        std::fs::write(root.path().join(name), text).unwrap();
        let ran = command(root.path(), &["run", name]);
        assert_eq!(ran.code, 2);
        assert!(shows_only_text(&ran.stderr) && ran.stderr.contains("a.toml:"), "{:?}", ran.stderr);
    }
    let ran = command(root.path(), &["run", "\u{1b}[2Jabsent\u{9b}"]);
    assert!(ran.code == 2 && shows_only_text(&ran.stderr), "{:?}", ran.stderr);
}

#[test]
fn a_huge_experiment_file_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let file = std::fs::File::create(root.path().join("a.toml")).unwrap();
    file.set_len(100 << 20).unwrap();
    let ran = command(root.path(), &["run", "a.toml"]);
    assert_eq!((ran.code, ran.stdout.as_str()), (2, ""));
    assert!(ran.stderr.contains("at most 4194304 bytes"), "{}", ran.stderr);
}

#[test]
fn a_results_path_of_any_length_stays_below_the_data_root() {
    let root = tempfile::tempdir().unwrap();
    for name in ["a".repeat(300), "\u{e9}/".repeat(150) + "x", "a/".repeat(3000) + "x"] {
        let text = spec("word ").replace("no/<such> folder", &name);
        std::fs::write(root.path().join("a.toml"), text).unwrap();
        let ran = command(root.path(), &["run", "a.toml", "--allow-missing", "--data-root", "."]);
        assert!([0, 2].contains(&ran.code), "{} {}", ran.code, ran.stderr);
        assert!(!ran.stdout.contains("absent: ok"));
    }
}

const MANIFEST: &str = "results/mine/hostile/manifest.json";

/// Makes `bytes` the results' file `name`, with the digest that the manifest must have for it.
fn replace(root: &Path, name: &str, bytes: &[u8]) {
    let mut manifest: serde_json::Value = serde_json::from_str(&read(root, MANIFEST)).unwrap();
    let digest: String = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
    manifest["files"][name] = digest.into();
    std::fs::write(root.join(MANIFEST), manifest.to_string()).unwrap();
    std::fs::write(root.join("results/mine/hostile").join(name), bytes).unwrap();
}

#[test]
fn names_in_a_manifest_open_no_files() {
    let root = finished();
    std::fs::write(root.path().join("secret.txt"), "secret words").unwrap();
    let mut manifest: serde_json::Value = serde_json::from_str(&read(root.path(), MANIFEST)).unwrap();
    let outside = root.path().join("secret.txt").display().to_string();
    for name in
        ["../../../secret.txt", outside.as_str(), "..\\..\\secret.txt", "/dev/zero", "a\0b", "\u{1b}[2J"]
    {
        manifest["files"][name] = "00".into();
        manifest["suite"]["missing"].as_array_mut().unwrap().push(name.into());
        manifest["differing"].as_array_mut().unwrap().push(name.into());
    }
    std::fs::write(root.path().join(MANIFEST), manifest.to_string()).unwrap();
    let ran = report(root.path());
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let page = read(root.path(), "reports/mine/hostile/index.html");
    assert!(!page.contains("secret words") && shows_only_text(&page));
}

#[test]
fn hostile_manifests_are_refused() {
    let root = finished();
    let good = read(root.path(), MANIFEST);
    let deep = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    for bad in [
        String::new(),
        "{}".into(),
        deep.clone(),
        good.replacen("\"params\": {", &format!("\"params\": {{ \"a\": {deep}, "), 1),
        good.replacen("\"format\": ", "\"format\": 9", 1),
        good.replacen("\"format\": ", "\"format\": -", 1),
        good[..good.len() / 2].to_string(),
    ] {
        std::fs::write(root.path().join(MANIFEST), &bad).unwrap();
        let ran = report(root.path());
        assert_eq!(ran.code, 1, "{}", ran.stderr);
        assert!(ran.stderr.contains("mine/hostile"), "{}", ran.stderr);
    }
    std::fs::File::create(root.path().join(MANIFEST)).unwrap().set_len((64 << 20) + 1).unwrap();
    assert!(report(root.path()).stderr.contains("larger than 64 MiB"));
    std::fs::write(root.path().join(MANIFEST), &good).unwrap();
    assert_eq!(report(root.path()).code, 0);
}

#[test]
fn damaged_tables_with_the_right_digest_are_errors() {
    let root = finished();
    for name in ["frames.parquet", "signals.parquet", "truth.parquet", "measures.csv"] {
        let path = root.path().join("results/mine/hostile").join(name);
        let good = std::fs::read(&path).unwrap();
        let folder = root.path().join("results/mine/hostile");
        let read_all = || {
            let results = Results::read(&folder)?;
            let tracks = results.all_tracks()?;
            let tracks: Vec<_> = tracks.iter().collect();
            results.with_signals(&results.experiment.trackers[0].label, &tracks)?;
            results.truth().map(|truth| truth.len())
        };
        let step = good.len() / 32 + 1;
        for at in (0..good.len()).step_by(step).chain(good.len() - 12..good.len()) {
            let mut bytes = good.clone();
            bytes[at] ^= 0x41;
            replace(root.path(), name, &bytes);
            let _ = read_all();
            replace(root.path(), name, &good[..at]);
            // Fewer lines are a CSV file too.
            assert!(read_all().is_err() || name == "measures.csv", "{name} cut to {at}");
        }
        replace(root.path(), name, &good);
        assert!(read_all().unwrap() > 0);
    }
}

/// The table with every value of some columns replaced.
fn with_values(parquet: &[u8], columns: &[&str], value: f64) -> Vec<u8> {
    let mut table = ParquetReader::new(Cursor::new(parquet)).finish().unwrap();
    let rows = table.height();
    for name in columns {
        let column = match table.column(name).unwrap().dtype() {
            DataType::Int64 => Column::new((*name).into(), vec![value as i64; rows]),
            _ => Column::new((*name).into(), vec![value; rows]),
        };
        table.with_column(column).unwrap();
    }
    let mut bytes = Vec::new();
    ParquetWriter::new(&mut bytes).finish(&mut table).unwrap();
    bytes
}

#[test]
fn absurd_numbers_in_tables_are_drawn_or_refused() {
    let root = finished();
    let results = root.path().join("results/mine/hostile");
    for (name, columns) in [
        ("frames.parquet", &["x", "y", "w", "h"][..]),
        ("frames.parquet", &["error", "score"]),
        ("frames.parquet", &["frame"]),
        ("frames.parquet", &["run"]),
        ("signals.parquet", &["signal", "forecast"]),
        ("truth.parquet", &["x1", "y1", "x2", "y2", "x3", "y3", "x4", "y4"]),
    ] {
        let good = std::fs::read(results.join(name)).unwrap();
        for value in [f64::NAN, f64::INFINITY, -1e308, 5e-324, 4_294_967_295.0] {
            replace(root.path(), name, &with_values(&good, columns, value));
            let read = Results::read(&results).unwrap();
            let _ = trackfail::report::write(&read, &root.path().join("out"));
        }
        replace(root.path(), name, &good);
    }
    assert_eq!(report(root.path()).code, 0);
}

#[cfg(unix)]
mod links {
    use super::*;
    use std::os::unix::fs::symlink;

    const RESULTS: &str = "results/mine/hostile";

    fn outside(root: &Path) -> PathBuf {
        trackfail_testing::put(root, "outside/kept.txt", "kept");
        root.join("outside")
    }

    fn is_untouched(outside: &Path) -> bool {
        let names: Vec<_> = std::fs::read_dir(outside).unwrap().map(|e| e.unwrap().file_name()).collect();
        names == ["kept.txt"] && std::fs::read_to_string(outside.join("kept.txt")).unwrap() == "kept"
    }

    #[test]
    fn nothing_is_written_through_a_link() {
        let root = tempfile::tempdir().unwrap();
        let outside = outside(root.path());
        let (results, reports) = (root.path().join(RESULTS), root.path().join("reports/mine/hostile"));
        std::fs::create_dir_all(&results).unwrap();
        std::fs::create_dir_all(&reports).unwrap();
        for name in ["manifest.json", "scores.csv", "measures.csv", "frames.parquet", "experiment.toml"] {
            symlink(outside.join("kept.txt"), results.join(name)).unwrap();
        }
        for name in ["index.html", "report.md"] {
            symlink(outside.join("kept.txt"), reports.join(name)).unwrap();
        }
        for folder in [results.join("tables"), results.join("stills"), reports.join("figures")] {
            symlink(&outside, folder).unwrap();
        }
        let ran = run(root.path(), "word ", "d");
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        assert!(is_untouched(&outside));
        for name in ["manifest.json", "scores.csv", "tables", "stills"] {
            assert!(!results.join(name).is_symlink(), "{name}");
        }
        assert!(!reports.join("index.html").is_symlink() && reports.join("figures/f.svg").is_file());

        // Rendered alone, the results are somebody else's: their files are replaced, their folders not entered.
        std::fs::remove_file(results.join("tables/t.csv")).unwrap();
        symlink(outside.join("kept.txt"), results.join("tables/t.csv")).unwrap();
        assert_eq!(report(root.path()).code, 0);
        assert!(is_untouched(&outside) && !results.join("tables/t.csv").is_symlink());
        std::fs::remove_dir_all(results.join("tables")).unwrap();
        symlink(&outside, results.join("tables")).unwrap();
        let ran = report(root.path());
        assert_eq!(ran.code, 1);
        assert!(ran.stderr.contains("tables: a link"), "{}", ran.stderr);
        assert!(is_untouched(&outside));
    }

    #[test]
    fn links_are_followed_for_reading_but_not_to_devices() {
        let root = finished();
        let results = root.path().join(RESULTS);
        std::fs::rename(results.join("measures.csv"), root.path().join("elsewhere.csv")).unwrap();
        symlink(root.path().join("elsewhere.csv"), results.join("measures.csv")).unwrap();
        assert_eq!(report(root.path()).code, 0);
        for name in ["measures.csv", "manifest.json"] {
            std::fs::remove_file(results.join(name)).unwrap();
            symlink("/dev/zero", results.join(name)).unwrap();
            let ran = report(root.path());
            assert_eq!(ran.code, 1);
            assert!(ran.stderr.contains(name) && ran.stderr.contains("not a file"), "{}", ran.stderr);
        }
    }

    #[test]
    fn linked_sequences_are_read() {
        let root = tempfile::tempdir().unwrap();
        trackfail()
            .args(["data", "render", "synthetic-otb", "--sequence", "Girl"])
            .arg(root.path().join("s"))
            .assert()
            .success();
        symlink(root.path().join("s/Girl"), root.path().join("linked")).unwrap();
        let boxes = "s/Girl/groundtruth_rect.txt";
        let detect = |frames| {
            command(root.path(), &["detect", "--frames", frames, "--boxes", boxes, "--method", "RAW"])
        };
        let (direct, linked) = (detect("s/Girl"), detect("linked"));
        assert_eq!((direct.code, linked.code), (0, 0), "{}", linked.stderr);
        assert!(!direct.stdout.is_empty() && direct.stdout == linked.stdout);
    }
}
