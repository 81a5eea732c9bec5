"""Time of OpenCV's optical flow there and back, on the frames and points of benches/signals.rs.

Needs numpy and opencv-contrib-python-headless. Prints JSON lines for compare.py; `value` is the signal. One thread. As
`forward-backward` with its defaults: gray values of the box of 64 x 64 pixels and as much on all sides of it, in this
frame and the one before, 10 x 10 points, a window of 3 x 3 pixels, 5 smaller levels.
"""

import json

import cv2
import numpy as np
from signals_numpy import frame, measure

POINTS = 10
MARGIN = 5.0
SETTINGS = dict(
    winSize=(3, 3), maxLevel=5, criteria=(cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 20, 0.3)
)  # fmt: skip


def search(image, left, size):
    """Gray values of the box and its surroundings; red, green and blue in that order."""
    top = 100
    x0, y0 = max(left - size, 0), max(top - size, 0)
    return cv2.cvtColor(image[y0 : top + 2 * size, x0 : left + 2 * size], cv2.COLOR_RGB2GRAY), x0, y0


def points(left, size, x0, y0):
    x = np.linspace(left - 0.5 + MARGIN, left + size - 0.5 - MARGIN, POINTS) - x0
    y = np.linspace(100 - 0.5 + MARGIN, 100 + size - 0.5 - MARGIN, POINTS) - y0
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 1, 2).astype(np.float32)


def step(images, size):
    """What a frame costs: its part at the place of the box before, flow, and its part at the place of the box."""
    state = {"before": search(images[0], 100, size), "left": 100}

    def run():
        before, x0, y0 = state["before"]
        left = state["left"]
        image = images[left == 100]
        now, _, _ = search(image, left, size)
        start = points(left, size, x0, y0)
        found, status, _ = cv2.calcOpticalFlowPyrLK(before, now, start, None, **SETTINGS)
        back, returned, _ = cv2.calcOpticalFlowPyrLK(now, before, found, None, **SETTINGS)
        well = (status.ravel() == 1) & (returned.ravel() == 1)
        error = np.median(np.linalg.norm((back - start)[well].reshape(-1, 2), axis=1)) / size
        state["left"] = 203 - left
        state["before"] = search(image, state["left"], size)
        return float(error)

    return run


def main():
    cv2.setNumThreads(1)
    images = [np.ascontiguousarray(frame(shift=shift)) for shift in (0, 2)]
    for size in (32, 64, 128):
        run = step(images, size)
        line = {"bench": "forward-backward", "size": size, "peer": "opencv", "seconds": measure(run), "value": run()}
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
