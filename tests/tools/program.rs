//! Starts the program as the tests do, in a folder of its own, and asks what it came to.

// Each of the two programs of tests uses its part.
#![allow(dead_code, unused_imports)]

#[path = "live.rs"]
pub mod live;
#[path = "page.rs"]
pub mod page;
#[path = "slurm.rs"]
pub mod slurm;

use assert_cmd::Command;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
pub use trackfail_testing::{assert_same_files, assert_says, files, needs, real_data, rows};
use trackfail_testing::{folder, put};

/// The program, in an environment without the user's settings.
pub fn trackfail() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trackfail"));
    command.env_remove("TRACKFAIL_DATA").env_remove("TRACKFAIL_PLUGINS").env_remove("HOME");
    command
}

/// The words of a line; one with blanks in it stands between `'`.
pub fn words(line: &str) -> Vec<String> {
    let part = |(k, part): (usize, &str)| -> Vec<String> {
        if k % 2 == 1 { vec![part.into()] } else { part.split_whitespace().map(String::from).collect() }
    };
    line.split('\'').enumerate().flat_map(part).collect()
}

/// An experiment by the protocol of 2016 with what `rest` says of it.
pub fn experiment(name: &str, suite: &str, rest: &str) -> String {
    let head = "schema = 1\ntitle = \"A try\"\nprotocol = \"khalid2016/1\"";
    format!("{head}\nname = \"{name}\"\nsuites.test = \"{suite}\"\n{rest}")
}

/// A row of a CSV file by the names of its columns.
pub type Row = BTreeMap<String, String>;

/// The number in a column.
#[track_caller]
pub fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {row:?}"))
}

/// A folder in which a test runs the program; names of files are those below it.
pub struct Place(tempfile::TempDir);

impl Place {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn with(files: &[(&str, &str)]) -> Self {
        Self(folder(files.iter().copied()))
    }

    pub fn root(&self) -> &Path {
        self.0.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file, and makes its folder.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        put(self.root(), name, bytes);
    }

    pub fn folder(&self, name: &str) -> PathBuf {
        std::fs::create_dir_all(self.path(name)).unwrap();
        self.path(name)
    }

    /// Writes frames with numbers from 1 to `last` in place of the zeros of `name`; a pixel is one of the index of the frame and a place.
    pub fn frames(&self, name: &str, last: u32, size: (u32, u32), pixel: impl Fn(u32, u32, u32) -> [u8; 3]) {
        let (folder, file) = name.rsplit_once('/').unwrap_or(("", name));
        let (zeros, ending) = file.split_once('.').unwrap();
        let (folder, width) = (self.folder(folder), zeros.len());
        for t in 0..last {
            let frame = image::RgbImage::from_fn(size.0, size.1, |x, y| image::Rgb(pixel(t, x, y)));
            frame.save(folder.join(format!("{:0width$}.{ending}", t + 1))).unwrap();
        }
    }

    #[track_caller]
    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    #[track_caller]
    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    #[track_caller]
    pub fn rows(&self, name: &str) -> Vec<Row> {
        rows(&self.read(name))
    }

    #[track_caller]
    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Asserts that a file has these words, and not the others.
    #[track_caller]
    pub fn holds(&self, name: &str, all: &[&str], none: &[&str]) {
        let text = self.read(name);
        let has = |words: &&str| text.contains(*words);
        assert!(all.iter().all(has) && !none.iter().any(has), "{name}: {all:?}, not {none:?}\n{text}");
    }

    pub fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    pub fn remove(&self, name: &str) {
        std::fs::remove_file(self.path(name)).unwrap();
    }

    /// Files and folders in a folder, in the order of their names.
    pub fn list(&self, folder: &str) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.path(folder)).unwrap_or_else(|e| panic!("{folder}: {e}"));
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        paths
    }

    /// Renders a sequence below the folder `suite`, and gives the lines of its ground truth.
    pub fn render(&self, suite: &str, sequence: &str) -> Vec<String> {
        self.run(&format!("data render {suite} --sequence {sequence} suite")).ends(0);
        self.read(&format!("suite/{sequence}/groundtruth_rect.txt")).lines().map(String::from).collect()
    }

    pub fn command(&self, line: &str) -> Command {
        let mut command = trackfail();
        command.current_dir(self.root()).args(words(line));
        command
    }

    pub fn run(&self, line: &str) -> Ran {
        Ran::of(&mut self.command(line))
    }

    /// Runs a line of a shell. Its PATH, which programs that it starts have too, begins with the folder of this program.
    pub fn shell(&self, line: &str) -> Ran {
        let own = Path::new(env!("CARGO_BIN_EXE_trackfail")).parent().unwrap().display();
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("PATH='{own}':\"$PATH\"\n{line}")]).current_dir(self.root());
        Ran::of(shell.env_remove("TRACKFAIL_DATA").env_remove("TRACKFAIL_PLUGINS"))
    }
}

