"""The heavy part of a frame of the reconstructed trackers in NumPy, for benches/reconstructed_trackers.rs.

    OMP_NUM_THREADS=1 python3 benches/peers/reconstructed_trackers.py

Prints one JSON line a measurement: bench, size, peer and seconds (best of the repetitions). Fragments: a whole
frame with grey histograms, by integral histograms of the part of the frame that the particles reach, all particles and
fragments at once. Look-up tables: only the scores of all windows, codes and tables being given; the Rust side also
codes the frame and learns.
"""

import json
import math
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import time

import numpy as np

N, SIGMA, RATE = 400, 0.2, 0.02
W, H = 40, 80


def strips(w, h):
    half_w, half_h = max(1, w // 4), max(1, int(0.05 * h + 0.5))
    centres = [(x, y) for y in range(half_h - h // 2, h // 2, 2 * half_h) for x in (-(w // 4), w // 4)]
    return [(x - half_w, y - half_h, x + half_w, y + half_h) for x, y in centres]


def fragments():
    return np.array(strips(W, H) + [(y, x, b, r) for x, y, r, b in strips(H, W)])


def frame(width=320, height=240):
    rng = np.random.default_rng(1)
    ramp = np.add.outer(np.arange(height), np.arange(width)) // 4
    return np.clip(ramp + 40 + rng.integers(-12, 13, (height, width)), 0, 255).astype(np.uint8)


class Fragments:
    def __init__(self, image):
        self.rng = np.random.default_rng(1)
        self.states = np.tile([160.0, 120.0], (N, 1))
        self.fragments = fragments()
        self.reliabilities = np.full(len(self.fragments), 1 / len(self.fragments))
        self.q = np.sqrt(self.histograms(self.look(image, self.states), self.states[:1])[0])

    def look(self, image, states):
        x0, y0 = np.floor(states.min(axis=0) - [W / 2 + 2, H / 2 + 2]).astype(int)
        x1, y1 = np.ceil(states.max(axis=0) + [W / 2 + 2, H / 2 + 2]).astype(int)
        x0, y0 = max(x0, 0), max(y0, 0)
        codes = image[y0:y1, x0:x1] >> 4
        one_hot = codes[..., None] == np.arange(16, dtype=np.uint8)
        sums = np.zeros((codes.shape[0] + 1, codes.shape[1] + 1, 16), np.int32)
        np.cumsum(np.cumsum(one_hot, axis=0, dtype=np.int32), axis=1, out=sums[1:, 1:])
        return sums, x0, y0

    def histograms(self, view, states):
        sums, x0, y0 = view
        height, width = sums.shape[:2]
        edges = np.floor(np.tile(states, 2)[:, None, :] + self.fragments + 0.5).astype(int)
        left, right = (np.clip(edges[..., k] - x0, 0, width - 1) for k in (0, 2))
        top, bottom = (np.clip(edges[..., k] - y0, 0, height - 1) for k in (1, 3))
        counts = sums[bottom, right] - sums[bottom, left] - sums[top, right] + sums[top, left]
        return counts / np.maximum((right - left) * (bottom - top), 1)[..., None]

    def likelihoods(self, view, states):
        rho = np.einsum("nku,ku->nk", np.sqrt(self.histograms(view, states)), self.q)
        return np.exp((rho - 1) / (2 * SIGMA**2))

    def update(self, image):
        self.states += self.rng.standard_normal((N, 2)) * 5
        view = self.look(image, self.states)
        votes = np.where(self.reliabilities >= 0.2 / len(self.reliabilities), self.reliabilities, 0)
        weights = self.likelihoods(view, self.states) @ (votes / votes.sum())
        weights /= weights.sum()
        mean = weights @ self.states
        d = self.states - mean
        covariance = (weights * d.T) @ d
        own = self.likelihoods(view, mean[None])[0]
        self.reliabilities += RATE * (own / own.sum() - self.reliabilities)
        places = (np.arange(N) + self.rng.random()) / N
        parents = np.searchsorted(np.cumsum(weights), places, side="right")
        self.states = self.states[np.minimum(parents, N - 1)]
        return mean, covariance


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
    image = frame()
    f = Fragments(image)
    line = {"bench": "fragments-particle-filter-grey", "size": N, "peer": "numpy, at once"}
    print(json.dumps(line | {"seconds": measure(lambda: f.update(image))}), flush=True)
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
