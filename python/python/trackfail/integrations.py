"""Trackers and result files of other packages, in a line each.

| what | from | gives |
|---|---|---|
| `watch_opencv` | a tracker of OpenCV: KCF, CSRT, Nano, ... | box and judgement of each frame, while it tracks |
| `watch_results` | what Ultralytics' `model.track` gives | judgements of each frame by id, while it tracks |
| `by_id` | a table as MOTChallenge has it, of norfair or boxmot | boxes of each target, for `trackfail.judge` |
| `read_pytracking`, `read_pysot` | result folders | boxes, and confidence, of each sequence, for `trackfail.judge` |

None of these packages is needed, or imported, unless its objects are given. Numbers without area say that there is no box.
"""

from __future__ import annotations

import importlib
import math
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ._judge import _rows
from ._monitor import Judgement, Monitor
from ._trackfail import Frame
from ._types import Box

Numbers: TypeAlias = tuple[float, ...]


def watch_opencv(
    tracker: Any, frames: Any, box: Box, monitor: Monitor | None = None
) -> Iterator[tuple[Numbers | None, Judgement]]:
    """Starts a tracker of OpenCV on a target and gives its box, None where it has none, and the judgement of each frame.

    Args:
        tracker: A new tracker: `cv2.TrackerCSRT.create()`, `cv2.TrackerNano.create(params)`, ...
        frames: BGR arrays, the first of which has the target in `box`; a `cv2.VideoCapture`, or what opens one: the path of a
            video, or a pattern such as `img/%04d.jpg`.
        box: The target in the first frame; it is rounded, since OpenCV starts at whole pixels.
        monitor: The monitor, otherwise `trackfail.Monitor()`.

    Raises:
        ValueError: For a box without area, and a video that cannot be opened.
    """
    judging = Monitor() if monitor is None else monitor
    start = _box([round(float(number)) for number in box])
    if start is None or len(start) != 4:
        raise ValueError("box: want the numbers x, y, w, h of the target in the first frame")
    is_started = False
    for picture in _pictures(frames):
        frame = Frame(picture, "bgr")
        if is_started:
            found, numbers = tracker.update(picture)
            tracked = _box(numbers) if found else None
            yield tracked, judging.update(frame, tracked, _tracking_score(tracker))
        else:
            tracker.init(picture, tuple(int(number) for number in start))
            is_started = True
            yield start, judging.update(frame, start)


def _pictures(frames: Any) -> Iterator[npt.NDArray[np.uint8]]:
    if isinstance(frames, (str, os.PathLike)):
        path = os.fspath(frames)
        frames = importlib.import_module("cv2").VideoCapture(path)
        if not frames.isOpened():
            raise ValueError(f"{path}: OpenCV cannot open this video")
    if not hasattr(frames, "read"):
        yield from frames
        return
    while True:
        is_there, frame = frames.read()
        if not is_there:
            return
        yield frame


def _tracking_score(tracker: Any) -> float | None:
    """The tracker's confidence; OpenCV says -1 for trackers that have none."""
    score = float(tracker.getTrackingScore()) if hasattr(tracker, "getTrackingScore") else -1.0
    return score if score >= 0 else None


def watch_results(
    results: Iterable[Any], *, method: str | None = None, budget: float | None = None, patience: int = 30
) -> Iterator[dict[int, Judgement]]:
    """Judges the targets of `model.track(video, stream=True)` of Ultralytics: for each frame the judgements by id.

    Each id has a monitor of its own; all look at one `Frame`. An id that is missing in a frame is `absent` in it.

    Args:
        results: The `Results` of each frame, of boxes or of turned boxes.
        method: As of `trackfail.Monitor`.
        budget: As of `trackfail.Monitor`.
        patience: Frames after which an id that is missing is followed no more; one that comes back then begins anew.
    """
    monitors: dict[int, tuple[Monitor, int]] = {}
    for t, result in enumerate(results):
        boxes = _boxes_of(result)
        for name in boxes:
            if name not in monitors:
                monitors[name] = (Monitor(method=method, budget=budget), t)
        frame = Frame(result.orig_img, "bgr") if monitors else None
        judged = {}
        for name, (monitor, last) in list(monitors.items()):
            numbers, confidence = boxes.get(name, (None, None))
            if numbers is not None:
                monitors[name] = (monitor, t)
            elif t - last > patience:
                del monitors[name]
                continue
            judged[name] = monitor.update(frame, numbers, confidence)
        yield judged


def _boxes_of(result: Any) -> dict[int, tuple[Numbers, float]]:
    """Box and confidence of each id of a frame of Ultralytics."""
    found = result.boxes if result.boxes is not None else result.obb
    if found is None or found.id is None:
        return {}
    found = found.cpu().numpy()
    if result.boxes is not None:
        places = np.concatenate((found.xyxy[:, :2], found.xyxy[:, 2:4] - found.xyxy[:, :2]), axis=1)
    else:
        places = found.xyxyxyxy.reshape(len(found.id), 8)
    rows = zip(found.id.tolist(), places.tolist(), found.conf.tolist(), strict=True)
    boxes = ((int(name), _box(place), float(confidence)) for name, place, confidence in rows)
    return {name: (place, confidence) for name, place, confidence in boxes if place is not None}