/// The end of a run: its exit code and its output.
#[derive(Debug)]
pub struct Ran {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ran {
    pub fn of(command: &mut Command) -> Self {
        let output = command.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        Self { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    /// Asserts the exit code.
    #[track_caller]
    pub fn ends(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{}{}", self.out, self.err);
        self
    }

    /// Asserts that words are on stdout.
    #[track_caller]
    pub fn says(self, words: &str) -> Self {
        assert!(self.out.contains(words), "{words}\n{}{}", self.out, self.err);
        self
    }

    /// Asserts that words are on stderr.
    #[track_caller]
    pub fn tells(self, words: &str) -> Self {
        assert!(self.err.contains(words), "{words}\n{}{}", self.out, self.err);
        self
    }

    /// Asserts the exit code, words on stderr, and that nothing is on stdout.
    #[track_caller]
    pub fn refuses(self, code: i32, words: &str) -> Self {
        assert_eq!(self.out, "", "{}", self.err);
        self.ends(code).tells(words)
    }

    /// Asserts that words are on one of the two streams.
    #[track_caller]
    pub fn shows(self, words: &str) -> Self {
        assert!(self.all().contains(words), "{words}\n{}{}", self.out, self.err);
        self
    }

    /// Asserts that words are nowhere.
    #[track_caller]
    pub fn never_says(self, words: &str) -> Self {
        assert!(!self.all().contains(words), "{words}\n{}{}", self.out, self.err);
        self
    }

    /// Both streams.
    pub fn all(&self) -> String {
        format!("{}{}", self.out, self.err)
    }

    /// The rows of a table in CSV on stdout.
    pub fn rows(&self) -> Vec<Row> {
        rows(&self.out)
    }
}

/// A line of what the system knows of the memory of a process, in KiB: `VmRSS:` is what it takes now, `VmHWM:` the most.
#[cfg(target_os = "linux")]
pub fn memory(id: u32, name: &str) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

/// A file that describes a suite of the user's own, by the names and folders of its sequences.
pub fn suite(name: &str, format: &str, sequences: &[(&str, &str)]) -> String {
    let row = |(name, folder): &(&str, &str)| format!("{{ name = \"{name}\", folder = \"{folder}\" }},\n");
    let sequences: String = sequences.iter().map(row).collect();
    format!(
        "schema = 2\n\n[[suite]]\nname = \"{name}\"\ntitle = \"Mine\"\nformat = \"{format}\"\nsource = \"mine\"\n\
         licence = \"mine\"\nhow_to_get = \"ask me\"\nsequence = [\n{sequences}]\n"
    )
}

/// Renders the first frames of a sequence into the folder [`IMAGES`], and gives the lines of its ground truth.
pub fn clip(place: &Place, frames: usize) -> Vec<String> {
    let mut truth = place.render("synthetic-otb", "Girl");
    place.list(IMAGES)[frames..].iter().for_each(|file| std::fs::remove_file(file).unwrap());
    truth.truncate(frames);
    truth
}

pub const IMAGES: &str = "suite/Girl/img";

/// The left top corner of the target of [`sequence`] in a frame; both count from 0.
pub fn corner(t: u32) -> (u32, u32) {
    (8 + t / 5, 10 + t % 7)
}

/// Writes a sequence in the layout of OTB into the data root `data`: a textured target of 16 x 12 pixels that moves.
pub fn sequence(place: &Place, name: &str, frames: u32) {
    place.frames(&format!("data/otb/{name}/img/0000.png"), frames, (64, 48), |t, column, row| {
        let (x, y) = corner(t);
        if (x..x + 16).contains(&column) && (y..y + 12).contains(&row) {
            [200, 3 * (((column - x) * 31 + (row - y) * 17) % 64) as u8, 60]
        } else {
            [((column * 13 + row * 7) % 64) as u8, 90, 120]
        }
    });
    let line = |(x, y): (u32, u32)| format!("{},{},16,12\n", x + 1, y + 1);
    let truth: String = (0..frames).map(corner).map(line).collect();
    place.write(&format!("data/otb/{name}/groundtruth_rect.txt"), truth);
}
