"""Time of success and precision of 540,000 boxes with got10k-toolkit, on the boxes of benches/score.rs.

Needs got10k. Prints a JSON line for compare.py; AUC and precision at 20 pixels go to stderr. One thread.
"""

import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import json
import sys
import time

import numpy as np
from got10k.experiments import ExperimentOTB

FRAMES, SEQUENCES = 1000, 540


def sequence(s):
    t = np.arange(FRAMES)
    truth = np.c_[(7 * t + s) % 500, 3 * t % 300, np.full(FRAMES, 60), 40 + t % 9].astype(float)
    boxes = truth.copy()
    boxes[:, 0] += np.where(4 * t > 3 * FRAMES, 45, 0) + t * s % 13
    boxes[:, 1] += (t + s) % 7
    return boxes, truth


def score(experiment, sequences):
    curves = []
    for boxes, truth in sequences:
        boxes = boxes.copy()
        boxes[0] = truth[0]
        curves.append(experiment._calc_curves(*experiment._calc_metrics(boxes, truth)))
    success, precision = (np.mean(c, axis=0) for c in zip(*curves))
    return success.mean(), precision[20]


# Its constructor downloads the dataset.
experiment = object.__new__(ExperimentOTB)
experiment.nbins_iou, experiment.nbins_ce = 21, 51
sequences = [sequence(s) for s in range(SEQUENCES)]
score(experiment, sequences[:10])
seconds = []
for _ in range(3):
    begin = time.perf_counter()
    values = score(experiment, sequences)
    seconds.append(time.perf_counter() - begin)
print("success AUC {:.9f}, precision {:.9f}".format(*values), file=sys.stderr)
size = FRAMES * SEQUENCES
print(json.dumps({"bench": "score/success", "size": size, "peer": "got10k", "seconds": min(seconds)}))
