//! `trackfail data fetch`: downloads missing sequences, with the user's consent, and checks them.

use super::{Checks, first_root};
use crate::cli::{Exit, Failure, output};
use crate::dataset::fetch::{
    self, FetchError, FetchJob, FetchOptions, FetchPlan, Fetched, Told, WantedSequences, Workspace,
};
use crate::dataset::suite::{Catalog, Suite};
use crate::plugin::unknown;
use std::collections::BTreeSet;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;

/// Arguments of `trackfail data fetch`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Suites and sequences that are fetched where they are missing: `vot2014`, `vot2014/ball` ...; all suites by default
    #[arg(value_name = "SUITE[/SEQUENCE]")]
    wanted: Vec<String>,
    /// Agree to the licences of the suites, which are shown before their first download
    #[arg(long)]
    accept_licence: bool,
    /// Download once more what an earlier fetch has placed and is not as pinned, and put it in the place of that
    #[arg(long)]
    again: bool,
    /// Take files from below this address instead of the listed ones, by their names
    #[arg(long, value_name = "URL")]
    mirror: Option<String>,
}

/// Runs the verb.
///
/// # Errors
/// `Usage` for unknown names, no data root, and licences without consent; `Data` for files that are absent at
/// their address, not as pinned, refused, or only available by hand; `Io` for network and disk.
pub fn run(args: &Args, catalog: &Catalog, data_roots: &[PathBuf]) -> Result<(), Failure> {
    let root = first_root("fetch", data_roots)?;
    let wanted = chosen(catalog, &args.wanted)?;
    let plan = fetch::plan(&wanted, data_roots, args.again);
    output::write(&known(&plan))?;
    let options = FetchOptions { mirror: args.mirror.clone(), ..FetchOptions::default() };
    let mut failed = Failed::default();
    if !plan.jobs.is_empty() {
        let space = Workspace::open(root).map_err(failure)?;
        let ask = || args.accept_licence || asked_on_terminal();
        agree(&space, &suites_of(&plan, &wanted), ask, &mut std::io::stderr())?;
        failed = download(&space, &plan.jobs, &options)?;
        check(&wanted, &plan.jobs, &mut failed, data_roots)?;
    }
    verdict(&plan, &failed)
}

/// Parses names of suites and sequences.
fn chosen(catalog: &Catalog, names: &[String]) -> Result<Vec<WantedSequences>, Failure> {
    let all: Vec<String> = catalog.names().map(String::from).collect();
    let names = if names.is_empty() { &all } else { names };
    let mut chosen: Vec<WantedSequences> = Vec::new();
    for name in names {
        let (suite, sequence) = name.split_once('/').map_or((name.as_str(), None), |(a, b)| (a, Some(b)));
        let suite = catalog.suite(suite).map_err(Failure::usage)?;
        let mut sequences: BTreeSet<String> = suite.sequence_names().into_iter().collect();
        if let Some(sequence) = sequence {
            if !sequences.contains(sequence) {
                let what = format!("sequence of {}", suite.name());
                let known = sequences.iter().map(String::as_str);
                return Err(Failure::usage(unknown(&what, sequence, known)));
            }
            sequences.retain(|name| name == sequence);
        }
        match chosen.iter_mut().find(|w| w.suite.name() == suite.name()) {
            Some(wanted) => wanted.sequences.extend(sequences),
            None => chosen.push(WantedSequences { suite, sequences }),
        }
    }
    Ok(chosen)
}

/// Text on the sequences that need no download, and on those that cannot be downloaded.
fn known(plan: &FetchPlan) -> String {
    let here = plan.here.iter().map(|name| format!("{name}  is here\n"));
    let broken = plan.broken.iter();
    let broken = broken.map(|(name, why)| format!("{name}  is here and left as it is, but differs: {why}\n"));
    let by_hand = plan.by_hand.iter().map(|(name, how)| format!("{name}  by hand: {how}\n"));
    here.chain(broken).chain(by_hand).collect()
}

