"""Tells when a visual object tracker has lost its target.

| what | for |
|---|---|
| `Monitor` | a tracker that runs: a judgement of each frame, at once |
| `judge` | whole tracks: columns of scores, labels and states |
| `score`, `errors`, `frame_measures`, `auroc`, `found_at`, ... | labels and scores against ground truth, by protocols |
| `load` | the results of an experiment as data frames |
| `trackfail.integrations` | trackers and result files of OpenCV, Ultralytics, norfair, boxmot, pytracking, pysot |
| `trackfail.plugin` | signals and detectors of one's own, for experiments |

Boxes are `x, y, w, h` in pixels, or the corners of a convex polygon, `x1, y1, x2, y2, ...`; the top left corner of a frame
is at 0, 0 unless `base` says 1. `None`, or NaN among the numbers, says that there is no box. Arrays of color frames need to
say the order of their colors: `colors="bgr"`, as OpenCV has them, or `colors="rgb"`. What is refused, also an object
that is no box, raises `ValueError`, another argument of another type `TypeError`, and a file that cannot be read or written
`OSError`.
"""

from ._judge import Judged, judge, methods, recommended
from ._load import Results, load
from ._monitor import Judgement, Monitor
from ._score import Score, auroc, average_precision, errors, found_at, frame_measures, protocols, score
from ._trackfail import Frame, __version__

__all__ = [
    "Frame",
    "Judged",
    "Judgement",
    "Monitor",
    "Results",
    "Score",
    "__version__",
    "auroc",
    "average_precision",
    "errors",
    "found_at",
    "frame_measures",
    "judge",
    "load",
    "methods",
    "protocols",
    "recommended",
    "score",
]
