"""Judgements of whole tracks agree with the program, whatever the frames come from."""

from __future__ import annotations

import dataclasses
import itertools
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest

import trackfail
from conftest import Rendered, Run
from trackfail._types import Floats, Picture
from trackfail.integrations import by_id


@pytest.fixture(scope="module")
def detected(rendered: Rendered, run: Run, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., pl.DataFrame]:
    boxes = tmp_path_factory.mktemp("boxes") / "boxes.txt"
    np.savetxt(boxes, rendered.boxes, delimiter=",", fmt="%.17g")

    def detect(*arguments: object) -> pl.DataFrame:
        out = run("detect", "--boxes", boxes, "--base", 0, "--format", "csv", *arguments)
        return pl.read_csv(StringIO(out)).with_columns(pl.col("frame") - 1)

    return detect


def test_columns_are_those_of_the_program(rendered: Rendered, detected: Callable[..., pl.DataFrame]) -> None:
    want = detected("--frames", rendered.folder)
    judged = trackfail.judge(rendered.folder, rendered.boxes)
    got = judged.to_polars()
    assert got.columns == want.columns
    assert got.rows() == want.rows()
    assert judged.losses and judged.method == "Fused deep" == trackfail.recommended(frames=True)
    want = detected("--method", "Displacement")
    assert trackfail.judge(None, rendered.boxes, method="Displacement").to_polars().rows() == want.rows()


def test_frames_may_come_from_anywhere(rendered: Rendered) -> None:
    arrays = [frame.to_numpy() for frame in rendered.frames]

    def one_after_the_other() -> Iterator[Picture]:
        yield from rendered.frames

    frames: list[Any] = [
        rendered.folder,
        str(rendered.folder / "img"),
        rendered.paths,
        rendered.frames,
        arrays,
        np.stack(arrays),
        one_after_the_other(),
    ]
    boxes = [None, *rendered.boxes[1:]]
    judged = [trackfail.judge(given, boxes, method="First colors", colors="rgb") for given in frames]
    for other in judged[1:]:
        np.testing.assert_array_equal(other.score, judged[0].score)
    assert judged[0].state[0] == "absent" and np.isnan(judged[0].score[0])


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg decodes videos")
def test_a_video(rendered: Rendered, detected: Callable[..., pl.DataFrame], tmp_path: Path) -> None:
    video = tmp_path / "clip.mp4"
    pattern = rendered.paths[0].parent / f"%0{len(rendered.paths[0].stem)}d{rendered.paths[0].suffix}"
    command = ["ffmpeg", "-loglevel", "error", "-i", str(pattern), "-c:v", "mpeg4", "-q:v", "2", str(video)]
    subprocess.run(command, check=True)
    want = detected("--frames", video, "--method", "First colors")
    assert trackfail.judge(video, rendered.boxes, method="First colors").to_polars().rows() == want.rows()
    boxes = [*rendered.boxes]
    for others, count in [(boxes[:-1], 189), ([*boxes, boxes[0]], 191), ([*boxes, None], 191)]:
        for method in ("First colors", "Displacement"):
            with pytest.raises(ValueError, match=f"190 frames and {count} boxes"):
                trackfail.judge(video, others, method=method)
    broken = tmp_path / "broken.mp4"
    broken.write_bytes(b"no video")
    with pytest.raises(ValueError, match="no video that ffmpeg reads"):
        trackfail.judge(broken, rendered.boxes, method="First colors")


