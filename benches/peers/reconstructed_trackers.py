"""The heavy part of a frame of `pixel-lut` in NumPy, for benches/trackers.rs.

    OMP_NUM_THREADS=1 python3 benches/peers/reconstructed_trackers.py

Prints one JSON line a measurement: bench, size, peer and seconds (best of the repetitions). Only the scores of all
windows are computed, codes and tables being given; the Rust side also codes the frame and learns.
"""

import json
import math
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import time

import numpy as np


def scan(colors, tones, lut_colors, lut_tones, places, side):
    scores = np.zeros((side, side), np.float32)
    for k, (x, y) in enumerate(places):
        scores += lut_colors[k].take(colors[y : y + side, x : x + side])
        scores += lut_tones[k].take(tones[y : y + side, x : x + side])
    return scores


def measure(f, seconds=4.0):
    f()
    best, spent = math.inf, 0.0
    while spent < seconds:
        start = time.perf_counter()
        f()
        took = time.perf_counter() - start
        best, spent = min(best, took), spent + took
    return best


def main():
    rng = np.random.default_rng(2)
    colors, tones = rng.integers(0, 512, (124, 124)), rng.integers(0, 256, (124, 124))
    for bench, cells in [("pixel-lut", 16), ("pixel-lut-24-cells", 24)]:
        middles = ((np.arange(cells) + 0.5) * 64 / cells).astype(int)
        places = [(x, y) for y in middles for x in middles]
        luts = [rng.random((cells * cells, n), np.float32) for n in (512, 256)]
        took = measure(lambda: scan(colors, tones, *luts, places, 61))
        line = {"bench": bench, "size": 64, "peer": "numpy, scores only"}
        print(json.dumps(line | {"seconds": took}), flush=True)


if __name__ == "__main__":
    main()
