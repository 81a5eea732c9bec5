#!/usr/bin/env python3
"""A detector for trackfail: label 1 where the signal has been above a level for some frames in a row."""
import json
import sys

params = json.loads(sys.stdin.readline())["meta"]["params"]
row = 0
for line in sys.stdin:
    frame = json.loads(line)
    row = row + 1 if frame["value"] > params["above"] else 0
    label = int(row >= params["frames"])
    print(json.dumps({"index": frame["index"], "score": frame["value"], "label": label}), flush=True)
