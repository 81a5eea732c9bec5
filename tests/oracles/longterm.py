"""Oracles for score::longterm, from vot-toolkit and pysot.

    python3 tests/oracles/longterm.py > tests/oracles/longterm.json

Made with NumPy 2.4.6, attributee 0.1.8 and vot-toolkit 0.9.0 (`vot/analysis/longterm.py`: `determine_thresholds`,
`compute_tpr_curves`). Its overlaps of regions are replaced by given ones. pysot's rules are written down from the
equations of `toolkit/utils/statistics.py` (c7fd71c) and `toolkit/evaluation/f1_benchmark.py`.
"""

import itertools
import json
from types import SimpleNamespace

import numpy as np
import vot.analysis.longterm as longterm

RNG = np.random.default_rng(15)


def sequence(n, digits):
    visible = RNG.uniform(0, 1, n) < 0.8
    overlap = np.where(visible, RNG.uniform(0, 1, n), 0.0)
    confidence = np.round(overlap + RNG.normal(0, 0.3, n) - 0.2, digits)
    return {"overlap": overlap.tolist(), "confidence": confidence.tolist(), "visible": int(visible.sum())}


def best(thresholds, precision, recall):
    with np.errstate(invalid="ignore"):
        f = np.nan_to_num(2 * precision * recall / (precision + recall))
    k = int(np.argmax(f))
    return {"precision": precision[k], "recall": recall[k], "f": f[k], "thresholds": list(map(float, thresholds[1:-1]))}


def vot(sequences):
    thresholds = longterm.determine_thresholds(itertools.chain(*[s["confidence"] for s in sequences]), 100)
    longterm.is_special = lambda region: region is None
    curves = []
    for s in sequences:
        longterm.calculate_overlaps = lambda *_, **__: s["overlap"]
        truth = [0] * s["visible"] + [None] * (len(s["overlap"]) - s["visible"])
        stub = SimpleNamespace(groundtruth=lambda: truth, size=(1, 1))
        curves.append(longterm.compute_tpr_curves(truth, s["confidence"], stub, thresholds))
    return best(thresholds, *np.mean(np.array(curves), axis=0))


def pysot(sequences):
    score = np.sort(np.concatenate([s["confidence"] for s in sequences]))
    n = len(score)
    delta = np.floor(n / 98)
    inner = score[np.floor(np.linspace(delta - 1, n - delta, 98) + 0.5).astype(int)]
    thresholds = np.concatenate([[-np.inf], inner, [np.inf]])[::-1]
    curves = []
    for s in sequences:
        overlap, confidence = np.array(s["overlap"]), np.array(s["confidence"])
        points = []
        for h in thresholds:
            at = confidence > 0 if h == -np.inf else confidence >= h
            points.append((overlap[at].mean(), overlap[at].sum() / s["visible"]) if at.any() else (1.0, 0.0))
        curves.append(np.transpose(points))
    return best(thresholds, *np.mean(curves, axis=0))


cases = []
for lengths, digits in [((150, 90, 200), 6), ((400,), 2), ((99, 30), 6)]:
    sequences = [sequence(n, digits) for n in lengths]
    cases.append({"sequences": sequences, "vot": vot(sequences), "pysot": pysot(sequences)})
print(json.dumps(cases))
