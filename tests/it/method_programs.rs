//! Signals and detectors as programs: the examples of the documentation, and programs that fail, in a whole run.

use crate::tools::{needs, rows, trackfail};
use std::path::{Path, PathBuf};
use std::process::Output;

/// An experiment on rendered sequences with one method.
struct Place {
    dir: tempfile::TempDir,
}

impl Place {
    fn new(method: &str) -> Self {
        let place = Self { dir: tempfile::tempdir().unwrap() };
        let text = format!(
            "schema = 1\nname = \"mine/try\"\ntitle = \"A try\"\nprotocol = \"khalid2016/1\"\n\
             [suites]\ntest = \"synthetic-otb\"\n[[tracker]]\nname = \"scripted\"\n{method}\n\
             [[table]]\nname = \"t\"\nrows = [\"recall\"]\ncolumns = \"tracker\"\nmethods = [\"Mine\"]\n"
        );
        std::fs::write(place.path("try.toml"), text).unwrap();
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn run(&self, plugins: &Path) -> Output {
        let mut command = trackfail();
        command.arg("run").arg(self.path("try.toml")).arg("--plugins").arg(plugins);
        command.arg("--results").arg(self.path("results")).arg("--reports").arg(self.path("reports"));
        command.output().unwrap()
    }

    /// A column of the scores of the cells.
    fn column(&self, column: &str) -> Vec<String> {
        let text = std::fs::read_to_string(self.path("results/mine/try/scores.csv")).unwrap();
        let cells = rows(&text).into_iter().filter(|row| row["sequence"] != "*");
        cells.map(|row| row[column].clone()).collect()
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

// The built-in detector `level` labels what the example does with one frame in a row.
#[needs(python)]
#[test]
fn the_examples_of_the_documentation_judge_tracks() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/examples/plugins.toml");
    let method = |detector: &str| {
        format!(
            "[[method]]\nname = \"Mine\"\n\
             signal = {{ kind = \"process\", program = \"size\", good = \"low\", params = {{ rate = 0.2 }} }}\n\
             detector = {detector}"
        )
    };
    let python = "{ kind = \"process\", program = \"patient\", params = { above = 0.05, frames = 1 } }";
    let places = [python, "{ kind = \"level\", above = 0.05 }"].map(|detector| Place::new(&method(detector)));
    for place in &places {
        let output = place.run(&examples);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    let counts = |place: &Place| ["tp", "fp", "fn"].map(|column| place.column(column));
    let [ours, level] = [0, 1].map(|k| counts(&places[k]));
    assert_eq!(ours, level);
    assert!(ours[0].iter().chain(&ours[1]).any(|count| count != "0"), "no detection at all");
}

#[test]
fn a_program_that_fails_fails_its_cells_with_the_reason() {
    for (kind, method) in [
        (
            "signal",
            "signal = { kind = \"process\", program = \"mine\" }\ndetector = { kind = \"level\", below = 0.5 }",
        ),
        (
            "detector",
            "signal = { kind = \"box-motion\" }\ndetector = { kind = \"process\", program = \"mine\" }",
        ),
    ] {
        let place = Place::new(&format!("[[method]]\nname = \"Mine\"\n{method}"));
        let plugins = place.path("plugins.toml");
        let command =
            "command = [\"sh\", \"-c\", \"read -r meta; read -r line; echo 'no memory' >&2; exit 7\"]";
        std::fs::write(&plugins, format!("[{kind}.mine]\n{command}\nversion = \"1\"\n")).unwrap();
        let output = place.run(&plugins);
        assert_eq!(output.status.code(), Some(4), "{}", stderr(&output));
        let scores = std::fs::read_to_string(place.path("results/mine/try/scores.csv")).unwrap();
        let cells: Vec<&str> = scores.lines().skip(1).filter(|line| !line.contains(",*,")).collect();
        assert!(!cells.is_empty());
        for cell in cells {
            // No count in its place.
            assert!(cell.contains(",Mine,,,,,,,,,,,,\"failed: "), "{cell}");
            assert!(cell.contains("it ended (exit status: 7)") && cell.contains("no memory"), "{cell}");
        }
        // Programs are named in a file of one's own.
        std::fs::write(&plugins, "").unwrap();
        let output = place.run(&plugins);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(&format!("names no {kind}")), "{}", stderr(&output));
    }
}
