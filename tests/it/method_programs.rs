//! Signals and detectors as programs: the examples of the documentation, and programs that fail, in a whole run.

use crate::tools::{Place, needs};

/// A place with an experiment on rendered sequences with one method.
fn place(method: &str) -> Place {
    let text = format!(
        "schema = 1\nname = \"mine/try\"\ntitle = \"A try\"\nprotocol = \"khalid2016/1\"\n\
         [suites]\ntest = \"synthetic-otb\"\n[[tracker]]\nname = \"scripted\"\n[[method]]\nname = \"Mine\"\n\
         {method}\n\
         [[table]]\nname = \"t\"\nrows = [\"recall\"]\ncolumns = \"tracker\"\nmethods = [\"Mine\"]\n"
    );
    Place::with(&[("try.toml", &text)])
}

const SCORES: &str = "results/mine/try/scores.csv";

// The built-in detector `level` labels what the example does with one frame in a row.
#[needs(python)]
#[test]
fn the_examples_of_the_documentation_judge_tracks() {
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/examples/plugins.toml");
    let python = "{ kind = \"process\", program = \"patient\", params = { above = 0.05, frames = 1 } }";
    let [ours, level] = [python, "{ kind = \"level\", above = 0.05 }"].map(|detector| {
        let signal = "{ kind = \"process\", program = \"size\", good = \"low\", params = { rate = 0.2 } }";
        let place = place(&format!("signal = {signal}\ndetector = {detector}"));
        place.run(&format!("run try.toml --plugins '{examples}'")).ends(0);
        let mut cells = place.rows(SCORES);
        cells.retain(|row| row["sequence"] != "*");
        ["tp", "fp", "fn"].map(|column| cells.iter().map(|row| row[column].clone()).collect::<Vec<_>>())
    });
    assert_eq!(ours, level);
    assert!(ours[0].iter().chain(&ours[1]).any(|count| count != "0"), "no detection at all");
}

#[test]
fn a_program_that_fails_fails_its_cells_with_the_reason() {
    let mine = "{ kind = \"process\", program = \"mine\" }";
    for (kind, signal, detector) in [
        ("signal", mine, "{ kind = \"level\", below = 0.5 }"),
        ("detector", "{ kind = \"box-motion\" }", mine),
    ] {
        let place = place(&format!("signal = {signal}\ndetector = {detector}"));
        let command =
            "command = [\"sh\", \"-c\", \"read -r meta; read -r line; echo 'no memory' >&2; exit 7\"]";
        place.write("plugins.toml", format!("[{kind}.mine]\n{command}\nversion = \"1\"\n"));
        place.run("run try.toml --plugins plugins.toml").ends(4);
        let scores = place.read(SCORES);
        let cells: Vec<&str> = scores.lines().skip(1).filter(|line| !line.contains(",*,")).collect();
        assert!(!cells.is_empty());
        for cell in cells {
            // No count in its place.
            assert!(cell.contains(",Mine,,,,,,,,,,,,\"failed: "), "{cell}");
            assert!(cell.contains("it ended (exit status: 7)") && cell.contains("no memory"), "{cell}");
        }
        // Programs are named in a file of one's own.
        place.write("plugins.toml", "");
        let told = format!("names no {kind}");
        place.run("run try.toml --plugins plugins.toml").ends(2).tells(&told);
    }
}
