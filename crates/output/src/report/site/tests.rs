use super::*;
use trackfail_dataset::text::visible;
use trackfail_testing::hostile::{assert_is_text, markup, words};

fn a(name: &str) -> Summary {
    let claims = ClaimCounts { hold: 2, undecided: 3, do_not_hold: 1, cannot_be_tested: 0 };
    Summary {
        format: FORMAT,
        experiment: name.into(),
        title: format!("Title of {name}"),
        paper: "a paper".into(),
        object: "Table 1".into(),
        claims,
        suite: "otb".into(),
        data: "12 of 21 targets".into(),
        present: 12,
        wanted: 21,
        ..Summary::default()
    }
}

fn put(reports: &Path, name: &str, summary: &str) {
    let folder = reports.join(name);
    store::write(&folder.join(INDEX), b"page").unwrap();
    store::write(&folder.join(SUMMARY), summary.as_bytes()).unwrap();
}

fn json(summary: &Summary) -> String {
    serde_json::to_string(summary).unwrap()
}

/// A folder with the reports of experiments.
fn reports(summaries: impl IntoIterator<Item = Summary>) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    summaries.into_iter().for_each(|s| put(dir.path(), &s.experiment, &json(&s)));
    dir
}

fn index(reports: &Path) -> String {
    assert_eq!(write_index(reports).unwrap(), Vec::<String>::new());
    read(reports, INDEX)
}

/// A page that is there; a slash is escaped too.
fn read(reports: &Path, name: &str) -> String {
    std::fs::read_to_string(reports.join(name)).unwrap().replace("&#x2f;", "/")
}

#[test]
fn the_site_does_not_depend_on_the_order_of_reports() {
    let names = ["b", "a/z", "a", "c-1/x_2", "a-b", "a/data"];
    let make = |names: &[&str]| {
        let dir = tempfile::tempdir().unwrap();
        for name in names {
            put(dir.path(), name, &json(&a(name)));
            index(dir.path());
        }
        let page = index(dir.path());
        assert_eq!(page, index(dir.path()));
        (page, dir)
    };
    let (page, dir) = make(&names);
    let mut other = names;
    other.reverse();
    assert_eq!(page, make(&other).0);
    let at =
        |name: &str| page.find(&format!("<a href=\"{name}/index.html\" dir=\"auto\">Title of {name}</a>"));
    let places: Vec<_> = ["a", "a-b", "a/data", "a/z", "b", "c-1/x_2"].map(at).into();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}");
    for part in [
        "12 of 21 targets",
        "not all of them",
        "a paper",
        "Table 1",
        "6 experiments",
        "<strong class=\"verdict\">12</strong> hold<",
        "<strong class=\"verdict\">6</strong> do not hold<",
    ] {
        assert!(page.contains(part), "{part}\n{page}");
    }
    // Nothing that is loaded or run.
    for part in ["<script", "http://", "https://", "script-src", "refresh"] {
        assert!(!page.contains(part), "{part}");
    }
    // A report that was removed is gone.
    std::fs::remove_dir_all(dir.path().join("a/z")).unwrap();
    let page = index(dir.path());
    assert!(!page.contains("a/z") && page.contains("5 experiments"));
}

#[test]
fn other_folders_are_not_listed() {
    let dir = tempfile::tempdir().unwrap();
    for name in [".trackfail-tmp-x/a", ".hidden", "With Capitals", "a/.b", "umläut"] {
        put(dir.path(), name, &json(&a("a")));
    }
    put(dir.path(), "unfinished", &json(&a("a")));
    std::fs::remove_file(dir.path().join("unfinished").join(INDEX)).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(dir.path().join(".hidden"), dir.path().join("link")).unwrap();
    assert_eq!(collect(dir.path()), Site::default());
    assert!(index(dir.path()).contains("no report yet"));
    assert_eq!(collect(&dir.path().join("absent")), Site::default());
}

