#!/usr/bin/env python3
"""A detector for trackfail: label 1 where the signal has been above a level for some frames in a row."""
import json
import sys

params = json.loads(sys.stdin.readline())["meta"]["params"]
row = 0
for line in sys.stdin:
    value = json.loads(line)["value"]
    row = row + 1 if value > params["above"] else 0
    print(json.dumps({"score": value, "label": int(row >= params["frames"])}), flush=True)
