"""Labels and scores against ground truth, by the protocols and measures of the benchmark."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _trackfail
from ._judge import _rows
from ._types import Box, Boxes, Floats, Good, Table, checked

Numbers: TypeAlias = Sequence[float] | npt.NDArray[Any]
Tracks: TypeAlias = Numbers | Table | Sequence[Numbers | Table]


@dataclass(frozen=True, eq=False)
class Score:
    """Counts of a protocol on a track, and the metrics of these counts."""

    protocol: str
    """Name and version of the protocol."""
    tp: int
    """True positives."""
    fp: int
    """False positives."""
    fn: int
    """False negatives."""
    tn: int
    """True negatives."""
    events: npt.NDArray[np.int64]
    """Frames, from 0, of the events that the protocol looks for."""
    detections: npt.NDArray[np.int64]
    """Frames, from 0, in which the detector reports an event."""
    matches: npt.NDArray[np.int64]
    """Matched pairs, as indices into `events` and `detections`: an array of two columns."""
    measures: Mapping[str, float | None]
    """The metrics of counts by their names: `precision`, `recall`, `f_score`, ...; None where a denominator is 0."""

    def __getitem__(self, measure: str) -> float | None:
        return self.measures[measure]


def errors(boxes: Boxes | Iterable[Box | None], truth: Boxes | Iterable[Box | None], *, base: int = 0) -> Floats:
    """The tracking error of each frame: 1 - Dice overlap, 1 where a box is missing, NaN where the truth is."""
    return _trackfail.errors(_rows(boxes), _rows(truth), base)


def score(
    labels: Numbers | Sequence[bool],
    boxes: Boxes | Iterable[Box | None] | None = None,
    truth: Boxes | Iterable[Box | None] | None = None,
    protocol: str = "khalid2016/1",
    *,
    error: Numbers | None = None,
    changes: Sequence[int] | npt.NDArray[np.int32] | None = None,
    pieces: Sequence[tuple[int, int]] = (),
) -> Score:
    """The score of a detector's labels on one track; counts of several tracks are added up.

    Args:
        labels: True in frames that the detector calls a failure.
        boxes: The tracker's boxes.
        truth: The boxes of the ground truth; None where there is none.
        protocol: Name and version, see `trackfail.protocols`.
        error: Tracking errors, instead of boxes and truth; NaN where there is no truth. The tracker starts in the first
            frame with an error.
        changes: Changes that the detector finds (1, -1, 0), where these are not those between labels.
        pieces: Parts of a track between restarts of the tracker, each as its first frame and the one after its last. Protocols
            by which a restart begins a new track, such as `khalid2016/2`, score them one by one, without the frames of
            restarts and those between pieces; others take no notice.

    Raises:
        ValueError: For an unknown protocol, lists of different lengths, and pieces that are not in order on the track.
    """
    if error is None:
        if boxes is None or truth is None:
            raise ValueError("give boxes and truth, or error")
        error = errors(boxes, truth)
    called = np.asarray(labels).astype(bool).tolist()
    listed = None if changes is None else np.asarray(changes, dtype=np.int32).tolist()
    wrong = np.asarray(error, dtype=np.float64).tolist()
    _same(len(wrong), labels=called, **({} if listed is None else {"changes": listed}))
    parts = [(int(start), int(end)) for start, end in pieces]
    edges = [edge for part in parts for edge in part]
    if edges != sorted(edges) or any(start == end for start, end in parts) or not all(0 <= e <= len(wrong) for e in edges):
        raise ValueError(f"pieces: want ranges of the {len(wrong)} frames in their order, not {parts}")
    counts, events, detections, matches, measures = _trackfail.score(called, wrong, listed, parts, protocol)
    return Score(
        protocol,
        *counts,
        events=np.array(events, dtype=np.int64),
        detections=np.array(detections, dtype=np.int64),
        matches=np.array(matches, dtype=np.int64).reshape(-1, 2),
        measures=dict(measures),
    )


def frame_measures(
    scores: Tracks,
    error: Tracks,
    labels: Tracks | None = None,
    *,
    good: Good = "low",
    probability: bool = False,
    alarm_scores: Tracks | None = None,
    sequence: Sequence[int] | None = None,
    seed: int | None = None,
) -> dict[str, float | None]:
    """All measures of a detector frame by frame, pooled over tracks: the columns of `frame_measures.csv`.

    Args:
        scores: Scores of one track; of several a list of them, the rows of an array or the columns of a data frame; finite.
        error: Tracking errors of the same frames, see `trackfail.errors`.
        labels: The detector's own alarms, for the measures of these.
        good: Scores that are good, high or low ones.
        probability: True if scores are probabilities, which have a calibration: that the target is lost or, where high
            is good, that it is not.
        alarm_scores: Numbers that the detector compares with its threshold, where these are not the scores (`alarm_score` of
            results and of `Judged`); the measures of alarms at a threshold are those of these.
        sequence: For each track the index of its sequence; those of one are drawn together in bootstrap samples.
        seed: Seed of the bootstrap samples; without one there are no intervals.

    Raises:
        ValueError: For lists of different lengths, scores that are not finite, and another word as `good`.
    """
    is_high = checked(good) == "high"
    numbers, wrong = _tracks(scores, error)
    compared = None if alarm_scores is None else _tracks(alarm_scores, error)[0]
    alarms = None
    if labels is not None:
        alarms = [track.astype(bool).tolist() for track in _listed(labels)]
        _same(len(wrong), labels=alarms)
        for k, (alarm, track) in enumerate(zip(alarms, wrong, strict=True)):
            _same(len(track), **{f"labels of track {k}": alarm})
    names = list(range(len(wrong))) if sequence is None else list(sequence)
    _same(len(wrong), sequence=names)
    indices = {name: index for index, name in enumerate(dict.fromkeys(names))}
    known = [indices[name] for name in names]
    return dict(_trackfail.frame_measures(wrong, numbers, compared, alarms, known, is_high, probability, seed))


def auroc(scores: Tracks, error: Tracks, *, good: Good = "low") -> float | None:
    """Area under the ROC curve of scores that tell lost frames (no overlap) from the others; None without both."""
    return frame_measures(scores, error, good=good)["auroc"]


def average_precision(scores: Tracks, error: Tracks, *, good: Good = "low") -> float | None:
    """Average precision of scores that tell lost frames (no overlap) from the others; None without a lost one."""
    return frame_measures(scores, error, good=good)["auprc"]


def found_at(budget: float, scores: Tracks, error: Tracks, *, good: Good = "low") -> float | None:
    """Share of the losses found within 15 frames, where at most `budget` of 1000 good frames alarm; None without a loss.

    Of a method with an `alarm_score`, give these numbers as `scores`.
    """
    is_high = checked(good) == "high"
    numbers, wrong = _tracks(scores, error)
    return _trackfail.found_at(wrong, numbers, float(budget), is_high)


def protocols() -> list[str]:
    """Names of the protocols."""
    return _trackfail.protocols()


def _listed(tracks: Tracks) -> list[npt.NDArray[Any]]:
    """One array for each track: for each column of a data frame, also of one in a list, and each row of another table."""
    given: Any = tracks
    if hasattr(given, "to_numpy"):
        return list(np.atleast_2d(given.to_numpy().T))
    if len(given) > 0 and np.ndim(given[0]) == 0:
        return [np.asarray(given)]
    return [one for track in given for one in (_listed(track) if hasattr(track, "to_numpy") else [np.asarray(track)])]


def _tracks(scores: Tracks, error: Tracks) -> tuple[list[list[float]], list[list[float]]]:
    """Scores and errors of each track, checked."""
    numbers = [track.astype(np.float64) for track in _listed(scores)]
    wrong = [track.astype(np.float64) for track in _listed(error)]
    _same(len(wrong), scores=numbers)
    for k, (track, of) in enumerate(zip(numbers, wrong, strict=True)):
        _same(len(of), **{f"scores of track {k}": track.tolist()})
        missing = np.flatnonzero(~np.isfinite(track))
        if missing.size:
            raise ValueError(f"track {k} has no score in frame {missing[0]} (from 0); leave out frames without one")
    return [track.tolist() for track in numbers], [track.tolist() for track in wrong]


def _same(count: int, **lists: Sequence[Any]) -> None:
    for name, values in lists.items():
        if len(values) != count:
            raise ValueError(f"{name} has the length {len(values)}, error {count}")
