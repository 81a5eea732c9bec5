"""Oracle of the optical flow: OpenCV's calcOpticalFlowPyrLK on textured pairs of images.

    pip install -r tests/oracles/requirements.txt
    python3 tests/oracles/flow.py            # writes flow.json beside itself

Images come from a formula that the tests repeat. `points`, `found` and `back` are in pixels from the center of the first
pixel; `back` is where `found` goes in the first image. `status` and `status_back` are OpenCV's.
"""

import json
import pathlib
import sys

import cv2
import numpy as np


def image(width, height, dx, dy, zoom):
    """Waves seen through a motion: the pixel (x, y) shows place ((x - dx) / zoom, (y - dy) / zoom)."""
    u = (np.arange(width)[None, :] - dx) / zoom
    v = (np.arange(height)[:, None] - dy) / zoom
    value = (
        128
        + 30 * np.sin(0.21 * u + 0.13 * v)
        + 25 * np.sin(0.47 * v - 0.32 * u)
        + 20 * np.sin(0.83 * u + 0.2)
        + 15 * np.sin(0.71 * v + 0.9 * u)
    )
    return np.floor(value + 0.5).astype(np.uint8)


def cases():
    """Name, width, height, motion, window, levels, iterations, epsilon."""
    return [
        ("shift", 96, 80, (2.3, -1.7, 1.0), 21, 3, 30, 0.01),
        ("small window", 96, 80, (0.6, -0.4, 1.0), 3, 5, 20, 0.3),
        ("zoom", 120, 90, (-3.1, 1.2, 1.05), 15, 3, 20, 0.03),
        ("far", 140, 120, (9.4, 7.8, 1.0), 21, 3, 20, 0.03),
        ("levels of small windows", 97, 81, (3.3, 2.1, 0.98), 5, 5, 20, 0.03),
    ]


def main():
    out = []
    for name, width, height, motion, window, levels, iterations, epsilon in cases():
        first, second = image(width, height, 0, 0, 1), image(width, height, *motion)
        # From beyond the border to beyond the border.
        x, y = np.meshgrid(np.linspace(-0.7, width - 0.6, 8), np.linspace(-0.7, height - 0.6, 7))
        points = np.stack([x.ravel(), y.ravel()], axis=1).astype(np.float32)
        criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, iterations, epsilon)
        settings = dict(winSize=(window, window), maxLevel=levels, criteria=criteria)
        found, status, _ = cv2.calcOpticalFlowPyrLK(first, second, points, None, **settings)
        back, status_back, _ = cv2.calcOpticalFlowPyrLK(second, first, found, None, **settings)
        out.append(
            {
                "name": name, "width": width, "height": height, "motion": motion, "window": window, "levels": levels,
                "iterations": iterations, "epsilon": epsilon, "byte_sums": [int(i.sum()) for i in (first, second)],
                "points": points.tolist(), "found": found.tolist(), "status": status.ravel().tolist(),
                "back": back.tolist(), "status_back": status_back.ravel().tolist(),
            }  # fmt: skip
        )
    versions = {"python": sys.version.split()[0], "numpy": np.__version__, "opencv": cv2.__version__}
    text = json.dumps({"versions": versions, "cases": out})
    pathlib.Path(__file__).with_name("flow.json").write_text(text.replace('{"name"', '\n{"name"') + "\n")


if __name__ == "__main__":
    main()
