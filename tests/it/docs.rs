//! The documents: their shell blocks run, their quotes are the files, their links lead somewhere.

use crate::sent::keep;
use crate::tools::{Place, needs};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The Markdown files of a reader, as paths from the checkout.
fn documents() -> Vec<String> {
    let files = std::fs::read_dir(root().join("docs")).unwrap();
    let names = files.map(|file| format!("docs/{}", file.unwrap().file_name().display()));
    let pages: BTreeSet<String> = names.filter(|name| name.ends_with(".md")).collect();
    let others = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"];
    others.map(String::from).into_iter().chain(pages).collect()
}

/// A fenced block, with the comment before it that says whether and how it is run.
struct Block {
    place: String,
    language: String,
    text: String,
    comment: Option<String>,
}

impl Block {
    /// The text behind a word of the comment: `<!-- not-run: why -->`.
    fn marked(&self, word: &str) -> Option<&str> {
        let inside = self.comment.as_deref()?.strip_prefix("<!-- ")?.strip_suffix(" -->")?;
        inside.strip_prefix(word)?.strip_prefix(": ")
    }
}

fn blocks(document: &str) -> Vec<Block> {
    let text = read(document);
    let mut lines = text.lines().enumerate();
    let (mut found, mut before) = (Vec::new(), String::new());
    while let Some((number, line)) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let body = lines.by_ref().map(|(_, line)| line).take_while(|line| *line != "```");
            let text = body.map(|line| format!("{line}\n")).collect();
            let comment = before.starts_with("<!--").then(|| before.clone());
            let place = format!("{document}:{}", number + 1);
            found.push(Block { place, language: language.into(), text, comment });
        }
        before = line.into();
    }
    found
}

#[test]
fn every_shell_block_is_run_or_says_why_not() {
    let languages = ["sh", "console", "text", "toml", "python", "rust"];
    for document in documents() {
        for block in blocks(&document) {
            assert!(languages.contains(&&*block.language), "{}: `{}`", block.place, block.language);
            let comment = block.comment.as_deref().unwrap_or_default();
            let is_known = ["", "<!-- END -->"].contains(&comment)
                || comment.starts_with("<!-- BEGIN: ")
                || block.marked("not-run").is_some_and(|reason| reason.len() > 10)
                || ["real data", "ffmpeg", "GNU parallel"].map(Some).contains(&block.marked("needs"));
            assert!(is_known, "{}: {comment}", block.place);
        }
    }
}

/// A folder with what the documents' commands find: frames with boxes, an experiment, the kept quickstart.
fn working_folder() -> Place {
    let place = Place::new();
    place.write("boxes.txt", place.render("synthetic-otb", "Tennis").join("\n") + "\n");
    std::fs::rename(place.path("suite/Tennis/img"), place.path("video")).unwrap();
    std::fs::remove_dir_all(place.path("suite")).unwrap();
    let experiment = blocks("docs/experiments.md").into_iter().find(|b| b.text.starts_with("schema = 1"));
    place.write("my.toml", experiment.expect("a whole experiment").text);
    keep(&place, "quickstart");
    place
}

/// Runs the blocks that are marked as needing something, of which there are some, or those that are not marked at all; of each
/// all commands until one fails.
fn run_blocks(need: Option<&str>, place: &Place) {
    let blocks = documents().into_iter().flat_map(|document| blocks(&document));
    let is_one = |b: &Block| if need.is_some() { b.marked("needs") == need } else { b.comment.is_none() };
    let blocks: Vec<Block> = blocks.filter(|block| block.language == "sh").filter(is_one).collect();
    assert!(!blocks.is_empty());
    for Block { place: name, text, .. } in blocks {
        let text = text.replace("--release -- ", "-- ").replace("cargo run -- ", "trackfail ");
        let ran = place.shell(&format!("set -eu\n{text}"));
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.err);
    }
}

#[test]
fn shell_blocks_run() {
    run_blocks(None, &working_folder());
}

#[needs(real_data)]
#[test]
fn shell_blocks_that_need_real_data_run() {
    let place = Place::new();
    let data = trackfail_testing::real_data().canonicalize().unwrap();
    std::os::unix::fs::symlink(data, place.path("DATA")).unwrap();
    run_blocks(Some("real data"), &place);
}

#[needs(ffmpeg)]
#[test]
fn shell_blocks_that_need_ffmpeg_run() {
    let place = working_folder();
    place.shell("ffmpeg -nostdin -v error -i video/%04d.png clip.mp4").ends(0);
    run_blocks(Some("ffmpeg"), &place);
}