@pytest.mark.skipif(sys.platform == "win32", reason="the program that stands for ffmpeg is a script")
@pytest.mark.parametrize("method", ["First colors", "Displacement"])
def test_a_video_that_is_damaged_after_its_last_box(method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pixels = np.random.default_rng(0).integers(0, 256, 48 * 64 * 3, dtype=np.uint8)
    (tmp_path / "frame.ppm").write_bytes(b"P6\n64 48\n255\n" + pixels.tobytes())
    ffmpeg = tmp_path / "ffmpeg"
    ffmpeg.write_text('#!/bin/sh\ncat "$(dirname "$0")/frame.ppm"\necho "no more of it" >&2\nexit 1\n')
    ffmpeg.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    with pytest.raises(ValueError, match=r"a damaged one \(ffmpeg: no more of it\)"):
        trackfail.judge(tmp_path / "frame.ppm", [(10, 8, 20, 16)], method=method)


@pytest.mark.parametrize("method", ["First colors", "Displacement"])
def test_frames_are_as_many_as_boxes(method: str) -> None:
    frames = np.random.default_rng(0).integers(0, 256, (6, 48, 64, 3), dtype=np.uint8)
    box = (10, 8, 20, 16)
    cases: list[tuple[Any, list[Any], str]] = [
        (frames, [box] * 5, "more than 5 frames and 5 boxes"),
        (frames, [*[box] * 5, None, None], "6 frames and 7 boxes"),
        (itertools.repeat(frames[0]), [box] * 5, "more than 5 frames and 5 boxes"),
    ]
    for given, boxes, words in cases:
        with pytest.raises(ValueError, match=f"there are {words}; there must be one box for each frame"):
            trackfail.judge(iter(given), boxes, method=method, colors="rgb")
    assert len(trackfail.judge(iter(frames), [None, *[box] * 4, None], method=method, colors="rgb")) == 6


def test_all_targets_of_a_video_in_one_pass(rendered: Rendered) -> None:
    given = 0

    def count() -> Iterator[Picture]:
        nonlocal given
        for frame in rendered.frames:
            given += 1
            yield frame

    tracks = {"still": rendered.boxes, "truth": rendered.truth}
    judged = trackfail.judge(count(), tracks, method="First colors")
    assert given == len(rendered.frames) and list(judged) == ["still", "truth"]
    for name, boxes in tracks.items():
        alone = trackfail.judge(rendered.frames, boxes, method="First colors")
        np.testing.assert_array_equal(judged[name].score, alone.score)


def jumping() -> Floats:
    """A target that moves slowly and jumps away in frame 40."""
    return np.array([[t if t < 40 else 300.0, 20, 16, 14] for t in range(60)])


def test_a_judgement_may_ask_for_another_one() -> None:
    script = """
import numpy as np, trackfail
def frames():
    for t in range(3):
        trackfail.judge(None, [(5, 5, 20, 20)] * 3, method="Displacement")
        yield np.full((40, 40), t, np.uint8)
print(len(trackfail.judge(frames(), [(5, 5, 20, 20)] * 3, method="First colors")))
"""
    alone = {**os.environ, "RAYON_NUM_THREADS": "1"}
    ran = subprocess.run([sys.executable, "-c", script], env=alone, capture_output=True, text=True, timeout=120, check=True)
    assert ran.stdout == "3\n"


def test_what_is_compared_with_the_threshold(rendered: Rendered) -> None:
    frames, boxes = rendered.frames[:30], rendered.boxes[:30]
    colors, fused = (trackfail.judge(frames, boxes, method=method) for method in ("First colors", "Fused deep"))
    assert colors.alarm_score is None and fused.alarm_score is not None and len(fused.alarm_score) == 30


def test_confidence_and_companions() -> None:
    boxes = jumping()
    sure = trackfail.judge(None, boxes, confidence=np.where(np.arange(60) < 40, 0.9, 0.1))
    assert sure.method == trackfail.recommended(confidence=True) == "Confidence"
    assert trackfail.judge(None, boxes, companions=[boxes, boxes + 1]).method == "Fused companions"
    assert trackfail.judge(None, boxes, budget=5).method == "Fused boxes"


def test_confidence_may_be_missing_but_not_infinite() -> None:
    boxes, confidence = jumping(), [0.9] * 59
    none, nan = (trackfail.judge(None, boxes, confidence=[*confidence, missing]) for missing in (None, float("nan")))
    np.testing.assert_array_equal(none.score, nan.score)
    for infinite in (float("inf"), -float("inf")):
        with pytest.raises(ValueError, match=r"confidence, frame 59: -?inf is not a finite number"):
            trackfail.judge(None, boxes, confidence=[*confidence, infinite])


def test_a_video_without_targets(tmp_path: Path) -> None:
    frames = np.zeros((3, 48, 64), np.uint8)
    for given in (None, frames, iter(frames), list(frames), tmp_path, tmp_path / "clip.mp4"):
        assert trackfail.judge(given, by_id([], frames=3)) == {}
    with pytest.raises(ValueError, match="3 frames and 0 boxes"):
        trackfail.judge(frames, {"a": []})


def test_boxes_may_be_data_frames() -> None:
    boxes = jumping()
    boxes[7] = np.nan
    want = trackfail.judge(None, boxes, method="Displacement")
    tables: list[Any] = [pd.DataFrame(boxes, columns=list("xywh")), pl.DataFrame(boxes, schema=list("xywh"))]
    for table in tables:
        judged = trackfail.judge(None, table, method="Displacement")
        np.testing.assert_array_equal(judged.score, want.score)
        both = trackfail.judge(None, {"one": table}, method="Displacement")
        np.testing.assert_array_equal(both["one"].score, want.score)
        assert trackfail.errors(table, boxes)[0] == 0


def test_judgements_are_compared_as_objects() -> None:
    one, other = (trackfail.judge(None, jumping(), method="Displacement") for _ in range(2))
    assert one != other and len({one, other}) == 2


def test_what_is_refused(rendered: Rendered) -> None:
    def broken() -> Iterator[Picture]:
        yield rendered.frames[0]
        raise KeyError("camera")

    boxes = rendered.boxes
    with pytest.raises(KeyError, match="camera"):
        trackfail.judge(broken(), boxes, method="First colors")
    with pytest.raises(ValueError, match="3 frames and 190 boxes"):
        trackfail.judge(iter(rendered.frames[:3]), boxes, method="First colors")
    with pytest.raises(ValueError, match="189 frames and 190 boxes"):
        trackfail.judge(rendered.frames[1:], boxes)
    with pytest.raises(ValueError, match="needs frames"):
        trackfail.judge(None, boxes, method="First colors")
    with pytest.raises(ValueError, match="AVU` needs more of a tracker"):
        trackfail.judge(rendered.folder, boxes, method="AVU")
    with pytest.raises(ValueError, match="boxes, frame 1: the region has no area"):
        trackfail.judge(None, [[1, 2, 3, 4], [1, 2, 0, 4]])
    with pytest.raises(ValueError, match="confidence has 3 frames, the track 190"):
        trackfail.judge(None, boxes, confidence=[0.5] * 3)
    with pytest.raises(ValueError, match="the frame has 8x8 pixels, those before had"):
        trackfail.judge([*rendered.frames[:-1], np.zeros((8, 8), np.uint8)], boxes, method="First colors")
    with pytest.raises(ValueError, match="base: want 0 or 1"):
        trackfail.judge(None, boxes, base=3)
    with pytest.raises(ValueError, match="uint8"):
        trackfail.judge(np.zeros((190, 8, 8, 3)), boxes, colors="rgb")
    with pytest.raises(FileNotFoundError):
        trackfail.judge("nowhere", boxes)


def test_tables_pages_and_pictures(tmp_path: Path) -> None:
    judged = trackfail.judge(None, jumping(), method="Displacement")
    assert judged.losses[0][0] == 40 and len(judged) == 60
    frame = judged.to_pandas()
    assert list(frame.columns) == ["frame", "method", "score", "label", "change", "state"]
    assert frame.state[40] == "lost" and frame.change[40] == 1
    page = tmp_path / "page.html"
    judged.report(page)
    text = page.read_text()
    assert "Lost from frame 40 to " in text and "<svg" in text and "http" not in text
    # The score that speaks loudest for a loss.
    start, end = judged.losses[0]
    for high_is_good, extreme, t in [(False, "largest", end - 1), (True, "smallest", start)]:
        dataclasses.replace(judged, high_is_good=high_is_good, score=np.linspace(0, 1, 60)).report(page)
        text = page.read_text()
        assert f"<th>{extreme} score</th>" in text and f"<td>{t / 59:.3g}</td></tr>" in text
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    from matplotlib import pyplot

    axes = judged.plot()
    assert axes.get_title() == "Displacement" and len(axes.patches) == len(judged.losses)
    pyplot.close("all")
