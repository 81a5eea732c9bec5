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
    return {"lost": lost.tolist(), "score": score.tolist(), **areas(lost, score)}


def areas(lost, score):
    n = len(lost)
    errors = lost[np.argsort(score, kind="stable")]
    cov = np.arange(1, n + 1) / n
    risk = np.cumsum(errors) / np.arange(1, n + 1)
    area = lambda y: np.trapz(y, cov) / (1 - 1 / n)
    return {"aurc": area(risk), "augrc": area(risk * cov)}


def calibration(n):
    p = RNG.uniform(0, 1, n)
    good = (RNG.uniform(0, 1, n) < p**2).astype(int)
    return {"good": good.tolist(), "p": p.tolist(), "ece": expected_error(good, p)}


def expected_error(good, p):
    place = np.digitize(p, np.linspace(0, 1, 11)[1:-1])
    return sum(
        (place == b).mean() * abs(good[place == b].mean() - p[place == b].mean()) for b in range(10) if (place == b).any()
    )


def range_based(n, alpha, bias):
    lost, alarm = ranges(n, 9), ranges(n, 6)
    return {"lost": lost, "alarm": alarm, "alpha": alpha, "bias": bias, **prts(lost, alarm, alpha, bias)}


def prts(lost, alarm, alpha, bias):
    return {
        "precision": TimeSeriesPrecision(0.0, "reciprocal", bias).score(np.array(lost), np.array(alarm)),
        "recall": TimeSeriesRecall(alpha, "reciprocal", bias).score(np.array(lost), np.array(alarm)),
    }


def windows_of(lost):
    edges = np.flatnonzero(np.diff([0] + lost + [0]))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2])]


def nab(n, mean):
    """Of windows of more than one frame."""
    while True:
        lost, alarm = ranges(n, mean), ranges(n, 4)
        if all(b > a for a, b in windows_of(lost)):
            break
    score, windows = swept(lost, alarm)
    return {"lost": lost, "alarm": alarm, "score": score, "windows": windows}


def swept(lost, alarm):
    """Row by row, as the sweeper goes through a file with weights 1, 0.11 and 1."""
    n, windows = len(lost), windows_of(lost)
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
    return sum(parts.values()) + false, len(parts)


def measures():
    """Every measure of one track, which is a different number for each; it is that of `varied(0)` in the tests."""
    losses = [(100, 140), (300, 320), (450, 480)]
    error = np.array([{3: 0.95, 7: 0.7}.get(t % 10, 0.2) for t in range(600)])
    score = np.array([t * 37 % 101 / 404 + t / 2**20 for t in range(600)])
    for a, b in losses:
        error[a:b] = 1.0
        for t in range(a, b):
            score[t] = 0.2 + t * 17 % 23 / 46 + t / 2**20
        for t in range(a - 20, a):
            score[t] += 0.01 * (t - a + 20)
    error[200:210] = np.nan
    for t, s in [(30, 0.95), (60, 0.85), (230, 0.75), (250, 0.65), (105, 0.99), (308, 0.9), (460, 0.8)]:
        score[t] = s
    alarm = [int(s >= 0.4 or 90 <= t < 110) for t, s in enumerate(score)]

    known = ~np.isnan(error)
    lost, s = error[known] == 1, score[known]
    iou = (1 - error[known]) / (1 + error[known])
    clear = (iou < 0.1) | (iou >= 0.5)
    good = s[~lost]
    first = [score[a : min(b, a + 16)] for a, b in losses]
    peaks = sorted(f.max() for f in first)
    half = peaks[1]
    runs = [t for t in range(600) if score[t] >= half and (t == 0 or score[t - 1] < half)]
    found = lambda budget: np.mean([1000 * (good >= p).sum() <= budget * len(good) for p in peaks])
    state = [int(e == 1) for e in error]

    def within(k):
        frames = [(any(t < a <= t + k for a, _ in losses), t) for t in range(600) if error[t] < 1]
        kept = [(imminent, score[t]) for imminent, t in frames if imminent or t + k < 600]
        return roc_auc_score(*zip(*kept))

    r = prts(state, alarm, 0.0, "flat")
    raw, windows = swept(state, alarm)
    return {
        "auroc": roc_auc_score(lost, s),
        "auprc": average_precision_score(lost, s),
        "auroc_clear": roc_auc_score(iou[clear] < 0.1, s[clear]),
        "auprc_clear": average_precision_score(iou[clear] < 0.1, s[clear]),
        "false_alarms_at_half": 1000 * (good >= half).sum() / len(good),
        "delay_at_half": np.mean([np.argmax(f >= half) for f in first if f.max() >= half]),
        "arl0_at_half": len(good) / sum(error[t] < 1 for t in runs),
        "found_at_2": found(2),
        "found_at_5": found(5),
        **{f"auroc_within_{k}": within(k) for k in (5, 15, 30)},
        **areas(lost, s),
        "ece": expected_error(~lost, 1 - s),
        "range_precision": r["precision"],
        "range_recall": r["recall"],
        "range_f": 2 * r["precision"] * r["recall"] / (r["precision"] + r["recall"]),
        "nab": 100 * (raw + windows) / (2 * windows),
    }


print(
    json.dumps(
        {
            "ranking": [ranking(n, digits) for n, digits in [(9, 0), (40, 1), (80, 6), (120, 0)]],
            "coverage": [coverage(n) for n in (2, 15, 60)],
            "calibration": [calibration(n) for n in (30, 200)],
            "range": [range_based(n, a, b) for n in (60, 150) for a in (0.0, 0.4) for b in ("flat", "front")],
            "nab": [nab(n, mean) for n, mean in [(60, 8), (120, 9), (200, 20), (300, 5)]],
            "measures": measures(),
        }
    )
)
