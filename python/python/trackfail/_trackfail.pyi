"""The extension module: conversions alone; the modules around it say what everything means."""

import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

__version__: str

class Frame:
    """A decoded frame, which several monitors of a video can share: what signals compute of it is computed once.

    `array` is of `uint8` and has the shape (height, width, 3) or (height, width).
    """

    def __new__(
        cls, array: npt.NDArray[np.uint8] | Frame | str | os.PathLike[str], colors: Literal["bgr", "rgb"] | None = None
    ) -> Frame: ...
    @staticmethod
    def decode(data: bytes) -> Frame:
        """The frame of the bytes of a JPEG or PNG file."""
    @property
    def width(self) -> int:
        """Width in pixels."""
    @property
    def height(self) -> int:
        """Height in pixels."""
    def to_numpy(self, colors: Literal["bgr", "rgb"] = "rgb") -> npt.NDArray[np.uint8]:
        """An array of the shape (height, width, 3)."""

class Monitor:
    def __new__(
        cls,
        inputs: Sequence[str] | None,
        method: str | None,
        budget: float | None,
        base: int,
        colors: str | None,
    ) -> Monitor: ...
    @staticmethod
    def load(state: bytes, colors: str | None) -> Monitor: ...
    def save(self) -> bytes: ...
    def update(
        self,
        frame: object,
        numbers: object,
        confidence: float | None,
        companions: Iterable[object] | None,
        restart: bool,
    ) -> tuple[int, float | None, Literal["tracking", "lost", "absent"], list[str], str | None]: ...
    def close(self) -> None: ...
    @property
    def closed(self) -> bool: ...
    @property
    def index(self) -> int: ...
    @property
    def method(self) -> str | None: ...

def judge(
    tracks: Sequence[Any],
    frame_of: Callable[[int], object] | None,
    colors: str | None,
    confidence: Sequence[float | None] | None,
    companions: Sequence[Any],
    method: str | None,
    budget: float | None,
    base: int,
) -> list[
    tuple[
        str,
        float | None,
        bool,
        bool,
        npt.NDArray[np.float64],
        npt.NDArray[np.float64] | None,
        npt.NDArray[np.bool_],
        npt.NDArray[np.int32],
        list[str],
    ]
]: ...
def methods() -> list[str]: ...
def recommended(frames: bool, companions: bool, confidence: bool, budget: float | None) -> str: ...
def protocols() -> list[str]: ...
def errors(boxes: Iterable[object], truth: Iterable[object], base: int) -> npt.NDArray[np.float64]: ...
def score(
    labels: Sequence[bool],
    error: Sequence[float],
    changes: Sequence[int] | None,
    pieces: Sequence[tuple[int, int]],
    protocol: str,
) -> tuple[tuple[int, int, int, int], list[int], list[int], list[tuple[int, int]], list[tuple[str, float | None]]]: ...
def frame_measures(
    error: Sequence[Sequence[float]],
    scores: Sequence[Sequence[float]],
    compared: Sequence[Sequence[float]] | None,
    labels: Sequence[Sequence[bool]] | None,
    sequence: Sequence[int],
    high_is_good: bool,
    is_probability: bool,
    seed: int | None,
) -> list[tuple[str, float | None]]: ...
def found_at(
    error: Sequence[Sequence[float]], scores: Sequence[Sequence[float]], budget: float, high_is_good: bool
) -> float | None: ...
