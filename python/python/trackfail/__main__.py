"""Runs the command line: `python -m trackfail detect ...`.

The program is larger than this package may be, and a package of its own: `pip install ./python/program`. It is looked for
as TRACKFAIL_PROGRAM says, then among the scripts of this Python, then on the PATH.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig

REMEDY = """error: the program `trackfail` is not installed; in a checkout do one of
  pip install ./python/program
  cargo install --path ."""


def program() -> str | None:
    """The program, if there is one."""
    named = os.environ.get("TRACKFAIL_PROGRAM")
    return shutil.which(named) if named else _installed()


def _installed() -> str | None:
    return shutil.which("trackfail", path=sysconfig.get_path("scripts")) or shutil.which("trackfail")


def main() -> int:
    """Runs the program with the arguments given."""
    found = program()
    if found is None:
        print(REMEDY, file=sys.stderr)
        return 2
    command = [found, *sys.argv[1:]]
    if os.name == "posix":
        os.execv(found, command)
    return subprocess.call(command)


if __name__ == "__main__":
    sys.exit(main())
