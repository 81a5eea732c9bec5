"""The program that the package has to agree with, and frames that it has rendered."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

from trackfail import Frame, Judgement
from trackfail._types import Floats

CHECKOUT = Path(__file__).parents[2]
Run: TypeAlias = Callable[..., str]


@pytest.fixture(scope="session")
def program() -> str:
    """The program: TRACKFAIL_PROGRAM, or the one that cargo has built."""
    built = [CHECKOUT / "target" / kind / "trackfail" for kind in ("debug", "release")]
    named = [os.environ.get("TRACKFAIL_PROGRAM"), *map(str, built)]
    for name in named:
        if name and (found := shutil.which(name)):
            return found
    words = "there is no program to agree with: build it by `cargo build`, or name it as TRACKFAIL_PROGRAM"
    if os.environ.get("CI"):
        pytest.fail(words)
    pytest.skip(words)


@pytest.fixture(scope="session")
def run(program: str) -> Run:
    """Runs the program and gives what it prints."""

    def run(*arguments: object, given: str = "") -> str:
        command = [program, *map(str, arguments)]
        ran = subprocess.run(command, input=given, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stderr
        return ran.stdout

    return run


@dataclass(frozen=True)
class Rendered:
    """A rendered sequence; the tracker stays where the target was at first."""

    folder: Path
    paths: list[Path]
    frames: list[Frame]
    truth: Floats
    boxes: Floats

    def lines(self, **more: Any) -> str:
        """The lines for `trackfail monitor`."""
        pairs = zip(self.paths, self.boxes.tolist(), strict=True)
        return "".join(json.dumps({"frame": str(path), "box": box, **more}) + "\n" for path, box in pairs)


@pytest.fixture(scope="session")
def rendered(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Rendered:
    """The sequence Tennis."""
    suite = tmp_path_factory.mktemp("rendered") / "suite"
    run("data", "render", "synthetic-otb", suite, "--sequence", "Tennis")
    folder = suite / "Tennis"
    paths = sorted((folder / "img").iterdir())
    truth = np.loadtxt(folder / "groundtruth_rect.txt", delimiter=",")
    return Rendered(folder, paths, [Frame(path) for path in paths], truth, np.tile(truth[0], (len(paths), 1)))


def told(judgement: Judgement) -> dict[str, Any]:
    """A judgement as the program writes it."""
    probability = judgement.probability
    answer: dict[str, Any] = {
        "index": judgement.index,
        "probability": None if probability is None else round(probability, 4),
        "state": judgement.state,
        "reasons": list(judgement.reasons),
    }
    return answer if judgement.note is None else {**answer, "note": judgement.note}


def answers(out: str) -> list[dict[str, Any]]:
    """The answers of the program."""
    return [json.loads(line) for line in out.splitlines()]
