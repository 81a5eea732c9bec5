//! Experiments, data and results from somebody who means harm: texts stay texts, files stay in their folders.

use crate::tools::{Place, Ran, files, needs};
use polars::prelude::{Column, DataType, ParquetReader, ParquetWriter, SerReader};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::sync::LazyLock;
use trackfail::results::Results;
use trackfail_testing::conditions::{LATEX, runs};
use trackfail_testing::hostile::{self, shows_only_text};

/// An experiment in which every free text is `text`; its results are looked for in a folder that is absent.
fn spec(text: &str) -> String {
    // In TOML's quotes.
    let text = serde_json::to_string(text).unwrap().replace('\u{7f}', "\\u007f");
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
         [[claim]]\ntext = {text}\nholds = \"recall[*<i>, absent] > 1\"\n"
    )
}

/// The end of a run that is no panic, which ends with 101.
fn ran(command: &mut assert_cmd::Command) -> Ran {
    let ran = Ran::of(command);
    assert!(ran.code.is_some_and(|code| (0..=5).contains(&code)), "{ran:?}");
    ran
}

/// A place with the results of an experiment, its data root below it with a name as bad as a file's can be.
fn run(text: &str, data: &str) -> (Place, Ran) {
    let place = Place::with(&[("a.toml", &spec(text))]);
    place.folder(data);
    let ran = ran(place.command("run a.toml --allow-missing --data-root").arg(data)).ends(0);
    (place, ran)
}

/// A new place with the results of a run with harmless texts, which is made once.
fn finished() -> Place {
    static FILES: LazyLock<BTreeMap<PathBuf, Vec<u8>>> =
        LazyLock::new(|| files(run("word word ", "d").0.root()));
    let place = Place::new();
    FILES.iter().for_each(|(name, bytes)| place.write(name.to_str().unwrap(), bytes));
    place
}

fn report(place: &Place) -> Ran {
    ran(&mut place.command("report mine/hostile"))
}

/// All hostile words but the long one.
fn all_words() -> String {
    hostile::words()[..8].join("\n")
}

#[needs(latex)]
#[test]
fn hostile_tables_compile() {
    let (place, _) = run(&all_words(), "d");
    let folder = place.path("results/mine/hostile/tables");
    let engine = LATEX.into_iter().find(|name| runs(name, &["--version"]));
    let engine = engine.expect("the LaTeX that was there when this test was compiled has gone");
    let macros = place.read("results/mine/hostile/tables/macros.tex");
    let names = macros.lines().filter_map(|l| l.strip_prefix("\\tfset{")?.split_once('}'));
    let names: Vec<String> = names.map(|(name, _)| format!("\\tf{{{name}}}")).collect();
    let document = format!(
        "\\documentclass{{article}}\n\\usepackage{{booktabs,graphicx,siunitx}}\n\\input{{macros}}\n\\begin{{document}}\n\
         \\input{{t.tex}}\n\\input{{t.body.tex}}\n{}\n\\end{{document}}\n",
        names.join(" "),
    );
    std::fs::write(folder.join("all.tex"), document).unwrap();
    let mut command = assert_cmd::Command::new(engine);
    // Without a question.
    if engine != "tectonic" {
        command.args(["-interaction=nonstopmode", "-halt-on-error"]);
    }
    Ran::of(command.arg("all.tex").current_dir(&folder)).ends(0);
    assert!(folder.join("all.pdf").exists() && !names.is_empty());
}

#[test]
fn hostile_texts_are_texts_everywhere() {
    let data = "=<d>&\"'$#|`\u{1b}[31m\u{202e}\\x";
    let (bad, told) = run(&all_words(), data);
    let told = told.says("<script>").says("not there: ");
    assert!(shows_only_text(&told.out), "{:?}", told.out);
    // What a person reads has the structure that it has with harmless texts.
    let good = finished();
    let [page, md] = ["index.html", "report.md"]
        .map(|name| [&bad, &good].map(|place| place.read(&format!("reports/mine/hostile/{name}"))));
    assert_eq!(hostile::elements(&page[0]), hostile::elements(&page[1]));
    assert!(page[0].contains("&lt;script&gt;alert("));
    // Cells, headings and other markup, by line; a table by itself and a figure have tests beside their writers.
    let marks = |text: &str| -> (Vec<char>, usize) {
        let read = hostile::markdown(text);
        (read.split('\u{1}').skip(1).filter_map(|part| part.chars().next()).collect(), text.lines().count())
    };
    assert_eq!(marks(&md[0]), marks(&md[1]));

    // The names in CSV files are no formulas; they are checked where they come in.
    for name in ["scores.csv", "measures.csv", "tables/t.csv"] {
        for field in hostile::csv(&bad.read(&format!("results/mine/hostile/{name}"))).concat() {
            let number = field.parse::<f64>().is_ok();
            assert!(number || !field.starts_with(['=', '+', '-', '@', '\t', '\r']), "{name}: {field}");
        }
    }
    // Rendered again from the results alone, everything stays as it is.
    report(&bad).ends(0);
    assert_eq!(bad.read("reports/mine/hostile/index.html"), page[0]);
}

