//! Values of batch scripts: words for the shell, and values for `#SBATCH` lines.
//!
//! A word is quoted, so it may hold anything but control characters (a line break in it would let text
//! pass for a line of the script). `#SBATCH` lines are not read by the shell but by sbatch, with rules
//! of its own for quotes, backslashes and `#`; so only values from closed sets of characters stand
//! there, and no path does. Formats: `man sbatch`, `--time`, `--mem`, `--partition`, `--account`.

use std::fmt;
use std::path::{Path, PathBuf};

/// Seconds before the end of its time at which a job is told to stop.
pub const NOTICE: u64 = 120;
/// Shortest time limit in seconds. SLURM looks at its clock once a minute and may give notice a minute
/// early, so a shorter job would be told to stop as soon as it starts.
const SHORTEST: u64 = 300;
const LONGEST: u64 = 365 * 86_400;

/// Options of sbatch that the scripts give themselves, or could not do with. What is said of `--time` must be the job's time:
/// it is told to stop before that.
const TAKEN: [&str; 13] = [
    "--array",
    "-a",
    "--chdir",
    "-D",
    "--dependency",
    "-d",
    "--output",
    "-o",
    "--parsable",
    "--signal",
    "--time",
    "-t",
    "--wrap",
];

/// A value that cannot stand in a batch script.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum ValueError {
    /// A line break, a tab or the like.
    #[error("{0:?} has a control character in it (such as a line break); rename it")]
    Control(String),
    /// A path of bytes that are no text.
    #[error("{}: the name is not UTF-8; rename it", .0.display())]
    Encoding(PathBuf),
    /// A folder of logs whose name SLURM would expand.
    #[error("{0}: SLURM gives `%` and `\\` in the folder of its logs a meaning; name another --output")]
    Pattern(String),
    /// No time limit.
    #[error("want MINUTES, MM:SS, HH:MM:SS, D-HH, D-HH:MM or D-HH:MM:SS")]
    Time,
    /// A time limit out of range.
    #[error(
        "want at least 5 minutes, because jobs are told to stop 2 minutes before the end, and at most 365 days"
    )]
    TimeRange,
    /// No amount of memory.
    #[error("want a whole number above 0 and K, M, G or T, as in 2G")]
    Memory,
    /// An argument of sbatch that is none, or that the scripts give.
    #[error(
        "want an option of sbatch such as --gres=gpu:1, and none of {}, which are set already, also not shortened; --time has an option of its own here", TAKEN.join(", ")
    )]
    Option,
    /// No name of a partition or account.
    #[error("want a name of letters, digits, `_`, `.` and `-`")]
    Name,
}

/// A word of a shell script; displays itself in quotes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Word(String);

impl Word {
    /// Any text without control characters.
    ///
    /// # Errors
    /// [`ValueError::Control`].
    pub fn new(text: impl Into<String>) -> Result<Self, ValueError> {
        let text = text.into();
        if text.chars().any(char::is_control) {
            return Err(ValueError::Control(text));
        }
        Ok(Self(text))
    }

    /// A path as it is.
    ///
    /// # Errors
    /// When it is not UTF-8 or has control characters.
    pub fn path(path: &Path) -> Result<Self, ValueError> {
        Self::new(path.to_str().ok_or_else(|| ValueError::Encoding(path.to_path_buf()))?)
    }

    /// The folder that jobs start in and write their logs to. SLURM puts it in front of the pattern of
    /// the logs' names and expands both.
    ///
    /// # Errors
    /// As [`Word::path`], and [`ValueError::Pattern`] for what SLURM would expand.
    pub fn log_folder(path: &Path) -> Result<Self, ValueError> {
        let word = Self::path(path)?;
        if word.0.contains(['%', '\\']) {
            return Err(ValueError::Pattern(word.0));
        }
        Ok(word)
    }

