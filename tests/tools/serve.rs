//! Helpers of the tests of `trackfail serve`: a small experiment, and the program while it serves.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// An experiment that takes seconds.
pub fn small(name: &str, title: &str) -> String {
    format!(
        "schema = 1\nname = \"{name}\"\ntitle = {title}\npaper = \"a paper\"\nobject = \"Table 1\"\n\
         protocol = \"khalid2016/1\"\nsuites.test = \"synthetic-vot\"\n[[tracker]]\nname = \"still\"\n\
         [[method]]\nname = \"hist\"\nsignal.kind = \"rgb-histogram\"\n\
         detector = {{ kind = \"level\", below = 0.9 }}\n\
         [[method]]\nname = \"lax\"\nsignal.kind = \"rgb-histogram\"\n\
         detector = {{ kind = \"level\", below = 0.1 }}\n\
         [[method]]\nname = \"oracle\"\ndetector = {{ kind = \"oracle\" }}\n\
         [[table]]\nname = \"t\"\nrows = [\"f_score\", \"events\"]\ncolumns = \"method\"\n\
         [[claim]]\ntext = \"The oracle finds all\"\nholds = \"recall[oracle] == 1\"\n\
         [[claim]]\ntext = \"No more than all\"\nholds = \"recall[hist] <= 1\"\n\
         [[claim]]\ntext = \"More than all\"\nholds = \"recall[hist] > 1\"\n",
        title = serde_json::to_string(title).unwrap(),
    )
}

/// The program while it serves `root`.
pub struct Server {
    pub process: Child,
    pub port: u16,
}

impl Server {
    pub fn start(root: &Path) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_trackfail"))
            .current_dir(root)
            .args(["serve", "--port", "0"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let port = line.trim().strip_prefix("http://127.0.0.1:").and_then(|l| l.strip_suffix('/'));
        Self { port: port.unwrap_or_else(|| panic!("{line:?}")).parse().unwrap(), process }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