#[test]
fn summaries_that_cannot_be_read_give_warnings() {
    let dir = reports([a("good")]);
    // Summaries up to format 3 have the best methods beside the verdict.
    let mut earlier = serde_json::to_value(a("earlier")).unwrap();
    earlier["format"] = 3.into();
    earlier["best"] =
        serde_json::json!([{ "tracker": "ncc", "metric": "m", "method": "DTEF", "value": "0.7" }]);
    put(dir.path(), "earlier", &earlier.to_string());
    let deep = "[".repeat(100_000);
    let later = format!("{{\"format\": {}, \"more\": 1}}", FORMAT + 1);
    let negative = json(&a("x")).replace("\"hold\":2", "\"hold\":-2");
    let more = json(&a("x")).replacen('{', "{\"more\":1,", 1);
    let short = ["", "{", "[]", "null", "\u{0}", "{\"format\": 1}", "{\"format\": \"1\"}"];
    let long: [&str; 4] = [&deep, &later, &negative, &more];
    let broken = [&short[..], &long[..]].concat();
    for (k, text) in broken.iter().enumerate() {
        put(dir.path(), &format!("bad/{k}"), text);
    }
    std::fs::create_dir_all(dir.path().join("bad/folder").join(SUMMARY)).unwrap();
    for name in ["bad/folder", "bad/none"] {
        store::write(&dir.path().join(name).join(INDEX), b"").unwrap();
    }
    let warnings = write_index(dir.path()).unwrap();
    assert_eq!(warnings.len(), broken.len() + 2, "{warnings:#?}");
    assert!(warnings.iter().any(|t| t.contains("bad/none") && t.contains("`trackfail report bad/none`")));
    assert!(warnings.iter().any(|t| t.contains(&format!("has format {}", FORMAT + 1))));
    let page = read(dir.path(), INDEX);
    assert!(page.contains("2 experiments.") && page.contains(">Title of earlier</a>"));
    assert!(page.contains("href=\"bad/5/index.html\""));
    assert_eq!(page.matches("is none of this program").count(), broken.len() - 1);
    put(dir.path(), "huge", &" ".repeat(summary::MAX_SUMMARY as usize + 1));
    let mut unreadable = collect(dir.path()).unreadable.into_iter();
    assert!(unreadable.any(|(name, why)| name == "huge" && why.contains("cannot be read")));
}

// Before: needs and numbers of other people's summaries came to the page with what they had of control characters.
#[test]
fn any_word_of_a_summary_is_text() {
    let dir = tempfile::tempdir().unwrap();
    let pages = |word: &str| {
        let [title, paper, object, suite, data, verdict] = [word; 6].map(String::from);
        let of = |method: &str, value: &str| Standing {
            cost: word.into(),
            auprc: Estimate { value: word.into(), low: word.into(), high: word.into() },
            auroc: Estimate { value: value.into(), low: word.into(), high: word.into() },
            ..standing(method, word, "")
        };
        // Methods that are ranked have an AUROC.
        let standings = vec![of("M", "0.7"), of(&format!("{word} too"), "0.6"), of(word, word)];
        let claims = ClaimCounts { hold: u64::MAX, ..a(word).claims };
        let summary = Summary { title, paper, object, suite, data, claims, standings, ..a(word) };
        put(dir.path(), "x", &json(&summary));
        put(dir.path(), "y", &json(&Summary { verdict, ..summary }));
        let unknown = serde_json::json!({ "format": 1, word: 1 });
        put(dir.path(), "z", &unknown.to_string());
        assert_eq!(write_index(dir.path()).unwrap().len(), 1);
        let site = [INDEX, LEADERBOARD].map(|name| std::fs::read_to_string(dir.path().join(name)).unwrap());
        site.map(|page| markup(&page)).concat()
    };
    for word in words() {
        assert_is_text(&word, &visible(&word), pages);
    }
}

#[test]
fn pages_of_other_programs_are_not_replaced() {
    let dir = reports([a("a")]);
    let path = dir.path().join(INDEX);
    std::fs::write(&path, "<h1>My own</h1>").unwrap();
    let warnings = write_index(dir.path()).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("left as it is"), "{warnings:?}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "<h1>My own</h1>");
    std::fs::remove_file(&path).unwrap();
    assert!(index(dir.path()).contains(OURS));
    #[cfg(unix)]
    {
        // Nothing is written where a link leads.
        let elsewhere = dir.path().join("elsewhere.txt");
        std::fs::write(&elsewhere, "mine").unwrap();
        std::fs::remove_file(&path).unwrap();
        std::os::unix::fs::symlink(&elsewhere, &path).unwrap();
        index(dir.path());
        assert_eq!(std::fs::read_to_string(&elsewhere).unwrap(), "mine");
        assert!(!path.is_symlink());
    }
}

#[test]
fn concurrent_writers_lose_no_report() {
    let dir = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..8).map(|k| format!("e/{k}")).collect();
    std::thread::scope(|scope| {
        for name in &names {
            scope.spawn(|| {
                put(dir.path(), name, &json(&a(name)));
                write_index(dir.path()).unwrap();
            });
        }
    });
    let page = read(dir.path(), INDEX);
    assert!(names.iter().all(|name| page.contains(&format!("href=\"{name}/index.html\""))));
}