/// Suites with something to download, each with its licence text.
fn suites_of<'w>(plan: &FetchPlan, wanted: &'w [WantedSequences]) -> Vec<(&'w str, String)> {
    let downloads = |suite: &Suite| {
        let prefix = format!("{}/", suite.name());
        plan.jobs.iter().flat_map(|job| &job.sequences).any(|name| name.starts_with(&prefix))
    };
    let text = |suite: &'w Suite| {
        let (source, licence) = suite.source()?;
        let (name, title) = (suite.name(), suite.title());
        Some((name, format!("{name}: {title}\nsource: {source}\nlicence: {licence}\n")))
    };
    wanted.iter().map(|w| &w.suite).filter(|suite| downloads(suite)).filter_map(text).collect()
}

/// Asks the user for consent. Without a terminal the answer is no.
fn asked_on_terminal() -> bool {
    let is_terminal = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
    let mut answer = String::new();
    is_terminal
        && write!(std::io::stderr(), "Do you agree to this, and fetch? [y/N] ").is_ok()
        && std::io::stdin().read_line(&mut answer).is_ok()
        && matches!(answer.trim().to_lowercase().as_str(), "y" | "yes")
}

/// Shows all licences without earlier consent, and asks for it.
fn agree(
    space: &Workspace,
    suites: &[(&str, String)],
    mut ask: impl FnMut() -> bool,
    err: &mut impl Write,
) -> Result<(), Failure> {
    for (suite, text) in suites.iter().filter(|(suite, text)| !space.agreed(suite, text)) {
        write!(err, "{text}").map_err(|e| Failure::io(format!("stderr: {e}")))?;
        if !ask() {
            return Err(Failure::usage(format!(
                "nothing is downloaded of {suite} without your agreement to the text above; if you do agree, \
                 run the same again with --accept-licence"
            )));
        }
        space.remember(suite, text).map_err(failure)?;
    }
    Ok(())
}

/// Names of archives and sequences that failed.
#[derive(Debug, Default)]
struct Failed {
    /// Archives that failed because of the network.
    network: Vec<String>,
    /// Archives that are absent, not as pinned, or refused.
    data: Vec<String>,
    /// Sequences that are not as pinned.
    differing: Vec<String>,
}

/// Downloads one archive after the other. After a failure the next archive is tried, unless the disk was at
/// fault.
fn download(space: &Workspace, jobs: &[FetchJob], options: &FetchOptions) -> Result<Failed, Failure> {
    let mut failed = Failed::default();
    for job in jobs {
        let name = &job.archive.name;
        // On stderr, if that is a terminal.
        let bar = output::progress_bar(name, "{bytes}/{total_bytes}, {bytes_per_sec}, {eta} left");
        let watch = |told: Told<'_>| match told {
            Told::Arrived(bytes, total) => {
                total.into_iter().for_each(|total| bar.set_length(total));
                bar.set_position(bytes);
            }
            Told::Note(text) => bar.suspend(|| output::note(text)),
        };
        let outcome = fetch::fetch(space, job, options, &watch);
        bar.finish_and_clear();
        match outcome {
            Ok(fetched) => {
                output::write(&brought(job, &fetched))?;
                if !fetched.placed.refused.is_empty() {
                    failed.data.push(name.clone());
                }
            }
            Err(e @ (FetchError::Disk { .. } | FetchError::Busy { .. } | FetchError::Address { .. })) => {
                return Err(failure(e));
            }
            Err(e) => {
                let list = if e.is_data() { &mut failed.data } else { &mut failed.network };
                list.push(name.clone());
                watch(Told::Note(&e.to_string()));
            }
        }
    }
    Ok(failed)
}

