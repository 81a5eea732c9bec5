#!/usr/bin/env python3
"""A signal for trackfail: how far the box's size is from its running mean, as a logarithm; low is good."""
import json
import math
import sys

meta = json.loads(sys.stdin.readline())["meta"]
rate = meta["params"].get("rate", 0.1)
mean = None
for line in sys.stdin:
    frame = json.loads(line)
    x, y, w, h = frame["box"]
    size = math.log(max(w, 1) * max(h, 1))
    mean = size if mean is None else mean
    print(json.dumps({"index": frame["index"], "score": abs(size - mean)}), flush=True)
    mean += rate * (size - mean)