#[test]
fn messages_do_not_reach_the_terminal_raw() {
    let place = Place::new();
    let name = "\u{1b}[31m\u{202e}a.toml";
    for text in ["\"\\u001b[2J\\u009b1m\" = 1", "schema = 1\nname = \"\\u001b]0;x\\u0007\"", "\u{1b}[2J"] {
        place.write(name, text);
        let told = ran(place.command("run").arg(name)).ends(2).tells("a.toml:");
        assert!(shows_only_text(&told.err), "{:?}", told.err);
    }
    let told = ran(place.command("run").arg("\u{1b}[2Jabsent\u{9b}")).ends(2);
    assert!(shows_only_text(&told.err), "{:?}", told.err);
}

#[test]
fn a_results_path_of_any_length_stays_below_the_data_root() {
    let place = Place::new();
    for name in ["a".repeat(300), "\u{e9}/".repeat(150) + "x", "a/".repeat(3000) + "x"] {
        place.write("a.toml", spec("word ").replace("no/<such> folder", &name));
        let told = place.run("run a.toml --allow-missing --data-root .").never_says("absent: ok");
        assert!(matches!(told.code, Some(0 | 2)), "{told:?}");
    }
}

const RESULTS: &str = "results/mine/hostile";
const MANIFEST: &str = "results/mine/hostile/manifest.json";

/// Makes `bytes` the results' file `name`, with the digest that the manifest must have for it.
fn replace(place: &Place, name: &str, bytes: &[u8]) {
    let mut manifest = place.json(MANIFEST);
    manifest["files"][name] = crate::fetch::sha256(bytes).into();
    place.write(MANIFEST, manifest.to_string());
    place.write(&format!("{RESULTS}/{name}"), bytes);
}

#[test]
fn hostile_manifests_open_no_files() {
    let place = finished();
    let good = place.read(MANIFEST);
    place.write("secret.txt", "secret words");
    let mut manifest = place.json(MANIFEST);
    let outside = place.path("secret.txt").display().to_string();
    for name in
        ["../../../secret.txt", outside.as_str(), "..\\..\\secret.txt", "/dev/zero", "a\0b", "\u{1b}[2J"]
    {
        manifest["files"][name] = "00".into();
        manifest["suite"]["missing"].as_array_mut().unwrap().push(name.into());
        manifest["differing"].as_array_mut().unwrap().push(name.into());
    }
    place.write(MANIFEST, manifest.to_string());
    report(&place).ends(0);
    let page = place.read("reports/mine/hostile/index.html");
    assert!(!page.contains("secret words") && shows_only_text(&page));

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
        place.write(MANIFEST, &bad);
        report(&place).ends(1).tells("mine/hostile");
    }
    std::fs::File::create(place.path(MANIFEST)).unwrap().set_len((64 << 20) + 1).unwrap();
    report(&place).tells("larger than 64 MiB");
    place.write(MANIFEST, &good);
    report(&place).ends(0);
}

