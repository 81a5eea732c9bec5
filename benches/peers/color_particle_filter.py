"""One frame of the color particle filter in NumPy, timed as benches/trackers.rs is.

    OMP_NUM_THREADS=1 python3 benches/peers/color_particle_filter.py

Prints one JSON line a measurement: bench, size (particles), peer and seconds (best of the repetitions). Two
forms: a loop over particles, each on its own box of pixels, and all particles at once on boxes of one
size. Both look up the bins of the frame once, in float64, with systematic resampling below 0.6 N.
"""

import json
import math
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import time

import numpy as np

N, SIGMA = 400, 0.2
DEVIATIONS = np.array([5.0, 5.0, 0.0, 0.0, math.radians(4.0)])
FIRST = np.array([160.0, 120.0, 20.0, 40.0, 0.0])


def frame(width=320, height=240):
    x = np.arange(width, dtype=np.int64)[None, :, None]
    y = np.arange(height, dtype=np.int64)[:, None, None]
    c = np.arange(3, dtype=np.int64)[None, None, :]
    target = np.where(((x - 159.5) / 20) ** 2 + ((y - 119.5) / 40) ** 2 < 1, 60.0, 0.0)
    smooth = 110.0 + 50.0 * np.sin(0.03 * x + c) + 30.0 * np.cos(0.05 * y + 2.0 * c)
    texture = ((x * 7919 + y * 104_729 + c * 1299) * 2_654_435_761 % 4_294_967_296) >> 16
    return np.clip(smooth + (texture % 25) - 12.0 + target * (1 - c), 0, 255).astype(np.uint8)


def numbers(image):
    i = image >> 5
    return (i[..., 0].astype(np.int64) << 6) | (i[..., 1] << 3) | i[..., 2]


def each(cells, states):
    """Histograms, a particle at a time: the box of its ellipse, a mask, bincount."""
    height, width = cells.shape
    out = np.zeros((len(states), 512))
    cos, sin = np.cos(states[:, 4]), np.sin(states[:, 4])
    rx = np.hypot(states[:, 2] * cos, states[:, 3] * sin)
    ry = np.hypot(states[:, 2] * sin, states[:, 3] * cos)
    x0 = np.maximum(np.floor(states[:, 0] - rx), 0).astype(int)
    x1 = np.minimum(np.ceil(states[:, 0] + rx), width).astype(int)
    y0 = np.maximum(np.floor(states[:, 1] - ry), 0).astype(int)
    y1 = np.minimum(np.ceil(states[:, 1] + ry), height).astype(int)
    for k, (x, y, hx, hy, _) in enumerate(states):
        dx = np.arange(x0[k], x1[k]) + (0.5 - x)
        dy = (np.arange(y0[k], y1[k]) + (0.5 - y))[:, None]
        u, v = (cos[k] / hx) * dx + (sin[k] / hx) * dy, (-sin[k] / hy) * dx + (cos[k] / hy) * dy
        weight = np.maximum(1 - u * u - v * v, 0)
        box = cells[y0[k] : y1[k], x0[k] : x1[k]]
        out[k] = np.bincount(box.ravel(), weights=weight.ravel(), minlength=512)
    return out


def together(cells, states):
    """Histograms of all particles at once, on boxes as large as the largest."""
    height, width = cells.shape
    r = math.ceil(states[:, 2:4].max()) + 1
    columns = np.floor(states[:, 0]).astype(int)[:, None] + np.arange(-r, r + 1)
    rows = np.floor(states[:, 1]).astype(int)[:, None] + np.arange(-r, r + 1)
    dx = (columns + 0.5 - states[:, :1])[:, None, :]
    dy = (rows + 0.5 - states[:, 1:2])[:, :, None]
    cos, sin = np.cos(states[:, 4])[:, None, None], np.sin(states[:, 4])[:, None, None]
    hx, hy = states[:, 2][:, None, None], states[:, 3][:, None, None]
    u, v = (cos / hx) * dx + (sin / hx) * dy, (-sin / hy) * dx + (cos / hy) * dy
    weight = 1 - u * u - v * v
    weight *= ((columns >= 0) & (columns < width))[:, None, :] & ((rows >= 0) & (rows < height))[:, :, None]
    k, i, j = np.nonzero(weight > 0)
    bins = cells[rows[k, i], columns[k, j]] + 512 * k
    return np.bincount(bins, weights=weight[k, i, j], minlength=512 * len(states)).reshape(-1, 512)


class Filter:
    def __init__(self, image, histograms):
        self.rng = np.random.default_rng(1)
        self.histograms = histograms
        self.states, self.weights = np.tile(FIRST, (N, 1)), np.full(N, 1 / N)
        h = histograms(numbers(image), FIRST[None])[0]
        self.q = np.sqrt(h / h.sum())

    def rho(self, cells, states):
        h = self.histograms(cells, states)
        total = h.sum(axis=1)
        return np.sqrt(h) @ self.q / np.sqrt(np.where(total > 0, total, 1))

    def update(self, image):
        cells = numbers(image)
        self.states += self.rng.standard_normal((N, 5)) * DEVIATIONS
        self.states[:, 2:4] = np.clip(self.states[:, 2:4], 3, 320)
        self.weights *= np.exp((self.rho(cells, self.states) - 1) / (2 * SIGMA**2))
        self.weights /= self.weights.sum()
        mean = self.weights @ self.states
        d = self.states - mean
        covariance = (self.weights * d.T) @ d
        likelihood = np.exp((self.rho(cells, mean[None])[0] - 1) / (2 * SIGMA**2))
        effective = 1 / (self.weights @ self.weights)
        if effective < 0.6 * N:
            places = (np.arange(N) + self.rng.random()) / N
            parents = np.searchsorted(np.cumsum(self.weights), places, side="right")
            self.states = self.states[np.minimum(parents, N - 1)]
            self.weights = np.full(N, 1 / N)
        return mean, covariance, effective, likelihood


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
    for peer, histograms in [("numpy, a loop", each), ("numpy, at once", together)]:
        f = Filter(image, histograms)
        line = {"bench": "color-particle-filter", "size": N, "peer": peer}
        print(json.dumps(line | {"seconds": measure(lambda: f.update(image))}), flush=True)


if __name__ == "__main__":
    main()
