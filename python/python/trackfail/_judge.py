"""Judgements of whole tracks."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar, overload

import numpy as np
import numpy.typing as npt

from . import _trackfail
from ._frames import Following, Frames, source
from ._types import Box, Boxes, Colors, Floats

if TYPE_CHECKING:
    import pandas
    import polars
    from matplotlib.axes import Axes

Name = TypeVar("Name", str, int)


@dataclass(frozen=True, eq=False)
class Judged:
    """Judgement of a track by a method; every column has a value per frame."""

    method: str
    """Name of the method."""
    threshold: float | None
    """Level that `alarm_score` or, without it, `score` is compared with, of methods that have one."""
    high_is_good: bool
    """True if high scores speak for a good track."""
    is_probability: bool
    """True if the score is the probability that the target is lost."""
    score: Floats
    """Score; NaN before the first box and after the last one."""
    alarm_score: Floats | None
    """The number that is compared with the threshold, of methods that compare another one than the score; else None."""
    label: npt.NDArray[np.bool_]
    """True in frames with an alarm."""
    change: npt.NDArray[np.int32]
    """1 where alarms begin, -1 where they end, else 0."""
    state: npt.NDArray[np.str_]
    """`lost`, from an alarm until the recovery is confirmed; `absent`, where there is no box; else `tracking`."""

    def __len__(self) -> int:
        return len(self.score)

    @property
    def losses(self) -> list[tuple[int, int]]:
        """The runs of frames in which the target is lost: the first, and the one after the last, from 0."""
        edges = np.diff(np.concatenate(([0], (self.state == "lost").astype(np.int8), [0])))
        starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        return list(zip(starts.tolist(), ends.tolist(), strict=True))

    @property
    def verdict(self) -> str:
        """The answer in a sentence."""
        losses = [f"{start} to {end - 1}" for start, end in self.losses]
        if not losses:
            return "No loss is found."
        if self.losses[-1][1] == len(self):
            losses[-1] = f"{self.losses[-1][0]} to the end"
        return f"Lost from frame {', '.join(losses)} (from 0)."

    def columns(self) -> dict[str, Any]:
        """The columns that `trackfail detect` writes; frames from 0."""
        return {
            "frame": np.arange(len(self)),
            "method": [self.method] * len(self),
            "score": self.score,
            "label": self.label.astype(np.int32),
            "change": self.change,
            "state": self.state.tolist(),
        }

    def to_pandas(self) -> pandas.DataFrame:
        """The columns as a data frame of pandas."""
        import pandas

        return pandas.DataFrame(self.columns())

    def to_polars(self) -> polars.DataFrame:
        """The columns as a data frame of polars; a score that is missing is null."""
        import polars

        return polars.DataFrame(self.columns()).with_columns(polars.col("score").fill_nan(None))

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the scores, the losses and, in gray, the threshold with what is compared with it; needs matplotlib."""
        if ax is None:
            from matplotlib import pyplot

            ax = pyplot.figure(figsize=(9, 2.5), layout="constrained").add_subplot()
        ax.plot(self.score, linewidth=1)
        if self.alarm_score is not None:
            ax.plot(self.alarm_score, linewidth=1, color="gray", alpha=0.6)
        if self.threshold is not None:
            ax.axhline(self.threshold, linestyle="--", linewidth=1, color="gray")
        for start, end in self.losses:
            ax.axvspan(start - 0.5, end - 0.5, alpha=0.25, color="tab:red", linewidth=0)
        ax.set(xlabel="frame", ylabel="probability of a loss" if self.is_probability else "score", title=self.method)
        ax.margins(x=0)
        return ax

    def report(self, path: str | os.PathLike[str]) -> None:
        """Writes a page with the verdict, a chart and the losses, which needs nothing beside it.

        `trackfail detect --report` writes one that also has a viewer of the frames.
        """
        from ._report import write

        write(path, self)