def by_id(table: Any, frames: int | None = None) -> dict[int, list[Numbers | None]]:
    """The boxes of each target of a table as MOTChallenge has it: a box, or None, for each frame of the video.

    `trackfail.judge(video, by_id("mot.txt"))` judges all of them in one pass. Boxes stay as they are: those of MOTChallenge's
    own files count pixels from 1 (`base=1`), those that norfair and boxmot make of a detector's boxes from 0.

    Args:
        table: A file, an array or rows of `frame, id, left, top, width, height`; further columns are not read. Frames count
            from 1, or from 0 in a table that has a frame 0.
        frames: Number of frames of the video, otherwise up to the last one of the table.

    Raises:
        ValueError: For rows that are none, frames and ids that are not whole, a target that is twice in a frame, and frames
            beyond the video.
    """
    placed = []
    for where, row in _rows_of(table):
        if len(row) < 6:
            raise ValueError(f"{where} has less than six numbers: frame, id, left, top, width, height")
        if not (row[0].is_integer() and row[1].is_integer()):
            raise ValueError(f"{where}: frame and id have to be whole numbers, not {row[0]:g} and {row[1]:g}")
        placed.append((int(row[0]), int(row[1]), _box(row[2:6])))
    first = min([1, *(number for number, _, _ in placed)])
    last = max((number for number, _, _ in placed), default=0) + 1 - first
    count = last if frames is None else frames
    if first < 0 or last > count:
        raise ValueError(f"the table has frames {first} to {last - 1 + first}, the video {count} frames")
    tracks: dict[int, list[Numbers | None]] = {}
    seen: set[tuple[int, int]] = set()
    for number, name, place in placed:
        if (number, name) in seen:
            raise ValueError(f"frame {number} has two boxes of target {name}")
        seen.add((number, name))
        tracks.setdefault(name, [None] * count)[number - first] = place
    return dict(sorted(tracks.items()))


def _rows_of(table: Any) -> Iterator[tuple[str, list[float]]]:
    """Rows of a table, with the words that name them."""
    if isinstance(table, (str, os.PathLike)):
        yield from ((f"{table}, line {number}", row) for number, row in _read(Path(table)) if row)
    elif rows := _rows(table):
        # NumPy reads a table of one row as the row alone.
        for number, row in enumerate(np.atleast_2d(rows).tolist()):
            yield f"row {number} (from 0) of the table", [float(cell) for cell in row]


@dataclass(frozen=True)
class Track:
    """What a tracker gave on a sequence."""

    boxes: list[Numbers | None]
    """A box, or the corners of a polygon, of each frame; None where there is none. Pixels count as in the dataset."""
    confidence: list[float | None] | None
    """The tracker's confidence in each frame, if its file is there."""


def read_pytracking(folder: str | os.PathLike[str]) -> dict[str, Track]:
    """The tracks in a folder of pytracking, `tracking_results/dimp/dimp50` or one of its runs, by the names of the sequences.

    Raises:
        ValueError: For a folder without result files, and files with faults.
    """
    root = Path(folder)
    others = ("_time.txt", "_object_presence_scores.txt")
    files = {file.stem: file for file in root.glob("*.txt") if not file.name.endswith(others)}
    return _tracks(root, files, "_object_presence_scores.txt", "SEQUENCE.txt")


def read_pysot(folder: str | os.PathLike[str]) -> dict[str, Track]:
    """The tracks in a folder of pysot, `results/OTB100/model`, by the names of the sequences.

    Those of GOT-10k and of VOT's long-term challenge have a folder for each sequence. Of VOT's supervised runs, lines with one
    number (1 where the tracker starts, 2 where it fails, 0 in between) are frames without a box.

    Raises:
        ValueError: For a folder without result files, and files with faults.
    """
    root = Path(folder)
    root = next((root / name for name in ("baseline", "longterm") if (root / name).is_dir()), root)
    files = {file.stem: file for file in root.glob("*.txt") if not file.name.endswith("_time.txt")}
    files |= {file.parent.name: file for file in root.glob("*/*_001.txt")}
    return _tracks(root, files, "_confidence.value", "SEQUENCE.txt or SEQUENCE/SEQUENCE_001.txt")


def _tracks(root: Path, files: dict[str, Path], end: str, want: str) -> dict[str, Track]:
    if not files:
        raise ValueError(f"{root} has no result files: want {want}")
    tracks = {}
    for name, file in sorted(files.items()):
        boxes = [_place(file, number, row) for number, row in _read(file)]
        beside = file.with_name(file.stem + end)
        confidence = None
        if beside.is_file():
            confidence = [row[0] if row and not math.isnan(row[0]) else None for _, row in _read(beside)]
            if len(confidence) != len(boxes):
                raise ValueError(f"{beside} has {len(confidence)} lines, {file.name} {len(boxes)}")
        tracks[name] = Track(boxes, confidence)
    return tracks


def _place(file: Path, number: int, row: list[float]) -> Numbers | None:
    if len(row) in {0, 1}:
        return None
    if len(row) < 4 or len(row) % 2:
        raise ValueError(f"{file}, line {number}: {len(row)} numbers are no box")
    return _box(row)


def _read(file: Path) -> list[tuple[int, list[float]]]:
    """Number and numbers of each line."""
    rows = []
    for number, line in enumerate(file.read_text(encoding="utf-8-sig").splitlines(), start=1):
        words = [word for word in re.split(r"[,;\s]+", line) if word]
        try:
            rows.append((number, [float(word) for word in words]))
        except ValueError:
            raise ValueError(f"{file}, line {number}: want numbers, not {line[:80]!r}") from None
    return rows


def _box(numbers: Any) -> Numbers | None:
    """The numbers of a box; None for one without area, or with NaN."""
    given = tuple(float(number) for number in numbers)
    if any(math.isnan(number) for number in given):
        return None
    if len(given) == 4:
        return given if given[2] > 0 and given[3] > 0 else None
    corners = list(zip(given[::2], given[1::2], strict=True))
    area = sum(x * v - u * y for (x, y), (u, v) in zip(corners, corners[1:] + corners[:1], strict=True)) / 2
    # As a region is refused.
    return given if abs(area) >= 1e-9 else None