#[test]
fn damaged_tables_with_the_right_digest_are_errors() {
    let place = finished();
    let read_all = || {
        let results = Results::read(&place.path(RESULTS))?;
        let tracks = results.all_tracks()?;
        let tracks: Vec<_> = tracks.iter().collect();
        results.with_signals(&tracks)?;
        results.truth().map(|truth| truth.len())
    };
    for name in ["frames.parquet", "signals.parquet", "truth.parquet", "measures.csv"] {
        let good = place.bytes(&format!("{RESULTS}/{name}"));
        for at in (0..good.len()).step_by(good.len() / 32 + 1).chain(good.len() - 12..good.len()) {
            let mut bytes = good.clone();
            bytes[at] ^= 0x41;
            replace(&place, name, &bytes);
            let _ = read_all();
            replace(&place, name, &good[..at]);
            // Fewer lines are a CSV file too.
            assert!(read_all().is_err() || name == "measures.csv", "{name} cut to {at}");
        }
        replace(&place, name, &good);
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
    let place = finished();
    for (name, columns) in [
        ("frames.parquet", &["x", "y", "w", "h"][..]),
        ("frames.parquet", &["error", "score"]),
        ("frames.parquet", &["frame"]),
        ("frames.parquet", &["run"]),
        ("signals.parquet", &["signal", "forecast"]),
        ("truth.parquet", &["x1", "y1", "x2", "y2", "x3", "y3", "x4", "y4"]),
    ] {
        let good = place.bytes(&format!("{RESULTS}/{name}"));
        for value in [f64::NAN, f64::INFINITY, -1e308, 5e-324, 4_294_967_295.0] {
            replace(&place, name, &with_values(&good, columns, value));
            let read = Results::read(&place.path(RESULTS)).unwrap();
            let _ = trackfail::report::write(&read, &place.path("out"));
        }
        replace(&place, name, &good);
    }
    report(&place).ends(0);
}

#[test]
fn nothing_is_written_through_a_link() {
    let place = Place::with(&[("a.toml", &spec("word ")), ("outside/kept.txt", "kept")]);
    let outside = place.path("outside");
    let is_untouched = || place.list("outside").len() == 1 && place.read("outside/kept.txt") == "kept";
    let (results, reports) = (place.folder(RESULTS), place.folder("reports/mine/hostile"));
    for name in ["manifest.json", "scores.csv", "measures.csv", "frames.parquet", "experiment.toml"] {
        symlink(outside.join("kept.txt"), results.join(name)).unwrap();
    }
    for name in ["index.html", "report.md"] {
        symlink(outside.join("kept.txt"), reports.join(name)).unwrap();
    }
    for folder in [results.join("tables"), results.join("stills"), reports.join("figures")] {
        symlink(&outside, folder).unwrap();
    }
    place.folder("d");
    place.run("run a.toml --allow-missing --data-root d").ends(0);
    assert!(is_untouched());
    for name in ["manifest.json", "scores.csv", "tables", "stills"] {
        assert!(!results.join(name).is_symlink(), "{name}");
    }
    assert!(!reports.join("index.html").is_symlink() && reports.join("figures/f.svg").is_file());

    // Rendered alone, the results are somebody else's: their files are replaced, their folders not entered.
    std::fs::remove_file(results.join("tables/t.csv")).unwrap();
    symlink(outside.join("kept.txt"), results.join("tables/t.csv")).unwrap();
    report(&place).ends(0);
    assert!(is_untouched() && !results.join("tables/t.csv").is_symlink());
    std::fs::remove_dir_all(results.join("tables")).unwrap();
    symlink(&outside, results.join("tables")).unwrap();
    report(&place).ends(1).tells("tables: a link");
    assert!(is_untouched());
}

#[test]
fn links_are_followed_for_reading_but_not_to_devices() {
    let place = finished();
    let results = place.path(RESULTS);
    std::fs::rename(results.join("measures.csv"), place.path("elsewhere.csv")).unwrap();
    symlink(place.path("elsewhere.csv"), results.join("measures.csv")).unwrap();
    report(&place).ends(0);
    for name in ["measures.csv", "manifest.json"] {
        place.remove(&format!("{RESULTS}/{name}"));
        symlink("/dev/zero", results.join(name)).unwrap();
        report(&place).ends(1).tells(name).tells("not a file");
    }
}

#[test]
fn linked_sequences_are_read() {
    let place = Place::new();
    place.render("synthetic-otb", "Girl");
    symlink(place.path("suite/Girl"), place.path("linked")).unwrap();
    let detect = |frames: &str| {
        let boxes = "--boxes suite/Girl/groundtruth_rect.txt --method RAW";
        place.run(&format!("detect --frames {frames} {boxes}")).ends(0).out
    };
    let direct = detect("suite/Girl");
    assert!(!direct.is_empty() && direct == detect("linked"));
}
