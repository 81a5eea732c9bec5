//! Tests that need data or programs are left out where these are missing, and only there.

use crate::docs::root;
use trackfail_testing::conditions::NEEDS;
use trackfail_testing::met_when_compiled;

#[test]
fn what_tests_need_is_as_it_was_when_they_were_compiled() {
    let now: Vec<&str> = NEEDS.iter().filter(|need| (need.is_met)()).map(|need| need.name).collect();
    assert_eq!(
        now,
        met_when_compiled!(),
        "what is here now (left) is not what was here when the tests were compiled (right); \
         run `touch crates/needs/src/lib.rs`, so that cargo compiles them again"
    );
}

#[test]
fn no_test_is_ignored_without_a_reason() {
    let folders = ["src", "crates", "tests", "benches"].map(|f| walkdir::WalkDir::new(root().join(f)));
    let files = folders.into_iter().flatten().map(|entry| entry.unwrap().into_path());
    let sources = files.filter(|path| path.extension().is_some_and(|e| e == "rs"));
    let bare = ["#[ignore", "]"].concat();
    let ignored: Vec<_> = sources.filter(|p| std::fs::read_to_string(p).unwrap().contains(&bare)).collect();
    assert!(ignored.is_empty(), "{ignored:?}");
}
