//! The page over all reports in a real browser.

use crate::browser::Browser;
use crate::tools::needs;
use std::path::Path;
use trackfail::report::claims::ClaimCounts;
use trackfail::report::site;
use trackfail_testing::{hostile, put};

/// A folder of reports of all kinds, without their pages.
fn gallery(reports: &Path) {
    let mut summary = site::Summary {
        format: site::FORMAT,
        experiment: "quickstart".into(),
        title: "Quickstart: failure detection on synthetic sequences".into(),
        suite: "synthetic-otb".into(),
        data: "12 targets, 3 runs".into(),
        present: 12,
        wanted: 12,
        synthetic: true,
        claims: ClaimCounts { hold: 3, undecided: 0, do_not_hold: 0, cannot_be_tested: 0 },
        ..site::Summary::default()
    };
    let write = |name: &str, summary: &site::Summary| {
        put(reports, format!("{name}/index.html"), "<!DOCTYPE html><title>page</title>");
        put(reports, format!("{name}/summary.json"), serde_json::to_vec(summary).unwrap());
    };
    write("quickstart", &summary);
    summary.title = "Detecting tracking failures, all trackers of the paper".into();
    summary.paper = "khalid2016".into();
    summary.object = "Table 1".into();
    summary.claims = ClaimCounts { hold: 2, undecided: 0, do_not_hold: 1, cannot_be_tested: 4 };
    (summary.present, summary.synthetic, summary.failed) = (9, false, 3);
    summary.experiment = "khalid2016/table1".into();
    write("khalid2016/table1", &summary);
    summary.title = hostile::words().concat();
    summary.data.clone_from(&summary.title);
    summary.experiment = "x".repeat(64);
    write(&"x".repeat(64), &summary);
    put(reports, "old/index.html", "page");
}

#[needs(chromium)]
#[test]
fn the_site_works_in_a_browser() {
    let mut browser = Browser::start();
    let root = tempfile::tempdir().unwrap();
    let reports = root.path().join("reports");
    gallery(&reports);
    assert_eq!(site::write_index(&reports).unwrap().len(), 1);
    browser.on_all_screens("site", &reports.join("index.html"), "file://", |browser, _| {
        assert_eq!(browser.value("document.querySelectorAll('#reports .list > li').length"), 3);
        assert_eq!(browser.value("document.querySelectorAll('#reports b').length"), 0);
    });
    browser.click("document.querySelector('#reports .links a')");
    browser
        .becomes("document.title === 'page' && location.pathname.endsWith('/khalid2016/table1/index.html')");
    assert_eq!(browser.complaints("file://"), Vec::<String>::new());
}
