"""Results of experiments as data frames."""

from __future__ import annotations

import json
import os
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar, overload

if TYPE_CHECKING:
    import pandas
    import polars

DataFrame = TypeVar("DataFrame")
Library = Literal["polars", "pandas"]

_LIBRARIES: tuple[Library, ...] = ("polars", "pandas")
_TABLES = ("scores", "measures", "frame_measures", "frames", "truth", "signals")


class Results(Generic[DataFrame]):
    """The results of an experiment: a folder `results/NAME`, read where it is asked for.

    The columns are those that `docs/columns.md` explains.
    """

    def __init__(self, path: str | os.PathLike[str], library: Library) -> None:
        if library not in _LIBRARIES:
            raise ValueError(f"library: want {' or '.join(_LIBRARIES)}, not {library!r}")
        self.path = Path(path)
        self.library = library
        if not (self.path / "manifest.json").is_file():
            raise FileNotFoundError(f"{self.path} has no results: there is no manifest.json in it")

    @property
    def manifest(self) -> dict[str, Any]:
        """Inputs of the results: experiment, protocol, suite, trackers, methods."""
        read: dict[str, Any] = json.loads((self.path / "manifest.json").read_text(encoding="utf-8"))
        return read

    @property
    def tables(self) -> list[str]:
        """Names of the tables that there are."""
        return [name for name in _TABLES if self._file(name) is not None]

    @property
    def scores(self) -> DataFrame:
        """Counts of each cell: a method on one run of a tracker over a sequence; sequence `*` is all of them."""
        return self._read("scores")

    @property
    def measures(self) -> DataFrame:
        """Ratios of the counts of each tracker and method, pooled over the suite."""
        return self._read("measures")

    @property
    def frame_measures(self) -> DataFrame:
        """Measures frame by frame of each tracker and method: AUROC, losses found, ..."""
        return self._read("frame_measures")

    @property
    def frames(self) -> DataFrame:
        """Boxes, errors, scores and labels of every frame."""
        return self._read("frames")

    @property
    def truth(self) -> DataFrame:
        """Ground truth of every frame."""
        return self._read("truth")

    @property
    def signals(self) -> DataFrame:
        """Signals and forecasts of every frame."""
        return self._read("signals")

    def _file(self, name: str) -> Path | None:
        """The file of a table, if it is there; compact results have some tables as Parquet that others have as CSV."""
        files = (self.path / f"{name}.{ending}" for ending in ("csv", "parquet"))
        return next((file for file in files if file.is_file()), None)

    def _read(self, name: str) -> DataFrame:
        path = self._file(name)
        if path is None:
            there = ", ".join(self.tables)
            raise FileNotFoundError(f"{self.path / name}: this experiment has no such table; it has {there}")
        read: DataFrame = _reader(self.library, path.suffix)(path)
        return read

    def __repr__(self) -> str:
        return f"<trackfail.Results of {self.path}: {', '.join(self.tables)}>"


def _reader(library: Library, suffix: str) -> Any:
    """The function of a library that reads files of this kind."""
    if library == "polars":
        import polars

        # The kind of a column may show in its last row.
        return polars.read_parquet if suffix == ".parquet" else partial(polars.read_csv, infer_schema_length=None)
    import pandas

    return pandas.read_parquet if suffix == ".parquet" else pandas.read_csv


@overload
def load(path: str | os.PathLike[str], library: Literal["polars"]) -> Results[polars.DataFrame]: ...
@overload
def load(path: str | os.PathLike[str], library: Literal["pandas"]) -> Results[pandas.DataFrame]: ...
@overload
def load(path: str | os.PathLike[str]) -> Results[Any]: ...
def load(path: str | os.PathLike[str], library: Library | None = None) -> Results[Any]:
    """The results in a folder, as data frames of polars where it is installed, else of pandas.

    Raises:
        ValueError: For another library.
        FileNotFoundError: For a folder without results.
        ImportError: Where neither library is installed.
    """
    there = [name for name in _LIBRARIES if find_spec(name) is not None]
    if library is None and not there:
        raise ImportError("tables need polars or pandas: pip install polars")
    return Results(path, there[0] if library is None else library)
