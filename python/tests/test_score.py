"""Protocols and measures give the numbers of the results that the checkout holds."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest

import trackfail
from conftest import CHECKOUT
from trackfail import Results

N = float("nan")


@pytest.fixture(scope="module")
def results() -> Results[pl.DataFrame]:
    return trackfail.load(CHECKOUT / "results" / "quickstart", "polars")


def test_counts_are_those_of_the_results(results: Results[pl.DataFrame]) -> None:
    cells = {(row["sequence"], row["tracker"], row["run"], row["method"]): row for row in results.scores.iter_rows(named=True)}
    seen = 0
    for name, track in results.frames.group_by("sequence", "tracker", "run", "method"):
        want = cells[name]
        protocol = "sanmiguel2015/1" if name[1] == "PF" else "khalid2016/1"
        label, error, change = (track[column].to_list() for column in ("label", "error", "change"))
        score = trackfail.score(label, error=error, changes=change, protocol=protocol)
        assert (score.tp, score.fp, score.fn, score.tn) == (want["tp"], want["fp"], want["fn"], want["tn"]), name
        for ratio in ("precision", "recall", "f_score", "fpr"):
            assert score[ratio] == want[ratio], (name, ratio)
        seen += 1
    assert seen > 100


@pytest.mark.parametrize(("tracker", "method"), [("NCC", "DTEF"), ("NCC", "NAIVE"), ("KCF", "DTEF"), ("NCC", "oracle")])
def test_measures_are_those_of_the_results(tracker: str, method: str, results: Results[pl.DataFrame]) -> None:
    chosen = (pl.col("tracker") == tracker) & (pl.col("method") == method)
    want = results.frame_measures.filter(chosen).row(0, named=True)
    tracks = [track for _, track in results.frames.filter(chosen).group_by("sequence", maintain_order=True)]
    scores, error, labels = ([track[name].to_list() for track in tracks] for name in ("score", "error", "label"))
    got = trackfail.frame_measures(scores, error, labels)
    assert len(got) > 15
    assert {name: value for name, value in got.items() if name != "ece"} == {name: want[name] for name in got if name != "ece"}
    assert trackfail.auroc(scores, error) == want["auroc"]
    assert trackfail.average_precision(scores, error) == want["auprc"]
    assert trackfail.found_at(5, scores, error) == want["found_at_5"]
    turned = [[-score for score in track] for track in scores]
    assert trackfail.auroc(turned, error, good="high") == want["auroc"]
    assert trackfail.found_at(5, turned, error, good="high") == want["found_at_5"]
    assert trackfail.frame_measures(scores, error, seed=1)["auroc_low"] is not None


def test_errors_are_those_of_the_results(results: Results[pl.DataFrame]) -> None:
    chosen = (pl.col("tracker") == "NCC") & (pl.col("method") == "DTEF") & (pl.col("sequence") == "Tennis")
    track = results.frames.filter(chosen).sort("frame")
    truth = results.truth.filter(pl.col("sequence") == "Tennis").sort("frame")
    corners = truth.select("x1", "y1", "x2", "y2", "x3", "y3", "x4", "y4").to_numpy()
    got = trackfail.errors(track.select("x", "y", "w", "h").to_numpy(), corners)
    assert got.tolist() == pytest.approx(track["error"].to_list(), abs=1e-9)


def test_by_hand() -> None:
    box, half, away = (0, 0, 10, 10), (5, 0, 10, 10), (50, 0, 10, 10)
    error = trackfail.errors([box, half, None, away], [box, box, box, None])
    assert error[:3].tolist() == [0, 0.5, 1] and error[3] != error[3]
    score = trackfail.score([0] * 20 + [1] * 10, [box] * 20 + [away] * 10, [box] * 30)
    assert (score.tp, score.fp, score.fn, score["f_score"]) == (1, 0, 0, 1.0)
    assert (score.events.tolist(), score.detections.tolist(), score.matches.tolist()) == ([20], [20], [[0, 0]])
    assert trackfail.score([0, 0], error=[0.1, 0.1])["f_score"] is None
    # Of 2 x 3 pairs 4 are in order and 1 ties.
    assert trackfail.auroc([5, 4, 3, 3, 1], [1, 0, 0, 1, 0]) == 4.5 / 6
    assert trackfail.auroc([1, 2], [0, 0]) is None and trackfail.found_at(5, [1, 2], [0, 0]) is None


def test_restarts_begin_pieces() -> None:
    # The tracker fails in frame 16 and starts again in 21, where its box jumps.
    error = [0.0] * 16 + [1.0] + [N] * 4 + [0.0] * 19
    jump = [t == 21 for t in range(40)]
    pieces = [(0, 17), (21, 40)]
    one = trackfail.score(jump, error=error, pieces=pieces)
    anew = trackfail.score(jump, error=error, pieces=pieces, protocol="khalid2016/2")
    assert (one.tp, one.fn) == (1, 0)
    assert (anew.tp, anew.fp, anew.fn) == (0, 0, 1)
    for wrong in ([(0, 17), (16, 40)], [(0, 41)], [(3, 3)]):
        with pytest.raises(ValueError, match="ranges of the 40 frames in their order"):
            trackfail.score(jump, error=error, pieces=wrong)


def test_alarms_at_a_threshold_are_those_of_alarm_scores() -> None:
    error = [0.0] * 20 + [1.0] * 10
    scores, alarm_scores = [1.0] * 20 + [2.0] * 10, [float(t % 2) for t in range(30)]
    measures = trackfail.frame_measures(scores, error, alarm_scores=alarm_scores)
    assert measures["auroc"] == trackfail.auroc(scores, error) == 1
    assert measures["found_at_5"] == trackfail.found_at(5, alarm_scores, error) == 0
    assert trackfail.frame_measures(scores, error)["found_at_5"] == 1


def test_what_is_refused() -> None:
    with pytest.raises(ValueError, match="did you mean `khalid2016/1`"):
        trackfail.score([0], error=[0.1], protocol="khalid2016/11")
    with pytest.raises(ValueError, match="labels has the length 1, error 2"):
        trackfail.score([0], error=[0.1, 0.2])
    with pytest.raises(ValueError, match="boxes and truth, or error"):
        trackfail.score([0])
    with pytest.raises(ValueError, match="no score in frame 1"):
        trackfail.auroc([0.1, N], [0, 1])
    with pytest.raises(ValueError, match="scores of track 0 has the length 1"):
        trackfail.auroc([0.1], [0, 1])
    for measure in (trackfail.frame_measures, trackfail.auroc, trackfail.average_precision, partial(trackfail.found_at, 5)):
        with pytest.raises(ValueError, match='good: want "high" or "low"'):
            measure([0.9, 0.1], [0, 1], good="High")  # type: ignore[arg-type]
    assert "nab/1" in trackfail.protocols()


def test_tracks_may_be_series() -> None:
    scores, error = [0.0, 5, 4, 3, 3, 1], [0.0, 1, 0, 0, 1, 0]
    table = pd.DataFrame({"score": scores, "error": error})
    # Its first row has the index 1.
    part = table[table["score"] > 0]
    polars = pl.DataFrame({"score": scores[1:], "error": error[1:]})
    for given in (part, polars):
        assert trackfail.auroc(given["score"], given["error"]) == 4.5 / 6
    assert trackfail.auroc([part["score"]], [part["error"]]) == 4.5 / 6


@pytest.mark.parametrize("frame", [pd.DataFrame, pl.DataFrame])
def test_tracks_may_be_the_columns_of_data_frames(frame: Any) -> None:
    a, b = [0.0] * 20 + [5.0] * 10, [0.0] * 15 + [1.0] * 15
    error, alarms = [0.0] * 20 + [1.0] * 10, [False] * 20 + [True] * 10
    for columns in ([a], [a, b]):
        count = len(columns)
        want = trackfail.frame_measures(columns, [error] * count, [alarms] * count)
        scores, wrong, labels = (
            frame({str(k): column for k, column in enumerate(given)}) for given in (columns, [error] * count, [alarms] * count)
        )
        assert want["losses"] == count and trackfail.frame_measures(scores, wrong, labels) == want
        assert trackfail.frame_measures([scores], [wrong], [labels], alarm_scores=scores) == want
        assert trackfail.found_at(5, scores, wrong) == want["found_at_5"]
    # The rows of an array are tracks, as those of a list.
    assert trackfail.auroc(np.array([a, b]), np.array([error] * 2)) == trackfail.auroc([a, b], [error] * 2)


def test_scores_are_compared_as_objects() -> None:
    one, other = (trackfail.score([0] * 20 + [1] * 9, error=[0.1] * 20 + [1] * 9) for _ in range(2))
    assert one != other and len({one, other}) == 2