fn brought(job: &FetchJob, fetched: &Fetched) -> String {
    let pinned = if job.archive.sha256.is_some() { "as pinned" } else { "not pinned yet" };
    let (Fetched { size, sha256, placed }, name) = (fetched, &job.archive.name);
    let mut text = format!("{name}: {size} bytes, sha256 = \"{sha256}\", {pinned}\n");
    let mut add = |line: String| text += &format!("  {line}\n");
    placed.new.iter().for_each(|folder| add(format!("new: {folder}")));
    placed.replaced.iter().for_each(|folder| add(format!("replaced: {folder}")));
    for (folder, aside) in &placed.moved {
        let aside = aside.display();
        add(format!("{folder} had files that are not in the archive: all of the old one is in {aside}"));
    }
    for (folder, why) in &placed.refused {
        add(format!(
            "not placed: {folder}, which is not what is pinned ({why}); the download is dropped: fetch again, and if \
             it stays so, use a --mirror that has the pinned one"
        ));
    }
    placed.kept.iter().for_each(|folder| add(format!("was here, left as it is: {folder}")));
    text
}

/// Compares the fetched sequences with what is pinned.
fn check(
    wanted: &[WantedSequences],
    jobs: &[FetchJob],
    failed: &mut Failed,
    data_roots: &[PathBuf],
) -> Result<(), Failure> {
    let gone = |name: &String| failed.network.contains(name) || failed.data.contains(name);
    let arrived = |job: &&FetchJob| !gone(&job.archive.name);
    let names: BTreeSet<&String> = jobs.iter().filter(arrived).flat_map(|job| &job.sequences).collect();
    for suite in wanted.iter().map(|w| &w.suite) {
        if names.iter().any(|name| name.split('/').next() == Some(suite.name())) {
            let mut checks = Checks::default();
            checks.add(suite, data_roots, |name| names.contains(&format!("{}/{name}", suite.name())));
            output::write(&checks.text)?;
            let differing = checks.differing.into_iter().map(|(name, _)| name);
            failed.differing.extend(differing.chain(checks.missing));
        }
    }
    Ok(())
}

fn verdict(plan: &FetchPlan, failed: &Failed) -> Result<(), Failure> {
    let names = |pairs: &[(String, String)]| pairs.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    let lists = [
        ("not fetched because the connection failed (run the same again)", &failed.network),
        ("not fetched (see above)", &failed.data),
        ("not as pinned", &failed.differing),
        ("there but not as pinned (see above)", &names(&plan.broken)),
        ("to be downloaded by hand (see above)", &names(&plan.by_hand)),
    ];
    let lists = lists.into_iter().filter(|(_, names)| !names.is_empty());
    let parts: Vec<String> = lists.map(|(what, names)| format!("{what}: {}", names.join(", "))).collect();
    match (parts.is_empty(), failed.network.is_empty()) {
        (true, _) => Ok(()),
        (false, true) => Err(Failure::data(parts.join("; "))),
        (false, false) => Err(Failure::io(parts.join("; "))),
    }
}