fn standing(method: &str, needs: &str, auroc: &str) -> Standing {
    let auroc = Estimate { value: auroc.into(), low: "0.1".into(), high: "0.9".into() };
    Standing { method: method.into(), needs: needs.into(), auroc, trackers: 3, ..Standing::default() }
}

fn leaderboard_of(summaries: &[(&str, Vec<Standing>)]) -> String {
    let dir = reports(summaries.iter().map(|(name, standings)| {
        let present = if name.starts_with("few") { 2 } else { 12 };
        let synthetic = name.starts_with("rendered");
        Summary { standings: standings.clone(), synthetic, present, ..a(name) }
    }));
    index(dir.path());
    read(dir.path(), LEADERBOARD)
}

fn row_of(page: &str, method: &str) -> String {
    let methods = page.split("All methods").nth(1).unwrap();
    let rows: Vec<&str> = methods.split("<tr").collect();
    rows.iter().find(|row| row.contains(&format!("<bdi>{method}</bdi>"))).unwrap().to_string()
}

// The first experiment is synthetic and the second has two sequences, so that ranks are those of the third, in which
// DTEF and RAW are equal as printed.
#[test]
fn methods_are_ranked_on_the_same_sequences() {
    let few =
        [standing("Confidence", "the tracker's confidence", "0.998"), standing("CovF", "frames", "0.9")];
    let rendered = [("CovF", "0.900"), ("PSR", "0.800")];
    let rendered = rendered.map(|(method, auroc)| standing(method, "frames", auroc));
    let video = [("CovF", "0.700"), ("DTEF", "0.600"), ("RAW", "0.600"), ("Without motion", "0.990")];
    let mut video = video.map(|(method, auroc)| standing(method, "frames", auroc)).to_vec();
    video.push(Standing { anchor: true, ..standing("oracle", "nothing", "1.000") });
    let page = leaderboard_of(&[("few", few.into()), ("rendered", rendered.into()), ("video", video)]);
    // A method of the user's own has its rank as any other one.
    for (method, rank) in [("Without motion", "1"), ("CovF", "2"), ("DTEF", "3="), ("RAW", "3=")] {
        assert!(row_of(&page, method).contains(&format!("<td>{rank}</td>")), "{method}");
    }
    for (method, reason) in [
        ("Confidence", "tested on fewer than 3 sequences"),
        ("PSR", "rank 2 of 2 in rendered"),
        ("oracle", "anchor"),
    ] {
        assert!(row_of(&page, method).contains(&format!("<small>{reason}</small>")), "{method} {page}");
    }
    assert!(!page.contains("cost"));
}

// An AUROC of .9 with an interval from .1 on may be chance.
#[test]
fn none_is_the_best_that_may_be_chance() {
    let sure = |method: &str, needs: &str| {
        let auroc = Estimate { value: "0.900".into(), low: "0.800".into(), high: "0.950".into() };
        Standing { auroc, ..standing(method, needs, "") }
    };
    let page =
        leaderboard_of(&[("video", vec![sure("CovF", "frames"), standing("Scale", "boxes alone", "0.950")])]);
    let (answers, _) = page.split_once("All methods").unwrap();
    assert!(!answers.contains("<strong><bdi>Scale"), "{answers}");
    for part in [
        "<strong><bdi>CovF</bdi></strong> 0.900",
        "none better than chance",
        "With boxes alone none is better than chance; with frames it is CovF (0.900).",
    ] {
        assert!(answers.contains(part), "{part}\n{answers}");
    }
}

#[test]
fn the_leaderboard_has_the_experiments_that_ask_for_it() {
    let standings = vec![standing("CovF", "frames", "0.700")];
    let asking = |name| Summary { standings: standings.clone(), ..a(name) };
    let dir = reports([asking("a"), asking("b"), a("c")]);
    assert!(index(dir.path()).contains("href=\"leaderboard.html\""));
    let page = read(dir.path(), LEADERBOARD);
    assert!(page.contains("href=\"a/index.html\""));
    assert!(!page.contains("href=\"c/index.html\""));
    ["a", "b"].iter().for_each(|name| std::fs::remove_dir_all(dir.path().join(name)).unwrap());
    assert!(!index(dir.path()).contains("leaderboard"));
    assert!(!dir.path().join(LEADERBOARD).exists());
}
