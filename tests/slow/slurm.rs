//! Batch scripts on a real SLURM.

mod cluster;

use crate::tools::slurm::{HOSTILE, calls, expected, script};
use crate::tools::{Place, assert_same_files, needs, trackfail};
use cluster::{Cluster, wait_for};
use std::process::Command;
use trackfail_testing::script as executable;

/// Numbers of the array's and the report's job, read from the program's output.
fn job_numbers(told: &str) -> [String; 2] {
    let jobs = told.lines().filter(|line| line.contains(": job "));
    let numbers: Vec<_> = jobs.filter_map(|l| l.rsplit(' ').next()).map(str::to_string).collect();
    numbers.try_into().unwrap_or_else(|_| panic!("{told}"))
}

/// A program that writes its arguments to a file named after its share. Share 2 has failed cells; share 3 works until it
/// is told to stop.
const TASK: &str = r#"
share=report previous=
for word; do
    if [ "$previous" = --shard ]; then share=${word%/*}; fi
    previous=$word
done
echo "this is $share in $PWD"
{ printf '%s\0' "$@"; printf '\036'; } > "${0%/*}/call-$share.new"
mv "${0%/*}/call-$share.new" "${0%/*}/call-$share"
case $share in
2) exit 4 ;;
3)
    trap 'exit 130' TERM
    while :; do sleep 0.1; done
    ;;
esac
"#;

#[needs(slurm)]
#[test]
fn slurm_runs_the_report_behind_tasks_that_failed_or_were_stopped() {
    let cluster = Cluster::start();
    let place = Place::new();
    let root = place.folder(HOSTILE);
    let folder = root.join("slurm");
    let program = root.join("program");
    executable(&program, TASK);
    let lines = ["#SBATCH --comment=mine", "module() { echo \"loads $1\"; }", "module it"];
    let mut more = vec!["--time", "00:05:00", "--memory", "500M"];
    more.extend(lines.iter().flat_map(|line| ["--line", *line]));
    let path = script(&root, &program, "results", &more);
    let [shards, report] = job_numbers(&cluster.output(Command::new("sh").arg(path)));

    let call = |share: &str| root.join(format!("call-{share}"));
    wait_for(&cluster, "task 3", || call("3").exists());
    assert!(!call("report").exists(), "the report waits for the array");
    // What --signal=B:TERM@120 does two minutes before the end.
    cluster.output(Command::new("scancel").args(["--batch", "--signal=TERM", &format!("{shards}_3")]));
    cluster.wait_until_idle();

    let logged = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    for share in ["1", "2", "3"] {
        assert_eq!(calls(&std::fs::read(call(share)).unwrap()), [expected(&root, "results", Some(share))]);
        let line = format!("loads it\nthis is {share} in {}\n", folder.display());
        assert!(logged(&format!("shard-{shards}_{share}.log")).contains(&line));
    }
    assert_eq!(calls(&std::fs::read(call("report")).unwrap()), [expected(&root, "results", None)]);
    let line = format!("loads it\nthis is report in {}\n", folder.display());
    assert_eq!(logged(&format!("report-{report}.log")), line);
    let of_report = |field: &str| cluster.field(&report, field).into_values().collect::<Vec<_>>();
    assert_eq!(of_report("Comment="), ["mine"]);
    let codes = [("1", "0:0"), ("2", "4:0"), ("3", "130:0")].map(|(i, c)| (i.to_string(), c.to_string()));
    assert_eq!(cluster.field(&shards, "ExitCode="), std::collections::BTreeMap::from(codes));
    assert_eq!(of_report("ExitCode="), ["0:0"]);
}

#[needs(slurm)]
#[test]
fn quickstart_in_three_shards_gives_the_bytes_of_a_plain_run() {
    let cluster = Cluster::start();
    let place = Place::new();
    let root = place.folder(HOSTILE);
    let in_folder = |name: &str, arguments: &[&str]| {
        let mut command = trackfail();
        command.current_dir(&root).env("SLURM_CONF", &cluster.configuration).args(arguments);
        for (option, folder) in [("--results", "results"), ("--reports", "reports")] {
            command.arg(option).arg(root.join(name).join(folder));
        }
        String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap()
    };
    in_folder("plain", &["run", "quickstart", "--quiet"]);
    let submit =
        ["slurm", "quickstart", "--shards", "3", "--submit", "--memory", "500M", "--output", "shared"];
    let jobs = job_numbers(&in_folder("shared", &submit));
    cluster.wait_until_idle();
    let codes = jobs.clone().map(|job| cluster.field(&job, "ExitCode=").into_values().collect::<Vec<_>>());
    assert_eq!(codes, [vec!["0:0"; 3], vec!["0:0"]]);
    // The report job computes nothing.
    let log = std::fs::read_to_string(root.join("shared").join(format!("report-{}.log", jobs[1]))).unwrap();
    assert!(log.contains("tracks 0 computed, 78 cached; signals 0 computed, 198 cached"), "{log}");
    for folder in ["results/quickstart", "reports"] {
        assert_same_files(&root.join("shared").join(folder), &root.join("plain").join(folder));
    }
}
