"""Long-term sequences that public repositories hold, with tracks of others, laid out as a data root.

    longterm_data.py CLONES DATA

CLONES holds clones (bare ones will do) under the names of the repositories, a `/` written as `+`; one that is not there is
named and left out. Needs git, nothing else.

    gregorzadnik/acvm-exercise-5 @ 15c3454    car9 of VOT-LT and UAV20L, four runs of SiamFC
    iiau-tracker/SPLT @ a196e60               yamaha of VOT-LT, SPLT's tracks of both
    zk00006/OpenTLD @ 4d301ad                 TLD: videos, ground truth, tracks; `git fetch origin pull/53/head` brings it

TLD has corners in pixels from 1, `left,top,right,bottom`, both ends included. They become `x,y,w,h` lines, and for sequences
with a video the XML of CVML, which counts from 0. A frame of NaN stays one: the target, or the tracker's answer, is absent.
"""

import io
import subprocess
import sys
import zipfile
from pathlib import Path

ACVM = ("gregorzadnik+acvm-exercise-5", "15c3454")
SPLT = ("iiau-tracker+SPLT", "a196e60")
TLD = ("zk00006+OpenTLD", "4d301ad77928a8c139f87009a45d985bd96b117d")

# Folder of a sequence, and whether its frames are read; the large videos are left out.
SEQUENCES = {
    "04_pedestrian2": True,
    "05_pedestrian3": True,
    "06_car": True,
    "07_motocross": False,
    "08_volkswagen": False,
    "09_carchase": False,
    "10_panda": True,
}
# Files of a tracker's corners; the first has its confidence behind them, and no line for the last frame.
TRACKERS = {"initial_detector": "Detector", "TLD1.0": "TLD1.0", "CVPR": "PN"}


def show(clones, repository, path):
    """The bytes of a file at the pinned commit."""
    name, commit = repository
    return subprocess.run(["git", "-C", clones / name, "show", f"{commit}:{path}"], check=True, capture_output=True).stdout


def put(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())


def vot(clones, repository, folder, frames, target):
    """Frames and ground truth of a sequence, without the folder `color` between them."""
    for number in range(1, frames + 1):
        put(target / f"{number:08}.jpg", show(clones, repository, f"{folder}/color/{number:08}.jpg"))
    put(target / "groundtruth.txt", show(clones, repository, f"{folder}/groundtruth.txt"))


def acvm(clones, data):
    vot(clones, ACVM, "car9", 1879, data / "uav20l" / "car9")
    for run in ["st", "lt", "gaussian", "threshold"]:
        for file in ["car9_bboxes.txt", "car9_scores.txt"]:
            put(data / "results/longterm" / f"SiamFC-{run}" / file, show(clones, ACVM, f"results_{run}/{file}"))


def splt(clones, data):
    vot(clones, SPLT, "video/yamaha", 3143, data / "vot-lt" / "yamaha")
    archive = zipfile.ZipFile(io.BytesIO(show(clones, SPLT, "results/SPLT.zip")))
    for name in ["car9", "yamaha"]:
        for end in [".txt", "_confidence.value"]:
            file = f"longterm/{name}/{name}_001{end}"
            put(data / "results/longterm/SPLT" / file, archive.read(f"Top3/{file}"))


def corners(content):
    """Rows of left, top, right, bottom and what is behind them; none where a row is NaN."""
    rows = [line.split(",") for line in content.decode().split("\n") if line.strip()]
    return [None if row[0].strip().lower() == "nan" else [float(v) for v in row] for row in rows]


def line(row):
    if row is None:
        return "NaN,NaN,NaN,NaN\n"
    left, top, right, bottom = row[:4]
    return f"{left:.10g},{top:.10g},{right - left + 1:.10g},{bottom - top + 1:.10g}\n"


def cvml(name, rows):
    text = [f'<?xml version="1.0" encoding="UTF-8"?>\n<dataset name="{name}">\n']
    for number, row in enumerate(rows):
        text.append(f'<frame number="{number}"><objectlist>')
        if row is not None:
            left, top, right, bottom = row[0] - 1, row[1] - 1, row[2], row[3]
            box = f'w="{right - left:.10g}" h="{bottom - top:.10g}"'
            middle = f'xc="{(left + right) / 2:.10g}" yc="{(top + bottom) / 2:.10g}"'
            text.append(f'<object id="1"><box {box} {middle}/></object>')
        text.append("</objectlist></frame>\n")
    return "".join([*text, "</dataset>\n"])


def tld(clones, data):
    for folder, has_video in SEQUENCES.items():
        name = folder[3:]
        truth = corners(show(clones, TLD, f"datasets/{folder}/gt.txt"))
        if has_video:
            put(data / "tld" / name / f"{name}.xml", cvml(name, truth))
            put(data / "tld" / name / f"{name}.mpg", show(clones, TLD, f"datasets/{folder}/{name}.mpg"))
        else:
            put(data / "tld-boxes" / f"{name}.txt", "".join(map(line, truth)))
        for file, tracker in TRACKERS.items():
            rows = corners(show(clones, TLD, f"datasets/{folder}/{file}.txt"))
            below = data / "results" / "tld" / tracker
            put(below / f"{name}.txt", "".join(map(line, rows)))
            if tracker == "Detector":
                values = ["\n" if row is None else f"{row[4]:.10g}\n" for row in rows]
                put(below / f"{name}_confidence.value", "".join(values))


def main(clones, data):
    for step, (name, _) in [(acvm, ACVM), (splt, SPLT), (tld, TLD)]:
        if (Path(clones) / name).is_dir():
            step(Path(clones), Path(data))
        else:
            print(f"{name}: not there", file=sys.stderr)


main(*sys.argv[1:])
