use super::*;

fn vot() -> Vec<Suite> {
    vec![Catalog::default().suite("vot2014").unwrap()]
}

/// Data root with one sequence that is too short; 24 others are missing.
fn root() -> tempfile::TempDir {
    let files = [("00000001.jpg", ""), ("groundtruth.txt", "1,2,3,4")];
    trackfail_testing::folder(files.map(|(name, text)| (format!("vot2014/ball/{name}"), text)))
}

#[test]
fn lists_in_three_formats() {
    let root = root();
    let text = |format| list(&vot(), &[root.path().to_path_buf()], format).unwrap();
    let csv = text(Format::Csv);
    assert!(csv.starts_with("suite,sequence,status,frames,annotated,digest,folder,attributes,note,root\n"));
    assert_eq!(csv.lines().count(), 26);
    assert!(csv.lines().nth(1).unwrap().starts_with("vot2014,ball,broken,602,,unknown,vot2014/ball,"));
    let json: Vec<serde_json::Value> = serde_json::from_str(&text(Format::Json)).unwrap();
    assert_eq!((json.len(), &json[1]["status"]), (25, &"missing".into()));
    assert_eq!(json[0].as_object().unwrap().len(), COLUMNS.len());
    let table = text(Format::Table);
    assert!(table.contains("0 of 25 sequences are here") && table.contains("votchallenge.net"), "{table}");
}

#[test]
fn without_a_suite_each_has_one_line() {
    let root = root();
    let text = overview(&chosen(&Catalog::default(), &[]).unwrap(), &[root.path().to_path_buf()]);
    assert_eq!(text.lines().count(), Catalog::default().names().count() + 2);
    let line = |name: &str| {
        let line = text.lines().find(|l| l.trim_start().starts_with(name)).unwrap();
        line.split_whitespace().map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(line("vot2014 ")[1..5], ["0", "25", "1", "known"]);
    assert_eq!(line("vot2013 ")[1..4], ["0", "16", "known"]);
    assert_eq!(line("pets2009-s2l1 ")[1..5], ["0", "19", "by", "hand"]);
    assert_eq!(line("clemson-heads ")[1..4], ["0", "4", "partly"]);
    assert_eq!(line("synthetic-vot ")[1..4], ["9", "9", "rendered"]);
    assert!(text.contains("data list SUITE"));
}

#[test]
fn unknown_numbers_of_frames_are_empty() {
    let suites = [Catalog::default().suite("vot2013").unwrap()];
    let text = list(&suites, &[], Format::Csv).unwrap();
    assert!(text.contains("\nvot2013,cup,missing,,,unknown,vot2013/cup,"), "{text}");
    let text = list(&suites, &[], Format::Json).unwrap();
    let rows: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    assert!(rows.iter().all(|r| r["frames"].is_null()));
}

#[test]
fn verify_tells_missing_from_differing() {
    let (full, empty) = (root(), tempfile::tempdir().unwrap());
    let check = |root: &Path, allow| {
        let (text, result) = verify(&vot(), &[root.to_path_buf()], allow);
        (text, result.map_err(|e| (e.code(), e.to_string())))
    };
    let (text, result) = check(full.path(), true);
    assert!(text.starts_with("vot2014/ball  differs: "), "{text}");
    assert!(matches!(result, Err((3, message)) if message.contains("vot2014/ball")));
    let (text, result) = check(empty.path(), false);
    assert_eq!(text.lines().filter(|l| l.contains("  missing: ")).count(), 25);
    assert!(matches!(result, Err((3, message)) if message.contains("25 sequences")));
    assert_eq!(check(empty.path(), true).1, Ok(()));
}

#[trackfail_testing::needs(real_data)]
#[test]
fn real_data_verify_and_pin() {
    let roots = [trackfail_testing::real_data()];
    verify(&chosen(&Catalog::default(), &[]).unwrap(), &roots, true).1.unwrap();
    let lines = pin(&vot(), &roots).unwrap();
    assert!(lines.starts_with("# vot2014\n"));
    let (lock, files) = lines.split_once("\n# datasets.files\n").unwrap();
    assert!(lock.lines().skip(1).all(|l| lock::SUITES.iter().any(|(_, text)| text.contains(l))));
    assert!(include_str!("../../../datasets.files").contains(files));
}
