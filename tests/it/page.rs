//! The page of an experiment: the numbers in it and what `explain` says of them.

use crate::tools::page::page_of_a_run;

/// The page and the command that it names explain a number alike.
#[test]
fn numbers_are_explained_as_the_command_explains_them() {
    let place = page_of_a_run();
    let html = place.read("reports/mine/page/index.html");
    let marks =
        [("&#x27;", "'"), ("&#x2f;", "/"), ("&quot;", "\""), ("&lt;", "<"), ("&gt;", ">"), ("&amp;", "&")];
    let text =
        |escaped: &str| marks.iter().fold(escaped.to_string(), |text, (from, to)| text.replace(from, to));
    let links = html.split("<a class=\"origin\"").skip(1);
    let titles = links.map(|rest| rest.split("title=\"").nth(1).unwrap().split('"').next().unwrap());
    let titles: Vec<Vec<String>> = titles.map(|title| title.split("&#10;").map(text).collect()).collect();
    // Three measures of two methods on two trackers, and of one more on the first.
    assert_eq!(titles.len(), 3 * 5);
    for title in titles {
        let [number, formula, command] = &title[..] else { panic!("{title:?}") };
        let out = place.shell(command).out;
        assert!(out.lines().any(|line| line.trim() == formula), "{number}: {formula}\n{out}");
        let (method, tracker) = number.split_once(" is ").unwrap().0.split_once(" on ").unwrap();
        assert!(out.starts_with(&format!("mine/page/t, tracker {tracker}: {method} is ")), "{out}");
        assert_eq!(out.matches(", tracker ").count(), 1, "{out}");
    }
}