#[needs(parallel)]
#[test]
fn shell_blocks_that_need_gnu_parallel_run() {
    let place = working_folder();
    run_blocks(Some("GNU parallel"), &place);
    // Nothing was left to the last run but tables and report.
    let told = place.run("run my.toml --results shared --dry-run --shard 1/4 --format csv").out;
    assert_eq!(told.matches(",done,").count(), 4, "{told}");
}

#[test]
fn quoted_programs_are_the_files() {
    let quotes = [
        ("docs/your-own-tracker.md", "python", "examples/line_tracker.py"),
        ("docs/adding-a-method.md", "rust", "docs/examples/deviation.rs"),
        ("docs/adding-a-method.md", "python", "docs/examples/size_signal.py"),
        ("docs/adding-a-method.md", "python", "docs/examples/patient_detector.py"),
        ("docs/adding-a-method.md", "toml", "docs/examples/plugins.toml"),
    ];
    for (document, language, file) in quotes {
        let found = blocks(document).into_iter().any(|b| b.language == language && b.text == read(file));
        assert!(found, "{document} does not quote {file} as it is");
    }
}

/// The targets of `[text](target)` that are files, as paths from the checkout.
fn links(document: &str) -> Vec<PathBuf> {
    let text = read(document);
    let folder = Path::new(document).parent().unwrap();
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(target, _)| target));
    let targets = targets.map(|target| target.split('#').next().unwrap_or_default());
    targets.filter(|t| !t.is_empty() && !t.contains("://")).map(|target| folder.join(target)).collect()
}

#[test]
fn links_lead_to_files() {
    for document in documents() {
        for target in links(&document) {
            assert!(root().join(&target).exists(), "{document}: {}", target.display());
        }
    }
}

#[test]
fn the_book_has_every_page() {
    let listed: BTreeSet<String> = links("docs/SUMMARY.md").iter().map(|p| p.display().to_string()).collect();
    let pages = documents().into_iter().filter(|name| name.starts_with("docs/") && name != "docs/SUMMARY.md");
    assert_eq!(listed, pages.collect());
}

#[test]
fn the_readme_is_short_and_shows_the_verdict_of_its_page() {
    let text = read("README.md");
    assert!(text.len() < 9 * 1024 && text.lines().count() <= 100, "{} {}", text.len(), text.lines().count());
    let verdicts: Vec<Block> = blocks("README.md").into_iter().filter(|b| b.language == "text").collect();
    assert!(verdicts.len() == 1 && read("docs/your-own-tracker.md").contains(&verdicts[0].text));
}

#[test]
fn the_version_is_the_same_everywhere() {
    let version = env!("CARGO_PKG_VERSION");
    assert!(read("CITATION.cff").contains(&format!("\nversion: {version}\n")));
    for file in ["python/Cargo.toml", "python/program/pyproject.toml"] {
        assert!(read(file).contains(&format!("\nversion = \"{version}\"\n")), "{file}");
    }
    assert!(read("CHANGELOG.md").contains("\n## [Unreleased]\n"));
}

/// The rows of the table below a heading of ARCHITECTURE.md, without its head; backticks are left out.
fn table(heading: &str) -> Vec<Vec<String>> {
    let text = read("ARCHITECTURE.md");
    let section = text.split(&format!("\n## {heading}\n")).nth(1).unwrap_or_else(|| panic!("{heading}"));
    let rows = section.split("\n## ").next().unwrap().lines().filter(|line| line.starts_with('|')).skip(2);
    rows.map(|row| row.trim_matches('|').split('|').map(|cell| cell.trim().replace('`', "")).collect())
        .collect()
}

#[test]
fn changes_go_where_the_map_says() {
    let rows = table("Where each change goes");
    assert!(rows.len() >= 10, "{}", rows.len());
    for row in rows {
        let [change, new, list, word] = &row[..] else { panic!("{row:?}") };
        for file in [new, list].into_iter().filter(|file| !file.is_empty()) {
            // `<name>` stands for a file that does not exist yet.
            let path = if file.contains('<') { Path::new(file).parent().unwrap() } else { Path::new(file) };
            assert!(root().join(path).exists(), "{change}: {file}");
        }
        if !list.is_empty() {
            assert!(read(list).contains(&**word), "{change}: {list} has no `{word}`");
        }
    }
}

#[test]
fn the_map_has_every_module() {
    let text = read("ARCHITECTURE.md");
    for folder in std::fs::read_dir(root().join("crates")).unwrap() {
        let name = folder.unwrap().file_name().to_string_lossy().into_owned();
        assert!(text.contains(&format!("`crates/{name}`")), "crates/{name}");
    }
    let map = read("src/lib.rs");
    let modules = map.lines().filter_map(|l| l.strip_prefix("pub mod ")?.strip_suffix(';'));
    modules.for_each(|module| assert!(text.contains(&format!("`{module}`")), "{module}"));
}
