"""Classes run as signals and detectors of an experiment."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import polars as pl
import pytest

import trackfail
from conftest import Run
from trackfail import plugin

CLASSES = """
import sys
from trackfail import plugin

@plugin.signal(good="low")
class BoxSize:
    def __init__(self, rate=0.1):
        self.rate, self.mean = rate, None

    def update(self, frame, box, confidence, **more):
        print("no answer", more["absent"])
        size = box[2] * box[3]
        self.mean = size if self.mean is None else self.mean
        change = abs(size - self.mean)
        self.mean += self.rate * (size - self.mean)
        return change

@plugin.signal("brightness", reads="pixels", version="2")
class Brightness:
    def update(self, frame, box):
        return frame.mean()

@plugin.detector(signals=2)
class Above:
    def __init__(self, level):
        self.level = level

    def update(self, value, *more):
        return value, value > self.level
"""

EXPERIMENT = """
schema = 1
name = "mine"
title = "Classes of mine"
protocol = "khalid2016/1"
seed = 1
suites.test = "synthetic-otb"
tracker = [{ name = "still", label = "Still" }]

[[method]]
name = "Brightness"
signal = { kind = "process", program = "brightness", good = "high", reads = "pixels" }
detector = { kind = "level", below = 100.0 }

[[method]]
name = "Both"
signal = [
    { kind = "process", program = "brightness", good = "high", reads = "pixels" },
    { kind = "process", program = "box-size", good = "low", reads = "boxes", params = { rate = 0.2 } },
]
detector = { kind = "process", program = "above", signals = 2, params = { level = 100.0 } }
"""


@pytest.fixture
def classes(tmp_path: Path) -> Path:
    file = tmp_path / "mine.py"
    file.write_text(CLASSES)
    return file


def serve(file: Path, name: str, *messages: object) -> subprocess.CompletedProcess[str]:
    given = "".join(json.dumps(message) + "\n" for message in messages)
    command = [sys.executable, "-m", "trackfail.plugin", file.name, name]
    return subprocess.run(command, input=given, capture_output=True, text=True, cwd=file.parent, check=False)


def meta(**params: object) -> object:
    return {"meta": {"protocol": 1, "program": "mine", "role": "signal", "frames": 2, "params": params}}


def line(index: int, size: float) -> object:
    return {"index": index, "frame": None, "box": [0, 0, size, 1], "absent": False, "confidence": None}


def test_answers_of_a_track(classes: Path) -> None:
    ran = serve(classes, "signal.box-size", meta(rate=0.5), line(0, 10), line(1, 14))
    assert [json.loads(answer) for answer in ran.stdout.splitlines()] == [
        {"index": 0, "score": 0.0},
        {"index": 1, "score": 4.0},
    ]
    assert ran.returncode == 0 and ran.stderr.count("no answer False") == 2
    ran = serve(classes, "detector.above", meta(level=1), {"index": 0, "value": 2, "more": [3]})
    assert json.loads(ran.stdout) == {"index": 0, "score": 2.0, "label": 1}


def test_faults_end_the_program_with_a_reason(classes: Path) -> None:
    for name, messages, words in [
        ("signal.box-size", (meta(wrong=1),), "wrong"),
        ("signal.box-size", (meta(), line(0, float("inf"))), "the score of frame 0 is nan"),
        ("signal.none", (meta(),), "it has signal.box-size, signal.brightness, detector.above"),
    ]:
        ran = serve(classes, name, *messages)
        assert ran.returncode != 0 and words in ran.stderr and ran.stdout == "", ran
    with pytest.raises(ValueError, match='good: want "high" or "low"'):
        plugin.signal(good="Low")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="no method `update`"):
        plugin.signal("wrong")(int)


def test_the_file_of_programs(classes: Path) -> None:
    tomllib: Any = pytest.importorskip("tomllib")
    text = plugin.toml(classes)
    assert "keep both in one folder" in text
    # As often as one likes.
    assert plugin.toml(classes) == text
    file = classes.with_name("\N{GRINNING FACE}.py")
    file.write_text(CLASSES)
    command = [sys.executable, "-m", "trackfail.plugin", file.name]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    out = subprocess.run(command, cwd=file.parent, env=environment, stdout=subprocess.PIPE, check=True).stdout
    program = tomllib.loads(out.decode())["signal"]["box-size"]
    assert program["digest"] == [file.name] and program["command"][3:] == [file.name, "signal.box-size"]


def test_an_experiment_runs_them(classes: Path, run: Run) -> None:
    folder = classes.parent
    (folder / "plugins.toml").write_text(plugin.toml(classes))
    (folder / "mine.toml").write_text(EXPERIMENT)
    results, reports = folder / "results", folder / "reports"
    run("run", folder / "mine.toml", "--plugins", folder / "plugins.toml", "--results", results, "--reports", reports)
    frames = trackfail.load(results / "mine", "polars").frames
    one, both = (frames.filter(pl.col("method") == name)["score"] for name in ("Brightness", "Both"))
    assert len(one) > 1000 and one.to_list() == both.to_list() and one.n_unique() > 10