@overload
def judge(
    frames: Frames | None,
    boxes: Mapping[Name, Boxes],
    *,
    method: str | None = None,
    budget: float | None = None,
    colors: Colors | None = None,
    base: int = 0,
) -> dict[Name, Judged]: ...
@overload
def judge(
    frames: Frames | None,
    boxes: Boxes | Iterable[Box | None],
    *,
    confidence: Sequence[float | None] | Floats | None = None,
    companions: Sequence[Boxes] = (),
    method: str | None = None,
    budget: float | None = None,
    colors: Colors | None = None,
    base: int = 0,
) -> Judged: ...
def judge(
    frames: Frames | None,
    boxes: Mapping[Any, Boxes] | Boxes | Iterable[Box | None],
    *,
    confidence: Sequence[float | None] | Floats | None = None,
    companions: Sequence[Boxes] = (),
    method: str | None = None,
    budget: float | None = None,
    colors: Colors | None = None,
    base: int = 0,
) -> Judged | dict[Any, Judged]:
    """Judges a whole track, or all tracks of a video in one pass over its frames; the numbers are those of `trackfail detect`.

    Args:
        frames: The frames: an array of the shape (frames, height, width, 3) or (frames, height, width), a list or an iterator
            of arrays, frames or paths, a folder of images numbered without a gap, or a video, which ffmpeg decodes. None
            for methods that look at boxes alone.
        boxes: A box for each frame, as rows of an array or a data frame or as a list, or a mapping from the name of each
            target to its boxes; without targets nothing looks at the frames. Formats that count pixels from 1, such as OTB's,
            need `base=1`.
        confidence: The tracker's own confidence in each frame; None or NaN where there is none.
        companions: The boxes of other trackers on the same target, for each a box for each frame.
        method: Name of the method; otherwise the one that is recommended for what is given.
        budget: Largest number of false alarms per 1000 frames, for methods that take one.
        colors: Order of the colors in arrays of frames.
        base: Number of the top left pixel in boxes, 0 or 1.

    Raises:
        ValueError: For what cannot be used, such as more frames than boxes; of an iterator one more is taken to find that.
            Errors that an iterator of frames raises are raised as they are.
        TypeError: For an argument of another type; a single box of another type is a ValueError.
        OSError: For a file that cannot be read.
    """
    tracks: Mapping[Any, Any] = boxes if isinstance(boxes, Mapping) else {None: boxes}
    named = {name: _rows(track) for name, track in tracks.items()}
    if isinstance(boxes, Mapping) and (confidence is not None or len(companions) > 0):
        raise ValueError("confidence and companions need the boxes of one target")
    counts = {len(track) for track in named.values()}
    if len(counts) > 1:
        raise ValueError("the tracks have different numbers of frames: " + ", ".join(map(str, sorted(counts))))
    if frames is not None and not named:
        # Nothing is judged, however many there are.
        frames = []
    frame_of = None if frames is None else source(frames, counts.pop() if counts else 0)
    told = _trackfail.judge(
        list(named.values()),
        frame_of,
        colors,
        None if confidence is None else list(confidence),
        [_rows(track) for track in companions],
        method,
        budget,
        base,
    )
    if isinstance(frame_of, Following):
        frame_of.finish()
    judged: dict[Any, Judged] = {}
    for name, (used, threshold, high_is_good, is_probability, score, raising, label, change, states) in zip(
        named, told, strict=True
    ):
        state = np.array(states, dtype=np.str_)
        judged[name] = Judged(used, threshold, high_is_good, is_probability, score, raising, label, change, state)
    return judged if isinstance(boxes, Mapping) else judged[None]


def _rows(boxes: Boxes | Iterable[Box | None]) -> list[Any]:
    rows = _array(boxes)
    return rows.tolist() if isinstance(rows, np.ndarray) else list(rows)


def _array(given: Any) -> Any:
    """The array of a data frame or a series, whose own iteration and indices are about other things than rows."""
    return given.to_numpy() if hasattr(given, "to_numpy") else given


def methods() -> list[str]:
    """Names of the methods."""
    return _trackfail.methods()


def recommended(
    *, frames: bool = False, companions: bool = False, confidence: bool = False, budget: float | None = None
) -> str:
    """Name of the method that the benchmark recommends for these inputs beside boxes."""
    return _trackfail.recommended(frames, companions, confidence, budget)