fn failure(e: FetchError) -> Failure {
    let exit = match &e {
        FetchError::Address { .. } => Exit::Usage,
        e if e.is_data() => Exit::Data,
        _ => Exit::Io,
    };
    Failure::new(exit, e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::archive::Archive;
    use std::path::Path;
    use trackfail_testing::server::{Server, full};

    /// Serves `bytes` for all requests and returns the address.
    fn serve(bytes: &[u8]) -> String {
        Server::always(full("200 OK", &[], bytes)).archive()
    }

    fn wanted() -> Vec<WantedSequences> {
        chosen(&Catalog::default(), &["vot2014/diving".into()]).unwrap()
    }

    fn job(url: String) -> FetchJob {
        let [name, into] = ["vot2014-diving", "vot2014"].map(String::from);
        let archive = Archive { name, url, into, ..Archive::default() };
        let diving = vec!["vot2014/diving".to_string()];
        FetchJob { archive, folders: diving.clone(), sequences: diving, ..FetchJob::default() }
    }

    /// Packs a folder as the archive of `vot2014/diving`.
    fn packed(folder: &Path) -> Vec<u8> {
        let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        for (name, bytes) in trackfail_testing::files(folder) {
            let name = format!("diving/{}", name.display());
            archive.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
            archive.write_all(&bytes).unwrap();
        }
        archive.finish().unwrap().into_inner()
    }

    /// Fetches `vot2014/diving` from an archive packed from a folder.
    fn fetch_packed(folder: &Path) -> (tempfile::TempDir, Failed) {
        let root = tempfile::tempdir().unwrap();
        let space = Workspace::open(root.path()).unwrap();
        let jobs = [job(serve(&packed(folder)))];
        let mut failed = download(&space, &jobs, &FetchOptions::default()).unwrap();
        check(&wanted(), &jobs, &mut failed, &[root.path().to_path_buf()]).unwrap();
        (root, failed)
    }

    #[test]
    fn names_are_suites_or_sequences() {
        let names = |text: &[&str]| -> Vec<(String, usize)> {
            let text: Vec<String> = text.iter().map(|t| t.to_string()).collect();
            let chosen = chosen(&Catalog::default(), &text).unwrap();
            chosen.iter().map(|w| (w.suite.name().to_owned(), w.sequences.len())).collect()
        };
        assert_eq!(names(&["vot2014/ball", "vot2014/bolt"]), [("vot2014".into(), 2)]);
        assert_eq!(names(&["vot2014/ball", "vot2014"]), [("vot2014".into(), 25)]);
        assert_eq!(names(&[]).len(), Catalog::default().names().count());
    }

    #[test]
    fn consent_is_asked_for_once() {
        let root = tempfile::tempdir().unwrap();
        let space = Workspace::open(root.path()).unwrap();
        let agreed = |text: &str, answer: bool| {
            let (mut shown, mut asked) = (Vec::new(), 0);
            let ask = || {
                asked += 1;
                answer
            };
            let result = agree(&space, &[("s", text.to_owned())], ask, &mut shown);
            (result.map_err(|e| e.code()), asked, String::from_utf8(shown).unwrap())
        };
        assert_eq!(agreed("free", false), (Err(2), 1, "free".into()));
        assert_eq!(agreed("free", true), (Ok(()), 1, "free".into()));
        assert_eq!(agreed("free", false), (Ok(()), 0, String::new()));
        assert_eq!(agreed("not so free", false), (Err(2), 1, "not so free".into()));
        assert_eq!(agreed("not so free", true), (Ok(()), 1, "not so free".into()));
    }

    #[test]
    fn the_licence_is_that_of_suites_with_downloads() {
        let plan = FetchPlan { jobs: vec![job(String::new())], ..FetchPlan::default() };
        let all = chosen(&Catalog::default(), &[]).unwrap();
        let texts = suites_of(&plan, &all);
        assert_eq!(texts.len(), 1);
        assert!(texts[0].1.starts_with("vot2014: ") && texts[0].1.contains("\nlicence: "));
    }

    #[test]
    fn what_differs_from_the_pinned_is_told() {
        let folder = trackfail_testing::folder([("00000001.jpg", ""), ("groundtruth.txt", "1,2,3,4")]);
        let (root, failed) = fetch_packed(folder.path());
        assert_eq!((&failed.data, failed.differing.len()), (&vec!["vot2014-diving".to_string()], 0));
        assert!(!root.path().join("vot2014").exists(), "nothing is placed");
        let plan = fetch::plan(&wanted(), &[root.path().to_path_buf()], false);
        assert_eq!((plan.broken.len(), plan.here.len()), (0, 0));
        assert_eq!(verdict(&plan, &failed).unwrap_err().code(), 3);
    }

    fn diving() -> std::path::PathBuf {
        trackfail_testing::real_data().join("vot2014/diving")
    }

    /// Copy of vot2014/diving in which one frame has an additional byte.
    fn changed_copy() -> tempfile::TempDir {
        let mut files = trackfail_testing::files(&diving());
        files.get_mut(Path::new("00000005.jpg")).unwrap().push(0);
        trackfail_testing::folder(files)
    }

    #[trackfail_testing::needs(real_data)]
    #[test]
    fn a_changed_frame_is_not_placed() {
        let (root, failed) = fetch_packed(changed_copy().path());
        assert_eq!(failed.data, ["vot2014-diving"]);
        assert!(!root.path().join("vot2014/diving").exists());
        let downloads = root.path().join(".trackfail/downloads");
        assert_eq!(std::fs::read_dir(downloads).unwrap().count(), 0, "the next fetch starts anew");
    }

    #[trackfail_testing::needs(real_data)]
    #[test]
    fn a_fetched_folder_is_as_pinned_and_one_that_is_wrong_is_named_and_replaced_on_demand() {
        let (root, failed) = fetch_packed(&diving());
        let roots = [root.path().to_path_buf()];
        let plan = fetch::plan(&wanted(), &roots, false);
        assert_eq!(plan.here, ["vot2014/diving"]);
        assert!(verdict(&plan, &failed).is_ok(), "{failed:?}");
        let (folder, changed) = (root.path().join("vot2014/diving"), changed_copy());
        std::fs::copy(changed.path().join("00000005.jpg"), folder.join("00000005.jpg")).unwrap();
        let told = fetch::plan(&wanted(), &roots, false);
        let [(name, why)] = told.broken.as_slice() else { panic!("{told:?}") };
        assert!(name == "vot2014/diving" && why.contains("00000005.jpg is another file"), "{why}");
        assert!(why.contains("--again"), "{why}");
        assert_eq!(verdict(&told, &Failed::default()).unwrap_err().code(), 3);

        let mut plan = fetch::plan(&wanted(), &roots, true);
        assert_eq!((plan.broken.len(), plan.jobs.len()), (0, 1));
        assert_eq!(plan.jobs[0].again, ["vot2014/diving"]);
        let good = job(serve(&packed(&diving())));
        plan.jobs[0] = FetchJob { again: plan.jobs[0].again.clone(), ..good };
        let space = Workspace::open(root.path()).unwrap();
        let failed = download(&space, &plan.jobs, &FetchOptions::default()).unwrap();
        assert!(failed.data.is_empty() && failed.network.is_empty(), "{failed:?}");
        assert_eq!(fetch::plan(&wanted(), &roots, false).here, ["vot2014/diving"]);

        // The user's own folder is never replaced.
        std::fs::remove_file(folder.join(fetch::MARKER)).unwrap();
        std::fs::copy(changed.path().join("00000005.jpg"), folder.join("00000005.jpg")).unwrap();
        let plan = fetch::plan(&wanted(), &roots, true);
        assert_eq!(plan.jobs.len(), 0);
        assert!(plan.broken[0].1.contains("it was not fetched: move "), "{plan:?}");
    }

    #[test]
    fn the_exit_code_tells_the_network_from_the_data() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let dead = job(format!("http://{}/a", listener.local_addr().unwrap()));
        drop(listener);
        let root = tempfile::tempdir().unwrap();
        let space = Workspace::open(root.path()).unwrap();
        let mut options = FetchOptions::default();
        options.patience.pause = std::time::Duration::ZERO;
        let failed = download(&space, &[dead, job(serve(b"no archive"))], &options).unwrap();
        assert_eq!((failed.network.len(), failed.data.len()), (1, 1));
        assert_eq!(verdict(&FetchPlan::default(), &failed).unwrap_err().code(), 1);
        let by_hand = FetchPlan { by_hand: vec![("a/b".into(), "x".into())], ..FetchPlan::default() };
        assert_eq!(verdict(&by_hand, &Failed::default()).unwrap_err().code(), 3);
        assert!(verdict(&FetchPlan::default(), &Failed::default()).is_ok());
        assert_eq!(download(&space, &[job("ftp://h/a".into())], &options).unwrap_err().code(), 2);
    }
}
