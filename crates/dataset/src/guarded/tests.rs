//! Guarded programs in these tests are shells. A library's tests have no guard, only the shell of other
//! systems.

use super::*;

#[test]
fn the_end_of_a_long_message_is_kept() {
    let long = format!("{}last", "x".repeat(100_000));
    let kept = Tail::new(std::io::Cursor::new(long)).text();
    assert!(kept.len() == MAX_TAIL_BYTES && kept.ends_with("xlast"), "{}", kept.len());
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::io::{BufRead, BufReader};
    use trackfail_testing::is_gone;

    fn start(script: &str, folder: Option<&Path>) -> Guarded {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        Guarded::start(command, [Stdio::null(), Stdio::piped()], folder).unwrap()
    }

    /// First line of the program's stdout.
    fn line(program: &mut Guarded) -> String {
        let mut line = String::new();
        BufReader::new(program.stdout().unwrap()).read_line(&mut line).unwrap();
        line.trim().to_string()
    }

    #[test]
    fn what_holds_the_streams_is_not_waited_for_and_ends() {
        let script = "sleep 1000 & echo $!; echo 'no memory' >&2; exit 7";
        let mut program = start(script, None);
        let held = line(&mut program);
        let status = program.wait(|| Ok::<(), ()>(())).unwrap().unwrap();
        assert_eq!((status.code(), program.stderr().as_str()), (Some(7), "no memory\n"));
        assert!(is_gone(&held));
    }

    #[test]
    fn a_reason_not_to_wait_ends_all_of_it() {
        let mut program = start("sleep 1000 & echo $!; wait", None);
        let child = line(&mut program);
        let outcome = program.wait(|| Err("interrupted")).unwrap();
        assert_eq!(outcome, Err("interrupted"));
        assert!(is_gone(&child));
        // Once more, and when it is dropped, does nothing.
        program.end();
    }

    #[test]
    fn a_folder_outlives_the_program_while_this_one_lives() {
        let folder = tempfile::tempdir().unwrap();
        let mut program = start("exit 0", Some(folder.path()));
        program.wait(|| Ok::<(), ()>(())).unwrap().unwrap();
        drop(program);
        drop(start("sleep 1000", Some(folder.path())));
        assert!(folder.path().is_dir());
    }

    #[test]
    fn what_cannot_be_started_is_an_error() {
        let command = Command::new("no-such-program");
        let started = Guarded::start(command, [Stdio::null(), Stdio::null()], None);
        assert_eq!(started.err().unwrap().kind(), std::io::ErrorKind::NotFound);
    }
}
