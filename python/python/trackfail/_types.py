"""Types of arguments."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from ._trackfail import Frame

Colors: TypeAlias = Literal["bgr", "rgb"]
State: TypeAlias = Literal["tracking", "lost", "absent"]
Good: TypeAlias = Literal["high", "low"]


class Table(Protocol):
    """A data frame or a series of pandas or polars."""

    def to_numpy(self) -> Any:
        """The rows as an array."""


def checked(good: Good) -> Good:
    """The word itself; another one would turn measures round.

    Raises:
        ValueError: For another word.
    """
    if good not in ("high", "low"):
        raise ValueError(f'good: want "high" or "low", the scores that are good, not {good!r}')
    return good


Floats: TypeAlias = npt.NDArray[np.float64]
Picture: TypeAlias = npt.NDArray[np.uint8] | Frame | str | os.PathLike[str]
Box: TypeAlias = Sequence[float] | npt.NDArray[Any]
Boxes: TypeAlias = Sequence[Box | None] | npt.NDArray[Any] | Table
