"""Accuracy, failures and EAO of the result files in a data root by the VOT toolkit, as Rust constants.

    pip install vot-toolkit==0.7.4 attributee==0.1.9 "setuptools<81"
    python3 tests/oracles/resets.py DATA > src/score/resets/toolkit.rs
"""

import pathlib
import sys

import numpy as np
from PIL import Image
from vot.analysis.supervised import compute_accuracy, compute_eao_curve, count_failures, locate_failures_inits
from vot.region import calculate_overlaps
from vot.region.io import parse_region

TRACKERS = [("GOTURN/baseline", 3), ("PFTracker/baseline_lite", 1), ("CFTTracker/baseline_lite", 1)]


class Sequence:
    def __init__(self, folder):
        self.name = folder.name
        self.truth = [parse_region(line) for line in (folder / "groundtruth.txt").read_text().split()]
        self.size = Image.open(folder / "00000001.jpg").size

    def groundtruth(self):
        return self.truth


def main():
    root = pathlib.Path(sys.argv[1])
    folders = sorted(p.parent for p in (root / "vot2014").glob("*/groundtruth.txt"))
    sequences = [Sequence(folder) for folder in folders]
    print("/// Folder, repetitions, accuracy and failures of each sequence, EAO.")
    print("type Row = (&'static str, usize, &'static [(&'static str, f64, f64)], f64);")
    print("const TOOLKIT: &[Row] = &[")
    for tracker, runs in TRACKERS:
        rows, overlaps, success = [], [], []
        for s in sequences:
            accuracies, failures = [], []
            for run in range(1, runs + 1):
                path = root / "results/vot2014" / tracker / s.name / f"{s.name}_{run:03}.txt"
                track = [parse_region(line) for line in path.read_text().split()]
                accuracies.append(float(compute_accuracy(track, s)[0]))
                failures.append(count_failures(track)[0])
                o = calculate_overlaps(track, s.groundtruth(), s.size)
                failed, started = locate_failures_inits(track)
                for start, end in zip(started, failed):
                    overlaps.append(o[start:end])
                    success.append(False)
                if len(started) > len(failed):
                    overlaps.append(o[started[-1] :])
                    success.append(True)
            rows.append((s.name, float(np.mean(accuracies)), float(np.mean(failures))))
        curve = compute_eao_curve(overlaps, [1] * len(overlaps), success)
        lines = ", ".join(f'("{n}", {a!r}, {f!r})' for n, a, f in rows)
        print(f'    ("{tracker}", {runs}, &[{lines}], {float(np.mean(curve[108:372]))!r}),')
    print("];")


if __name__ == "__main__":
    main()
