//! The page of an experiment: the numbers in it and what `explain` says of them.

use crate::tools::page::page_of_a_run;

/// The page and the command that it names explain a number alike.
#[test]
fn numbers_are_explained_as_the_command_explains_them() {
    let root = tempfile::tempdir().unwrap();
    let html = std::fs::read_to_string(page_of_a_run(root.path())).unwrap();
    let text = |escaped: &str| {
        let marks = [
            ("&#x27;", "'"),
            ("&#x2f;", "/"),
            ("&quot;", "\""),
            ("&lt;", "<"),
            ("&gt;", ">"),
            ("&amp;", "&"),
        ];
        marks.iter().fold(escaped.to_string(), |text, (from, to)| text.replace(from, to))
    };
    let titles: Vec<Vec<String>> = html
        .split("<a class=\"origin\"")
        .skip(1)
        .map(|rest| {
            rest.split("title=\"")
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap()
                .split("&#10;")
                .map(text)
                .collect()
        })
        .collect();
    // Three measures of two methods on two trackers, and of one more on the first.
    assert_eq!(titles.len(), 3 * 5);
    for title in titles {
        let [number, formula, command] = &title[..] else { panic!("{title:?}") };
        let typed = command.replacen("trackfail", env!("CARGO_BIN_EXE_trackfail"), 1);
        let output =
            std::process::Command::new("sh").args(["-c", &typed]).current_dir(root.path()).output().unwrap();
        let stdout = String::from_utf8(output.stdout).unwrap();
        assert!(stdout.lines().any(|line| line.trim() == formula), "{number}: {formula}\n{stdout}");
        let (method, tracker) = number.split_once(" is ").unwrap().0.split_once(" on ").unwrap();
        assert!(stdout.starts_with(&format!("mine/page/t, tracker {tracker}: {method} is ")), "{stdout}");
        assert_eq!(stdout.matches(", tracker ").count(), 1, "{stdout}");
    }
}
