"""Oracles for score::frames, from the programs whose measures they are.

    python3 tests/oracles/frames.py > tests/oracles/frames.json

Made with NumPy 1.26.4 (prts takes no later one), scikit-learn 1.9.1 and prts 1.0.0.3. The area under the risk-coverage
curve is that of torch-uncertainty (`torch_uncertainty/metrics/classification/risk_coverage.py` at 7df97be) and the score
of NAB that of `nab/sweeper.py` at d62afec (numenta/NAB), both written down here from their equations, since neither is a
small package.
"""

import json
import math

import numpy as np
from prts.time_series_metrics.precision import TimeSeriesPrecision
from prts.time_series_metrics.recall import TimeSeriesRecall
from sklearn.metrics import average_precision_score, roc_auc_score

RNG = np.random.default_rng(15)


def ranges(n, mean):
    """0 and 1 in runs of about `mean` frames, at least one of each."""
    while True:
        out = []
        while len(out) < n:
            out += [len(out) and 1 - out[-1]] * int(RNG.integers(1, 2 * mean))
        if 0 < sum(out[:n]) < n:
            return out[:n]


def ranking(n, digits):
    lost = RNG.integers(0, 2, n)
    score = np.round(RNG.normal(0, 1, n) + 0.7 * lost, digits)
    return {
        "lost": lost.tolist(),
        "score": score.tolist(),
        "auroc": roc_auc_score(lost, score),
        "average_precision": average_precision_score(lost, score),
    }


def coverage(n):
    lost = RNG.integers(0, 2, n)
    score = RNG.permutation(n) / 7 + 3.03 * lost
    errors = lost[np.argsort(score, kind="stable")]
    cov = np.arange(1, n + 1) / n
    risk = np.cumsum(errors) / np.arange(1, n + 1)
    area = lambda y: np.trapz(y, cov) / (1 - 1 / n)
    return {"lost": lost.tolist(), "score": score.tolist(), "aurc": area(risk), "augrc": area(risk * cov)}


def calibration(n):
    p = RNG.uniform(0, 1, n)
    good = (RNG.uniform(0, 1, n) < p**2).astype(int)
    place = np.digitize(p, np.linspace(0, 1, 11)[1:-1])
    ece = sum(
        (place == b).mean() * abs(good[place == b].mean() - p[place == b].mean()) for b in range(10) if (place == b).any()
    )
    return {"good": good.tolist(), "p": p.tolist(), "ece": ece}


def range_based(n, alpha, bias):
    lost, alarm = ranges(n, 9), ranges(n, 6)
    return {
        "lost": lost,
        "alarm": alarm,
        "alpha": alpha,
        "bias": bias,
        "precision": TimeSeriesPrecision(0.0, "reciprocal", bias).score(np.array(lost), np.array(alarm)),
        "recall": TimeSeriesRecall(alpha, "reciprocal", bias).score(np.array(lost), np.array(alarm)),
    }


def nab(n, mean):
    """Row by row, as the sweeper goes through a file with weights 1, 0.11 and 1; windows of more than one frame."""
    while True:
        lost, alarm = ranges(n, mean), ranges(n, 4)
        edges = np.flatnonzero(np.diff([0] + lost + [0]))
        windows = [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2])]
        if all(b > a for a, b in windows):
            break
    scaled = lambda y: -1.0 if y > 3.0 else 2 / (1 + math.exp(5 * y)) - 1.0
    probation = min(math.floor(0.15 * n), 0.15 * 5000)
    parts, false, before = {}, 0.0, None
    for i in range(n):
        window = next((w for w in windows if w[0] <= i <= w[1]), None)
        if window:
            value = scaled(-(window[1] - i + 1) / (window[1] - window[0] + 1)) / scaled(-1.0)
        else:
            value = 0.11 * (-1.0 if before is None else scaled((i - before[1]) / (before[1] - before[0])))
        if i >= probation:
            if window:
                parts.setdefault(window, -1.0)
            if alarm[i] and window:
                parts[window] = max(parts[window], value)
            elif alarm[i]:
                false += value
        if window and i == window[1]:
            before = window
    return {"lost": lost, "alarm": alarm, "score": sum(parts.values()) + false, "windows": len(parts)}


print(
    json.dumps(
        {
            "ranking": [ranking(n, digits) for n, digits in [(9, 0), (40, 1), (80, 6), (120, 0)]],
            "coverage": [coverage(n) for n in (2, 15, 60)],
            "calibration": [calibration(n) for n in (30, 200)],
            "range": [range_based(n, a, b) for n in (60, 150) for a in (0.0, 0.4) for b in ("flat", "front")],
            "nab": [nab(n, mean) for n, mean in [(60, 8), (120, 9), (200, 20), (300, 5)]],
        }
    )
)
