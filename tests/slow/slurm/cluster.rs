//! A SLURM of one node, started by a test in a folder of its own: munged, slurmctld and slurmd with
//! free ports, a key and a socket of their own, as the user who runs the test.

use std::collections::BTreeMap;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use trackfail_testing::within;

/// When a job that never ends is given up.
const LIMIT: Duration = Duration::from_secs(600);
/// When a daemon that does not end by itself is ended.
const GRACE: Duration = Duration::from_secs(20);

/// The running daemons; dropping it ends jobs and daemons.
pub struct Cluster {
    root: tempfile::TempDir,
    daemons: Vec<Child>,
    /// `SLURM_CONF` for its clients.
    pub configuration: PathBuf,
}

impl Cluster {
    /// Starts it and waits until its node takes jobs; its test is marked `#[needs(slurm)]`.
    pub fn start() -> Self {
        let root = tempfile::tempdir().unwrap();
        // munged wants the way to its socket open to all.
        std::fs::set_permissions(root.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
        let configuration = root.path().join("slurm.conf");
        let mut cluster = Self { root, daemons: Vec::new(), configuration };
        cluster.write_configuration();
        cluster.start_munged();
        for program in ["slurmctld", "slurmd"] {
            let mut command = Command::new(program);
            cluster.spawn(program, command.arg("-D").arg("-f").arg(&cluster.configuration));
        }
        wait_for(&cluster, "an idle node", || {
            cluster.try_output("sinfo", &["-h", "-o", "%t"]).trim() == "idle"
        });
        cluster
    }

    fn write_configuration(&self) {
        let root = self.root.path();
        for folder in ["state", "spool"] {
            std::fs::create_dir(root.join(folder)).unwrap();
        }
        let user = self.output(Command::new("id").arg("-un"));
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
        let host = host.trim().split('.').next().unwrap();
        // Both stay bound until both are known, so that they are two.
        let listeners = [(); 2].map(|()| TcpListener::bind("127.0.0.1:0").unwrap());
        let [controller, node] = listeners.map(|l| l.local_addr().unwrap().port());
        let text = format!(
            "ClusterName=trackfail\n\
             SlurmctldHost={host}(127.0.0.1)\n\
             SlurmctldPort={controller}\n\
             SlurmdPort={node}\n\
             AuthType=auth/munge\n\
             AuthInfo=socket={root}/munge.socket\n\
             SlurmUser={user}\n\
             SlurmdUser={user}\n\
             StateSaveLocation={root}/state\n\
             SlurmdSpoolDir={root}/spool\n\
             SlurmctldPidFile={root}/slurmctld.pid\n\
             SlurmdPidFile={root}/slurmd.pid\n\
             ProctrackType=proctrack/pgid\n\
             TaskPlugin=task/none\n\
             MpiDefault=none\n\
             SelectType=select/cons_tres\n\
             SelectTypeParameters=CR_Core_Memory\n\
             SlurmdParameters=config_overrides\n\
             ReturnToService=2\n\
             KillWait=5\n\
             NodeName=one NodeHostname={host} NodeAddr=127.0.0.1 CPUs=3 RealMemory=4096\n\
             PartitionName=main Nodes=one Default=YES MaxTime=INFINITE State=UP\n",
            root = root.display(),
            user = user.trim(),
        );
        std::fs::write(&self.configuration, text).unwrap();
    }

    fn start_munged(&mut self) {
        let root = self.root.path().to_path_buf();
        // Who knows the key can run jobs as the user of this test.
        let key = "umask 377; head -c 128 /dev/urandom > munge.key";
        assert!(Command::new("sh").args(["-c", key]).current_dir(&root).status().unwrap().success());
        let mut command = Command::new("munged");
        command.arg("--foreground");
        for option in ["key-file", "socket", "pid-file", "log-file", "seed-file"] {
            let ending = option.trim_end_matches("-file");
            command.arg(format!("--{option}={}/munge.{ending}", root.display()));
        }
        self.spawn("munged", &mut command);
        wait_for(self, "munged's socket", || root.join("munge.socket").exists());
    }

    fn spawn(&mut self, name: &str, command: &mut Command) {
        let log = std::fs::File::create(self.root.path().join(format!("{name}.out"))).unwrap();
        let streams = (log.try_clone().unwrap(), log);
        self.daemons.push(command.stdin(Stdio::null()).stdout(streams.0).stderr(streams.1).spawn().unwrap());
    }

    /// Runs a client of the cluster to success and gives its stdout.
    pub fn output(&self, command: &mut Command) -> String {
        let output = command.env("SLURM_CONF", &self.configuration).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        assert!(output.status.success(), "{command:?}: {}", text(&output.stderr));
        text(&output.stdout)
    }

    /// Standard output of a client, successful or not.
    fn try_output(&self, program: &str, arguments: &[&str]) -> String {
        let output = Command::new(program).args(arguments).env("SLURM_CONF", &self.configuration).output();
        output.map(|o| String::from_utf8_lossy(&o.stdout).into_owned()).unwrap_or_default()
    }

    /// Waits until no job is queued or running.
    pub fn wait_until_idle(&self) {
        wait_for(self, "the end of all jobs", || {
            self.output(Command::new("squeue").args(["-h", "-o", "%i"])).trim().is_empty()
        });
    }

    /// Task (or job number) -> a field of a job that is done: its `Comment=`, or `code:signal` as its `ExitCode=`.
    pub fn field(&self, job: &str, name: &str) -> BTreeMap<String, String> {
        let jobs = self.output(Command::new("scontrol").args(["show", "job", "-o", job]));
        let of = |line: &str| {
            let field = |key: &str| line.split(' ').find_map(|f| f.strip_prefix(key)).map(str::to_string);
            Some((field("ArrayTaskId=").or_else(|| field("JobId="))?, field(name)?))
        };
        jobs.lines().filter_map(of).collect()
    }

    /// Logs of the daemons.
    fn logs(&self) -> String {
        let log = |name: &str| {
            let path = self.root.path().join(format!("{name}.out"));
            format!("--- {name}\n{}\n", std::fs::read_to_string(path).unwrap_or_default())
        };
        ["munged", "slurmctld", "slurmd"].map(log).concat()
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        if self.daemons.len() == 3 {
            // Jobs first: slurmd leaves their processes running when it ends.
            let user = self.try_output("id", &["-un"]);
            self.try_output("scancel", &["--user", user.trim()]);
            within(GRACE, || self.try_output("squeue", &["-h", "-o", "%i"]).trim().is_empty());
            self.try_output("scontrol", &["shutdown"]);
        }
        // munged is the first and does not end with the others.
        while let Some(mut daemon) = self.daemons.pop() {
            let ends_itself = !self.daemons.is_empty();
            if !(ends_itself && within(GRACE, || !matches!(daemon.try_wait(), Ok(None)))) {
                let _ = daemon.kill();
            }
            let _ = daemon.wait();
        }
    }
}

/// Waits for something to become true; fails loudly when it does not.
#[track_caller]
pub fn wait_for(cluster: &Cluster, what: &str, is_so: impl FnMut() -> bool) {
    assert!(within(LIMIT, is_so), "waited in vain for {what}\n{}", cluster.logs());
}
