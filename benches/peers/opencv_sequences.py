"""Time OpenCV's trackers on whole sequences of OTB, for benches/real_sequences.rs.

Needs numpy and opencv-contrib-python-headless, and TRACKFAIL_DATA, a path list of data roots; sequences that are nowhere
are left out. Prints JSON lines for compare.py: seconds of one pass over the sequence, without decoding, and the success
AUC as the OTB toolkit computes it (21 thresholds, the first frame counts as the truth). One thread.

TrackerMOSSE and the old TrackerKCF are in `cv2.legacy`. `kcf` is set beside all that are not CSRT, `dsst` and `samf`
beside CSRT.
"""

import json
import os
import pathlib
import re
import time

import cv2
import numpy as np

SEQUENCES = ("CarScale", "Woman", "FaceOcc1")


def trackers():
    """Names, makers and what of ours stands beside them."""
    modern = ["TrackerKCF", "TrackerCSRT"]
    for name in modern + ["legacy.TrackerKCF", "legacy.TrackerMOSSE"]:
        home, _, plain = name.rpartition(".")
        module = getattr(cv2, home, None) if home else cv2
        maker = getattr(module, plain + "_create", None) or getattr(getattr(module, plain, None), "create", None)
        if maker is not None:
            yield name, maker, ["dsst", "samf"] if plain == "TrackerCSRT" else ["kcf"]


def auc(boxes, truth):
    a, b = np.array(boxes, float), np.array(truth, float)
    a[0] = b[0]
    low, high = np.maximum(a[:, :2], b[:, :2]), np.minimum(a[:, :2] + a[:, 2:], b[:, :2] + b[:, 2:])
    shared = np.prod(np.clip(high - low, 0, None), axis=1)
    overlap = shared / (np.prod(a[:, 2:], axis=1) + np.prod(b[:, 2:], axis=1) - shared)
    return float(np.mean([np.mean(overlap > k / 20) for k in range(21)]))


def one_pass(maker, frames, box):
    """Seconds, and a box a frame; a lost tracker's last box is kept."""
    boxes, last = [box], box
    start = time.perf_counter()
    tracker = maker()
    tracker.init(frames[0], tuple(int(v) for v in box))
    for frame in frames[1:]:
        found, new = tracker.update(frame)
        last = new if found else last
        boxes.append(last)
    return time.perf_counter() - start, boxes


def main():
    cv2.setNumThreads(1)
    roots = [pathlib.Path(r) for r in os.environ.get("TRACKFAIL_DATA", "").split(os.pathsep) if r]
    for name in SEQUENCES:
        folder = next((r / "otb" / name for r in roots if (r / "otb" / name).is_dir()), None)
        if folder is None:
            continue
        lines = (folder / "groundtruth_rect.txt").read_text().split("\n")
        truth = [[float(v) for v in re.split(r"[,\s]+", line.strip())] for line in lines if line.strip()]
        truth = [(x - 1, y - 1, w, h) for x, y, w, h in truth]
        frames = [cv2.imread(str(path)) for path in sorted((folder / "img").iterdir())][: len(truth)]
        truth = truth[: len(frames)]
        for tracker, maker, ours in trackers():
            runs = [one_pass(maker, frames, truth[0]) for _ in range(2)]
            seconds, score = min(s for s, _ in runs), auc(runs[0][1], truth)
            for bench in ours:
                line = {"bench": bench, "size": name, "peer": "opencv " + tracker, "seconds": seconds, "auc": score}
                print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
