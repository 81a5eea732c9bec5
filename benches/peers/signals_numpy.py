"""y_t and the covariance distance in vectorised NumPy and SciPy, timed on the first frame of benches/signals.rs.

    OMP_NUM_THREADS=1 python3 benches/peers/signals_numpy.py

Prints one JSON line a measurement: bench, size (pixels a side), peer, seconds (best of the repetitions)
and value (the signal, which the Rust bench has too). y_t comes in two forms: separable filters
(scipy.ndimage.correlate1d) and banded matrix products (BLAS); both smooth the four differences of
one-hot fields, as smoothing is linear, in float64.
"""

import json
import math
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import time

import numpy as np
import scipy.linalg
from scipy.ndimage import correlate1d

M = 32


def frame(side=384, shift=0):
    x = np.arange(side, dtype=np.int64)[None, :, None] + shift
    y = np.arange(side, dtype=np.int64)[:, None, None]
    c = np.arange(3, dtype=np.int64)[None, None, :]
    smooth = 128.0 + 70.0 * np.sin(0.03 * x + c) + 40.0 * np.cos(0.05 * y + 2.0 * c)
    texture = ((x * 7919 + y * 104_729 + c * 1299) * 2_654_435_761 % 4_294_967_296) >> 16
    return (smooth + (texture % 25) - 12.0).astype(np.uint8)


def gauss(sigma, support):
    r = np.arange(support) - support // 2
    g = np.exp(-(r**2) / (2 * sigma**2))
    return g / g.sum()


GU, GV, GL = gauss(1.0, 9), gauss(2.0, 15), gauss(0.625, 5)
LAYER = np.maximum(np.ceil(np.arange(256) * M / 255), 1).astype(np.int64) - 1
ONE_HOT = np.eye(M)


def band(n, g):
    """Matrix that correlates a vector of n values, zeros around it, with g."""
    r = len(g) // 2
    return sum(np.diag(np.full(n - abs(k), g[k + r]), k) for k in range(-r, r + 1) if abs(k) < n)


def even(n):
    """Layer smoothing with the lost mass spread evenly: an M x M matrix."""
    a = band(n, GL)
    return a + (1 - a.sum(axis=0)) / n


def windows(image, box, last):
    """The target's pixels and those of the four corner windows of B_t (no box leaves the frame here)."""
    x, y, w, h = box
    grow = math.ceil((w + h) / 4)
    bx, by = last[0] - grow / 2, last[1] - grow / 2
    places = [(x, y)] + [(bx + i * grow, by + j * grow) for j in (0, 1) for i in (0, 1)]
    corners = [(int(math.floor(u + 0.5)), int(math.floor(v + 0.5))) for u, v in places]
    return np.stack([image[v : v + h, u : u + w] for u, v in corners])


def y_t(image, box, last, smooth):
    patches = windows(image, box, last)
    one_hot = ONE_HOT[LAYER[patches]]
    # (4, h, w, 3, M)
    d = smooth(one_hot[0] - one_hot[1:])
    l1 = np.abs(d, out=d).sum(axis=(1, 2, 4))
    means = patches.mean(axis=(1, 2))
    gap = np.abs(means[0] - means[1:])
    omega = gap / gap.sum(axis=1, keepdims=True)
    return float((omega * l1).sum(axis=1).mean() / (box[2] * box[3] * M))


def smooth_filters(d):
    d = correlate1d(d, GV, axis=1, mode="constant")
    d = correlate1d(d, GU, axis=2, mode="constant")
    e = correlate1d(d, GL, axis=4, mode="constant")
    return e + (d.sum(axis=4, keepdims=True) - e.sum(axis=4, keepdims=True)) / M


BANDS = {}


def smooth_products(d):
    n, h, w, c, m = d.shape
    if (h, w) not in BANDS:
        BANDS[h, w] = band(h, GV), band(w, GU), even(m).T
    down, across, layers = BANDS[h, w]
    d = (down @ d.reshape(n, h, w * c * m)).reshape(n * h, w, c * m)
    d = across @ d
    return (d.reshape(-1, m) @ layers).reshape(n, h, w, c, m)


def covariance_distance(image, box, last):
    def covariance(x, y, w, h):
        rows, columns = np.mgrid[y : y + h, x : x + w]
        z = np.vstack([columns.ravel(), rows.ravel(), image[y : y + h, x : x + w].reshape(-1, 3).T])
        return np.cov(z) + 1e-6 * np.diag([w * h, w * h, 255.0**2, 255.0**2, 255.0**2])

    # As in an online run, one covariance a frame; the one before is kept.
    now = covariance(*box)
    before = KEPT.setdefault(last, now if last == box else covariance(*last))
    lam = scipy.linalg.eigh(now, before, eigvals_only=True)
    return float(np.sqrt((np.log(lam) ** 2).sum()))


KEPT = {}


def measure(f, seconds=2.0):
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
    for size in (32, 64, 128):
        box, last = (103, 100, size, size), (100, 100, size, size)
        runs = [
            ("distribution-field", "scipy filters", lambda: y_t(image, box, last, smooth_filters)),
            ("distribution-field", "numpy products", lambda: y_t(image, box, last, smooth_products)),
            ("region-covariance", "numpy", lambda: covariance_distance(image, box, last)),
        ]
        for bench, peer, f in runs:
            line = {"bench": bench, "size": size, "peer": peer, "seconds": measure(f), "value": f()}
            print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