    /// An option of sbatch, unless the scripts give it themselves or could not do with it.
    ///
    /// # Errors
    /// [`ValueError::Option`], and as [`Word::new`].
    pub fn sbatch_option(text: &str) -> Result<Self, ValueError> {
        let name = text.split('=').next().unwrap_or_default();
        // sbatch takes the beginning of a name for the whole.
        let is_taken =
            |own: &&str| own.len() > 2 && own.starts_with(name) || name.starts_with(*own) && own.len() == 2;
        if !text.starts_with('-') || text.len() < 2 || TAKEN.iter().any(is_taken) {
            return Err(ValueError::Option);
        }
        Self::new(text)
    }

    /// A line of shell commands.
    ///
    /// # Errors
    /// [`ValueError::Control`].
    pub fn command(text: &str) -> Result<Self, ValueError> {
        Self::new(text)
    }

    /// The text without quotes.
    pub fn text(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "'{}'", self.0.replace('\'', r"'\''"))
    }
}

/// A checked value of an `#SBATCH` line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting(String);

impl Setting {
    /// A time limit of 5 minutes to 365 days.
    ///
    /// # Errors
    /// [`ValueError::Time`], [`ValueError::TimeRange`].
    pub fn time(text: &str) -> Result<Self, ValueError> {
        match seconds(text) {
            None => Err(ValueError::Time),
            Some(s) if !(SHORTEST..=LONGEST).contains(&s) => Err(ValueError::TimeRange),
            Some(_) => Ok(Self(text.to_string())),
        }
    }

    /// Seconds of a time limit.
    pub fn seconds(&self) -> Option<u64> {
        seconds(&self.0)
    }

    /// Memory of a job; a number alone is in MiB. SLURM takes 0 for all there is, so it is refused.
    ///
    /// # Errors
    /// [`ValueError::Memory`].
    pub fn memory(text: &str) -> Result<Self, ValueError> {
        match number(text.strip_suffix(['K', 'M', 'G', 'T']).unwrap_or(text)) {
            Some(1..) => Ok(Self(text.to_string())),
            _ => Err(ValueError::Memory),
        }
    }

    /// Names of partitions, separated by commas.
    ///
    /// # Errors
    /// [`ValueError::Name`].
    pub fn partition(text: &str) -> Result<Self, ValueError> {
        text.split(',').try_for_each(|name| Self::account(name).map(drop))?;
        Ok(Self(text.to_string()))
    }

