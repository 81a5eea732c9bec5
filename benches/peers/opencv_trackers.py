"""Time a frame of OpenCV's correlation filter trackers, on the frames of benches/correlation_filters.rs.

Needs numpy and opencv-contrib-python-headless. Prints JSON lines for compare.py. One thread. TrackerKCF sees grey
values and color names at a size of at most 80 x 80 pixels, without gradients or scale; it is set beside `kcf` and
`kcf-grey`, which see 160 x 160. TrackerCSRT (gradients, color names, a spatial mask, 33 scales) is set beside `dsst`
and `samf`.
"""

import json
import math
import time

import cv2
import numpy as np

SIDE = 64


def frame(shift):
    """As `frame` of the bench; OpenCV's channels are blue, green, red."""
    x = np.arange(640, dtype=np.uint64)[None, :, None] + np.uint64(12 - shift)
    y = np.arange(480, dtype=np.uint64)[:, None, None]
    c = np.arange(3, dtype=np.uint64)[None, None, :]
    smooth = 110 + 50 * np.sin(0.03 * x + c) + 30 * np.cos(0.05 * y + 2.0 * c)
    seed = x * np.uint64(7919) + y * np.uint64(104729) + c * np.uint64(1299)
    texture = (seed * np.uint64(2654435761) % np.uint64(2**32)) >> np.uint64(16)
    values = smooth + (texture % np.uint64(25)) - 12.0
    return np.ascontiguousarray(np.clip(values, 0, 255).astype(np.uint8)[:, :, ::-1])


def trackers():
    """Makers of what this build of OpenCV has."""
    legacy = getattr(cv2, "legacy", None)
    for name in ("TrackerKCF", "TrackerCSRT"):
        maker = getattr(cv2, name + "_create", None) or getattr(getattr(cv2, name, None), "create", None)
        if maker is None and legacy is not None:
            maker = getattr(legacy, name + "_create", None)
        if maker is not None:
            yield name, maker


def measure(tracker, frames, seconds=4.0):
    best, spent = math.inf, 0.0
    while spent < seconds:
        start = time.perf_counter()
        for f in frames:
            tracker.update(f)
        took = time.perf_counter() - start
        best, spent = min(best, took / len(frames)), spent + took
    return best


def main():
    cv2.setNumThreads(1)
    frames = [frame(shift) for shift in (3, 6, 9, 12, 9, 6, 3, 0)]
    ours = {"TrackerKCF": ["kcf", "kcf-grey"], "TrackerCSRT": ["dsst", "samf"]}
    for name, maker in trackers():
        tracker = maker()
        tracker.init(frames[7], (288, 208, SIDE, SIDE))
        seconds = measure(tracker, frames)
        for bench in ours[name]:
            line = {"bench": bench, "size": SIDE, "peer": "opencv " + name, "seconds": seconds}
            print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
