"""`python -m trackfail` runs the program."""

from __future__ import annotations

import os
import subprocess
import sys


def ran(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "trackfail", *arguments]
    environment = {**os.environ, "TRACKFAIL_PROGRAM": program}
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=False)


def test_its_words_and_exit_codes_are_passed_on(program: str) -> None:
    assert ran(program, "--version").stdout.startswith("trackfail ")
    assert ran(program, "detect", "--boxes", "nowhere.txt").returncode == 3


def test_without_it_the_error_says_how_to_get_it() -> None:
    absent = ran("no-such-program")
    assert absent.returncode == 2 and "pip install ./python/program" in absent.stderr
