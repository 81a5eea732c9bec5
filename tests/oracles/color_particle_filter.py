"""Oracle of the color particle filter: values computed with NumPy from the equations.

    pip install -r tests/oracles/requirements.txt
    python3 tests/oracles/color_particle_filter.py    # writes color_particle_filter.json beside itself

Everything is float64 and straightforward: r^2 of every pixel of the frame, a mask, numpy.bincount; colors
become HSV by colorsys; moments by numpy.average and numpy.cov; systematic resampling by
numpy.searchsorted. Frames come from an integer formula that the tests repeat. Ellipses are [x, y, Hx, Hy,
theta] in pixels from 0 and radians.
"""

import colorsys
import json
import math
import pathlib
import sys

import numpy as np

WIDTH, HEIGHT = 72, 56


def frame(t):
    """Gradients, a block that moves by (3, 2) and noise, from integers alone."""
    x = np.arange(WIDTH, dtype=np.int64)[None, :, None]
    y = np.arange(HEIGHT, dtype=np.int64)[:, None, None]
    c = np.arange(3, dtype=np.int64)[None, None, :]
    noise = (((x * 7919 + y * 104729 + c * 1299709 + t * 15485863) * 1664525 + 1013904223) % 2**32) >> 27
    block = (x >= 20 + 3 * t) & (x < 40 + 3 * t) & (y >= 12 + 2 * t) & (y < 42 + 2 * t)
    value = (2 * x + 3 * y + 40 * c + t) % 160 + np.where(block, 90 - 45 * c, 0) + noise
    return np.clip(value, 0, 255).astype(np.uint8)


def bins(image, space, counts):
    """Bin numbers of the pixels."""
    unit = image / 255.0
    if space == "hsv":
        flat = [colorsys.rgb_to_hsv(*p) for p in unit.reshape(-1, 3)]
        unit = np.array(flat).reshape(image.shape)
    # Edges are exact fractions whose distance to the next value is above 1e-4.
    index = np.minimum(np.floor(unit * counts + 1e-9).astype(int), np.array(counts) - 1)
    return (index[..., 0] * counts[1] + index[..., 1]) * counts[2] + index[..., 2]


def histogram(numbers, count, ellipse):
    x, y, hx, hy, theta = ellipse
    dx = np.arange(numbers.shape[1])[None, :] + 0.5 - x
    dy = np.arange(numbers.shape[0])[:, None] + 0.5 - y
    u = math.cos(theta) * dx + math.sin(theta) * dy
    v = -math.sin(theta) * dx + math.cos(theta) * dy
    r2 = (u / hx) ** 2 + (v / hy) ** 2
    inside = r2 < 1
    h = np.bincount(numbers[inside], weights=1 - r2[inside], minlength=count)
    return h / h.sum() if h.sum() > 0 else h


def step(states, weights, q, numbers, noise, deviations, sigma, offset, limits):
    """Propagate, weigh, estimate, resample."""
    states = states + noise * deviations
    states[:, 2:4] = np.clip(states[:, 2:4], *limits)
    rho = np.array([np.sqrt(histogram(numbers, len(q), s) * q).sum() for s in states])
    weights = weights * np.exp((rho - 1) / (2 * sigma**2)) / (math.sqrt(2 * math.pi) * sigma)
    weights = weights / weights.sum()
    mean = np.average(states, axis=0, weights=weights)
    covariance = np.cov(states.T, aweights=weights, ddof=0)
    of_mean = np.sqrt(histogram(numbers, len(q), mean) * q).sum()
    n = len(states)
    parents = np.searchsorted(np.cumsum(weights), (np.arange(n) + offset) / n, side="right")
    return {
        "states": states.tolist(),
        "rho": rho.tolist(),
        "weights": weights.tolist(),
        "mean": mean.tolist(),
        "covariance": covariance.ravel().tolist(),
        "effective": 1 / (weights**2).sum(),
        "likelihood": math.exp((of_mean - 1) / (2 * sigma**2)),
        "parents": parents.tolist(),
    }


def sparse(h):
    return {str(u): float(h[u]) for u in np.flatnonzero(h)}


def main():
    rng = np.random.default_rng(2015)
    ellipses = [
        [30.0, 27.0, 10.0, 15.0, 0.0],
        [30.3, 26.8, 11.7, 14.2, 0.4],
        [33.1, 30.9, 20.5, 6.25, -1.3],
        [40.0, 20.0, 9.0, 9.0, 2.0],
        [2.4, 53.6, 12.0, 8.0, 0.7],
        [69.0, -3.0, 5.0, 14.0, -0.6],
        [36.0, 28.0, 72.0, 72.0, 0.1],
        [36.5, 28.2, 3.0, 3.0, 0.0],
        [-40.0, 20.0, 8.0, 8.0, 0.0],
    ]
    image = frame(0)
    histograms = []
    for space, counts in [("rgb", [8, 8, 8]), ("hsv", [8, 8, 8]), ("hsv", [16, 4, 3]), ("rgb", [1, 5, 16])]:
        numbers = bins(image, space, counts)
        for e in ellipses:
            h = histogram(numbers, math.prod(counts), e)
            case = {"space": space, "bins": counts, "ellipse": e}
            histograms.append(case | {"shares": sparse(h)})

    n, sigma, offset = 60, 0.2, 0.37
    deviations = np.array([5.0, 5.0, 0.75, 0.75, math.radians(4.0)])
    first = np.array([30.0, 27.0, 10.0, 15.0, 0.0])
    q = histogram(bins(frame(0), "rgb", [8, 8, 8]), 512, first)
    states, weights = np.tile(first, (n, 1)), np.full(n, 1 / n)
    steps = []
    for t in (1, 2):
        noise = rng.standard_normal((n, 5))
        numbers = bins(frame(t), "rgb", [8, 8, 8])
        s = step(states, weights, q, numbers, noise, deviations, sigma, offset, (3.0, 72.0))
        steps.append({"noise": noise.tolist()} | s)
        # The first step is not resampled: the second one starts with its weights.
        states, weights = np.array(s["states"]), np.array(s["weights"])

    # Colors: corners, greys, edges of hue and random ones, with their bins in 8 x 8 x 8 of HSV.
    levels = [0, 1, 31, 32, 64, 127, 128, 254, 255]
    colors = [[r, g, b] for r in levels for g in levels for b in levels]
    colors += rng.integers(0, 256, (600, 3)).tolist()
    hsv = bins(np.array(colors, np.uint8)[None], "hsv", [8, 8, 8])[0]
    out = {
        "versions": {"python": sys.version.split()[0], "numpy": np.__version__},
        "byte_sums": [int(frame(t).astype(np.int64).sum()) for t in range(3)],
        "colors": {"rgb": colors, "hsv_bins": hsv.tolist()},
        "histograms": histograms,
        "filter": {"first": first.tolist(), "offset": offset, "steps": steps},
    }
    path = pathlib.Path(__file__).with_suffix(".json")
    path.write_text(json.dumps(out, separators=(",", ":")).replace('{"space"', '\n{"space"') + "\n")


if __name__ == "__main__":
    main()
