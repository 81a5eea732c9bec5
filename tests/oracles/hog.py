"""Oracle of the histograms of oriented gradients: values computed with NumPy from the equations.

    pip install -r tests/oracles/requirements.txt
    python3 tests/oracles/hog.py            # writes hog.json beside itself

Everything is float64 and straightforward: a loop over pixels, orientations by arctan2, weights of cells as
hat functions, blocks from a padded table. Pixels come from an integer formula that the tests repeat.
"""

import json
import math
import pathlib

import numpy as np


def pixels(width, height, planes):
    """Planes of whole numbers, 0 to about 213."""
    c, y, x = np.meshgrid(np.arange(planes), np.arange(height), np.arange(width), indexing="ij")
    noise = ((x * 7919 + y * 104729 + c * 1299709) * 1664525 + 1013904223) % 2**32 >> 26
    return ((3 * x + x * y * (c + 1) // 2 + 40 * c) % 150 + noise).astype(float)


def gradient(image):
    """Gradient of the strongest plane; one-sided at the border, 0 along a side of one pixel."""
    gx, gy = np.zeros_like(image), np.zeros_like(image)
    if image.shape[2] > 1:
        gx = np.gradient(image, axis=2)
    if image.shape[1] > 1:
        gy = np.gradient(image, axis=1)
    best = np.argmax(gx**2 + gy**2, axis=0)[None]
    return np.take_along_axis(gx, best, 0)[0], np.take_along_axis(gy, best, 0)[0]


def hog(image, k):
    gx, gy = gradient(image)
    magnitude = np.hypot(gx, gy)
    angle = np.arctan2(gy, gx) % (2 * np.pi)
    # arctan2 of vertical gradients is exactly between two orientations: a tiny turn sends them on.
    orientation = np.floor(angle * 18 / (2 * np.pi) + 0.5 + 1e-9).astype(int) % 18
    h, w = image.shape[1] // k, image.shape[2] // k
    r = np.zeros((18, h, w))
    for y in range(h * k):
        for x in range(w * k):
            for v in range(h):
                for u in range(w):
                    near_x = max(0, 1 - abs((x + 0.5) / k - 0.5 - u))
                    near_y = max(0, 1 - abs((y + 0.5) / k - 0.5 - v))
                    if near_x * near_y > 0:
                        r[orientation[y, x], v, u] += magnitude[y, x] / k**2 * near_x * near_y
    for border in (np.s_[:, 0, :], np.s_[:, -1, :], np.s_[:, :, 0], np.s_[:, :, -1]):
        r[border] *= 8 / 7
    both = r[:9] + r[9:]
    energy = (both**2).sum(0)
    valid = energy[:-1, :-1] + energy[1:, :-1] + energy[:-1, 1:] + energy[1:, 1:]
    n = np.pad(1 / np.sqrt(valid + 1e-4 / (4 * k**4)), 1, mode="edge")
    blocks = [n[1:, 1:], n[:-1, 1:], n[1:, :-1], n[:-1, :-1]]
    cut = lambda v, b: np.minimum(v * b, 0.2)
    out = [0.5 * sum(cut(v, b) for b in blocks) for v in (*r, *both)]
    out += [0.2357 * sum(cut(v, b) for v in r) for b in blocks]
    return np.array(out)


def main():
    cases = []
    for width, height, planes, k in [(17, 14, 1, 4), (16, 21, 3, 4), (9, 8, 3, 1), (12, 12, 1, 6), (15, 9, 3, 2)]:
        values = hog(pixels(width, height, planes), k)
        assert math.isfinite(values.sum()) and values.shape == (31, height // k, width // k)
        features = [float(f"{v:.7g}") for v in values.ravel()]
        cases.append(dict(width=width, height=height, planes=planes, cell=k, features=features))
    lines = ",\n".join(json.dumps(c) for c in cases)
    pathlib.Path(__file__).with_suffix(".json").write_text(f"[\n{lines}\n]\n")


if __name__ == "__main__":
    main()
