"""Live monitoring, frame by frame."""

from __future__ import annotations

import os
import shutil
import uuid
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from . import _trackfail
from ._types import Box, Colors, Picture, State


@dataclass(frozen=True, slots=True)
class Judgement:
    """Judgement of a frame."""

    probability: float | None
    """Probability that the target is lost; None before the first box, and from methods that estimate none."""
    state: State
    """`tracking`; `lost`, from an alarm until the recovery is confirmed; `absent`, where the tracker has no box."""
    reasons: tuple[str, ...]
    """At most three features that speak for a loss, the loudest first."""
    note: str | None = None
    """Reason why an input was left out, or that there is none to judge by; else None."""
    index: int = 0
    """Number of the frame, from 0."""


class Monitor:
    """Tells whether a tracker has lost its target, frame by frame, while it tracks.

    One monitor follows one target. Objects in the same video have a monitor each; give all of them the same
    `trackfail.Frame`, so that it is converted once. Monitors may run in several threads, one thread for each; none holds the
    interpreter while it judges. The answers are those of `trackfail monitor`.

    Args:
        inputs: Inputs that will come beside boxes: `frames`, `confidence` and `companions`, as words or in one text with
            commas. They decide which method is recommended; otherwise the first frame with a box does.
        method: Name of the method, see `trackfail.methods`.
        budget: Largest number of false alarms per 1000 frames, for methods that take one.
        colors: Order of the colors in arrays of frames.
        base: Number of the top left pixel in boxes, 0 or 1.

    Raises:
        ValueError: For a method that does not exist or cannot monitor, or a budget that it does not take.
    """

    __slots__ = ("_monitor",)

    def __init__(
        self,
        inputs: str | Iterable[str] | None = None,
        method: str | None = None,
        budget: float | None = None,
        *,
        colors: Colors | None = None,
        base: int = 0,
    ) -> None:
        words = inputs.split(",") if isinstance(inputs, str) else inputs
        named = None if words is None else [word.strip() for word in words]
        self._monitor = _trackfail.Monitor(named, method, budget, base, colors)

    def update(
        self,
        frame: Picture | None,
        box: Box | None,
        confidence: float | None = None,
        companions: Iterable[Box | None] | None = None,
    ) -> Judgement:
        """Judges the next frame.

        Args:
            frame: An array of `uint8` with the shape (height, width, 3) or (height, width), a `trackfail.Frame`, or the path
                of a JPEG or PNG file. An array is read where it is, and not kept; all frames have the same size. None where
                there is no frame.
            box: The tracker's box; None where it has none.
            confidence: The tracker's own confidence, in its scale; high values are sure. None or NaN where there is none.
            companions: Boxes of other trackers on the same frame, in the same order in all frames.

        Raises:
            ValueError: For an array of another type, shape or size, what is no box, also an object of another type, or an
                infinite confidence. The frame counts, and nothing else is changed by it.
            TypeError: For another argument of another type.
            OSError: For a file that cannot be read.
        """
        return _judgement(self._monitor.update(frame, box, confidence, companions, False))

    def restart(
        self,
        box: Box | None,
        frame: Picture | None = None,
        confidence: float | None = None,
        companions: Iterable[Box | None] | None = None,
    ) -> Judgement:
        """Judges a frame in which the tracker was started again on its target: nothing from before it counts.

        Args:
            box: Place of the target.
            frame: The frame. Without one, that of the last update or restart that was not refused is judged again, under a
                number of its own; where that had none, and after `load`, there is none, as in `update(None, box)`.
            confidence: As in `update`.
            companions: As in `update`.
        """
        return _judgement(self._monitor.update(frame, box, confidence, companions, True))

    def save(self, path: str | os.PathLike[str] | None = None) -> bytes:
        """Returns the state as bytes and, with a path, writes it as a file that `trackfail monitor --state` reads.

        It is written beside the file that it replaces, and is on the disk before it takes its place: a reader, also one after
        a crash, sees the old state or the new one. A link stays, and its target is replaced.
        """
        state = self._monitor.save()
        if path is not None:
            _replace(os.path.realpath(path), state)
        return state

    @classmethod
    def load(cls, state: bytes | bytearray | memoryview | str | os.PathLike[str], *, colors: Colors | None = None) -> Monitor:
        """Returns the monitor of a saved state, bytes or a file: it goes on with the same answers.

        Raises:
            ValueError: For a state that is damaged, or of another version of the program or the method.
            OSError: For a file that cannot be read.
        """
        monitor = cls.__new__(cls)
        saved = bytes(state) if isinstance(state, (bytes, bytearray, memoryview)) else Path(state).read_bytes()
        monitor._monitor = _trackfail.Monitor.load(saved, colors)
        return monitor

    def close(self) -> None:
        """Frees the memory of the monitor, which judges no more."""
        self._monitor.close()

    @property
    def closed(self) -> bool:
        """True if the monitor judges no more."""
        return self._monitor.closed

    @property
    def index(self) -> int:
        """Number of the frame that comes next, from 0."""
        return self._monitor.index

    @property
    def method(self) -> str | None:
        """Name of the method, once it is chosen."""
        return self._monitor.method

    def __enter__(self) -> Monitor:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        try:
            self.close()
        except RuntimeError:
            # Another thread is judging; an error of the body says more.
            if error is None:
                raise

    def __repr__(self) -> str:
        try:
            return f"<trackfail.Monitor, method {self.method}, next frame {self.index}>"
        except RuntimeError:
            return "<trackfail.Monitor, judging in another thread>"
        except (AttributeError, ValueError):
            # Closed, or never made.
            return "<trackfail.Monitor, closed>"


def _replace(path: str, data: bytes) -> None:
    """Writes a file whole, with the permissions of the one that was there."""
    part = os.path.join(os.path.dirname(path), f".trackfail-{uuid.uuid4().hex}")
    try:
        with open(part, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        with suppress(FileNotFoundError):
            shutil.copymode(path, part)
        os.replace(part, path)
    except BaseException:
        Path(part).unlink(missing_ok=True)
        raise


def _judgement(told: tuple[int, float | None, State, list[str], str | None]) -> Judgement:
    index, probability, state, reasons, note = told
    return Judgement(probability, state, tuple(reasons), note, index)
