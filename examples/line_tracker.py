#!/usr/bin/env python3
"""A tracker for trackfail in its line protocol: where the first patch fits best, by least squares."""
import sys

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from PIL import Image

RADIUS = 8

for message, line in enumerate(sys.stdin):
    word, *rest = line.rstrip("\n").split("\t")
    if word == "quit":
        break
    frame = np.asarray(Image.open(rest[0]).convert("L"), np.float32)
    if word == "init":
        rows, columns = frame.shape
        x, y, w, h = (round(float(number)) for number in rest[1].split(","))
        w, h = min(max(w, 2), columns), min(max(h, 2), rows)
        x, y = min(max(x, 0), columns - w), min(max(y, 0), rows - h)
        target = frame[y:y + h, x:x + w]
    else:
        left, top = max(x - RADIUS, 0), max(y - RADIUS, 0)
        near = frame[top:y + h + RADIUS, left:x + w + RADIUS]
        error = ((sliding_window_view(near, target.shape) - target) ** 2).sum((2, 3))
        down, right = np.unravel_index(error.argmin(), error.shape)
        x, y = left + right, top + down
    print(f"{x},{y},{w},{h} #{message}", flush=True)
