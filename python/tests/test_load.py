"""Results as data frames of either library."""

from __future__ import annotations

from pathlib import Path

import pytest

import trackfail
from conftest import CHECKOUT

FOLDER = CHECKOUT / "results" / "quickstart"


def test_both_libraries_read_the_same() -> None:
    polars, pandas = trackfail.load(FOLDER, "polars"), trackfail.load(FOLDER, "pandas")
    assert polars.tables == pandas.tables
    for name in ("scores", "measures", "frame_measures", "frames", "truth", "signals"):
        one, other = getattr(polars, name), getattr(pandas, name)
        assert one.shape == other.shape and one.columns == list(other.columns) and len(one) > 0
    assert polars.manifest["experiment"] == "quickstart"
    assert trackfail.load(FOLDER).library == "polars"


def test_compact_results_have_tables_too() -> None:
    compact = trackfail.load(CHECKOUT / "results" / "khalid2016" / "table1", "polars")
    assert compact.tables == ["scores", "measures", "frame_measures"]
    assert set(compact.measures["method"]) == set(compact.scores["method"])
    assert len(compact.frame_measures) > 0


def test_what_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"no manifest\.json"):
        trackfail.load(tmp_path)
    (tmp_path / "manifest.json").write_text("{}")
    with pytest.raises(ValueError, match="library: want polars or pandas, not 'numpy'"):
        trackfail.load(tmp_path, "numpy")  # type: ignore[call-overload]
    with pytest.raises(FileNotFoundError, match="no such table"):
        _ = trackfail.load(tmp_path, "pandas").frames