    /// The name of an account.
    ///
    /// # Errors
    /// [`ValueError::Name`].
    pub fn account(text: &str) -> Result<Self, ValueError> {
        let known = |c: char| c.is_ascii_alphanumeric() || "_.-".contains(c);
        if text.is_empty() || text.starts_with(['-', '.']) || !text.chars().all(known) {
            return Err(ValueError::Name);
        }
        Ok(Self(text.to_string()))
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Seconds of one of the forms that `--time` of sbatch has.
fn seconds(text: &str) -> Option<u64> {
    let (days, rest) = match text.split_once('-') {
        Some((days, rest)) => (Some(number(days)?), rest),
        None => (None, text),
    };
    let parts = rest.split(':').map(number).collect::<Option<Vec<_>>>()?;
    match (days, parts.as_slice()) {
        (None, &[m]) => Some(m * 60),
        (None, &[m, s]) => Some(m * 60 + s),
        (None, &[h, m, s]) => Some((h * 60 + m) * 60 + s),
        (Some(d), &[h]) => Some((d * 24 + h) * 3600),
        (Some(d), &[h, m]) => Some(((d * 24 + h) * 60 + m) * 60),
        (Some(d), &[h, m, s]) => Some(((d * 24 + h) * 60 + m) * 60 + s),
        _ => None,
    }
}

/// One to nine digits.
fn number(text: &str) -> Option<u64> {
    let digits = (1..=9).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    digits.then(|| text.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted() {
        let quoted = |text: &str| Word::new(text).unwrap().to_string();
        assert_eq!(quoted(""), "''");
        assert_eq!(quoted("a b$c\\"), "'a b$c\\'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }

    #[test]
    fn words_that_could_be_lines_are_refused() {
        for text in ["a\nb", "a\r", "\0", "a\tb", "\u{7f}", "\u{85}"] {
            assert_eq!(Word::new(text), Err(ValueError::Control(text.to_string())));
        }
        for text in ["/logs/50%", "/logs/a\\b"] {
            assert_eq!(Word::log_folder(Path::new(text)), Err(ValueError::Pattern(text.to_string())));
            assert!(Word::path(Path::new(text)).is_ok());
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_path_that_is_no_text_is_refused() {
        use std::os::unix::ffi::OsStrExt;
        let path = Path::new(std::ffi::OsStr::from_bytes(b"/logs/\xff"));
        assert_eq!(Word::path(path), Err(ValueError::Encoding(path.to_path_buf())));
    }

    #[test]
    fn times_are_read_as_sbatch_reads_them() {
        let rows = [
            ("5", 300),
            ("90", 5400),
            ("05:30", 330),
            ("04:00:00", 14_400),
            ("1-0", 86_400),
            ("1-02", 93_600),
            ("1-02:30", 95_400),
            ("1-02:30:05", 95_405),
        ];
        for (text, expected) in rows {
            assert_eq!(seconds(text), Some(expected), "{text}");
            assert_eq!(Setting::time(text).unwrap().to_string(), text);
        }
        for text in
            ["", "4h", "1-", "-1", "1:2:3:4", "1-2:3:4:5", " 5", "5 ", "+5", "UNLIMITED", "1234567890"]
        {
            assert_eq!(Setting::time(text), Err(ValueError::Time), "{text}");
        }
        for text in ["0", "04:00", "00:04:59", "365-0:0:1", "999999999-0"] {
            assert_eq!(Setting::time(text), Err(ValueError::TimeRange), "{text}");
        }
    }

    #[test]
    fn memory_is_a_number_and_a_unit() {
        for text in ["2G", "500M", "1T", "4096", "9K"] {
            assert_eq!(Setting::memory(text).unwrap().to_string(), text);
        }
        for text in ["", "0", "0G", "G", "2GB", "2 G", "-2G", "2.5G", "2G\n", "2G#"] {
            assert_eq!(Setting::memory(text), Err(ValueError::Memory), "{text}");
        }
    }

    #[test]
    fn options_of_sbatch_are_not_those_of_the_scripts() {
        for text in ["--gres=gpu:1", "--exclusive", "--qos=short", "-q", "--comment=a b", "--constraint=a|b"]
        {
            assert_eq!(Word::sbatch_option(text).unwrap().text(), text);
        }
        for text in
            ["", "-", "gpu", "--array=1-9", "--output=x", "-o", "-ox", "-a1-3", "--wrap=ls", "--chdir=/"]
        {
            assert_eq!(Word::sbatch_option(text), Err(ValueError::Option), "{text}");
        }
        for text in
            ["--arr=1-3", "--outp=x", "--ch", "--tim=1", "--time=1", "-t1", "--dep=afterok:1", "--wra=ls"]
        {
            assert_eq!(Word::sbatch_option(text), Err(ValueError::Option), "{text}");
        }
        assert!(
            Word::sbatch_option("--time-min=10").is_ok() && Word::sbatch_option("--open-mode=append").is_ok()
        );
        assert!(matches!(Word::sbatch_option("--comment=a\nb"), Err(ValueError::Control(_))));
    }

    #[test]
    fn names_are_of_a_closed_set() {
        assert_eq!(Setting::partition("gpu_a100,cpu-2").unwrap().to_string(), "gpu_a100,cpu-2");
        assert_eq!(Setting::account("lab.vision").unwrap().to_string(), "lab.vision");
        for text in ["", "a b", "a'", "a\n#SBATCH --uid=0", "-p", "é", "a#", "a%", "$x", ".."] {
            assert_eq!(Setting::account(text), Err(ValueError::Name), "{text}");
            assert_eq!(Setting::partition(text), Err(ValueError::Name), "{text}");
        }
        for text in ["a,,b", "a,", ",", "a, b"] {
            assert_eq!(Setting::partition(text), Err(ValueError::Name), "{text}");
        }
        assert_eq!(Setting::account("a,b"), Err(ValueError::Name));
    }
}
