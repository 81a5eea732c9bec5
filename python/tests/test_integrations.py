"""Trackers and result files of other packages; those that are not installed are skipped."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import pytest

import trackfail
from trackfail.integrations import Track, by_id, read_pysot, read_pytracking, watch_opencv, watch_results

BOX = (30, 20, 24, 24)


def scene(t: int) -> npt.NDArray[np.uint8]:
    """A frame of a patterned target that moves to the right by a pixel a frame."""
    y, x = np.mgrid[:96, :160]
    frame = np.stack((x + y, 2 * y, 255 - x), axis=2).astype(np.uint8)
    rows, columns = np.mgrid[: BOX[3], : BOX[2]]
    target = 128 + 120 * np.sin(rows / 3)[..., None] * np.cos(columns[..., None] / (2 + np.arange(3)))
    frame[BOX[1] : BOX[1] + BOX[3], BOX[0] + t : BOX[0] + t + BOX[2]] = target.astype(np.uint8)
    return frame


class Scripted:
    """A tracker as OpenCV has them: it has no box in frame 2."""

    def __init__(self, score: float) -> None:
        self.score, self.t = score, 0

    def init(self, frame: npt.NDArray[np.uint8], box: tuple[int, ...]) -> None:
        assert frame.shape == (96, 160, 3) and all(type(number) is int for number in box)
        self.box = box

    def update(self, _: npt.NDArray[np.uint8]) -> tuple[bool, tuple[int, ...]]:
        self.t += 1
        return self.t != 2, (self.box[0] + self.t, *self.box[1:])

    def getTrackingScore(self) -> float:
        return self.score


def test_a_tracker_is_watched_as_by_hand() -> None:
    frames = [scene(t) for t in range(6)]
    watched = list(watch_opencv(Scripted(-1.0), frames, (30.3, 19.6, 24, 24)))
    assert [box for box, _ in watched] == [BOX, (31, *BOX[1:]), None, *((30 + t, *BOX[1:]) for t in (3, 4, 5))]
    monitor = trackfail.Monitor(colors="bgr")
    assert [judgement for _, judgement in watched] == [
        monitor.update(frame, box) for frame, (box, _) in zip(frames, watched, strict=True)
    ]
    assert watched[2][1].state == "absent"
    # A confidence that there is comes along.
    judged = [judgement for _, judgement in watch_opencv(Scripted(0.9), frames, BOX, trackfail.Monitor(method="Confidence"))]
    assert judged[0].note is not None and judged[1].note is None
    with pytest.raises(ValueError, match="box: want"):
        next(watch_opencv(Scripted(0.9), frames, (1, 2, 0, 4)))


@pytest.mark.parametrize("name", ["TrackerKCF", "TrackerCSRT", "TrackerNano"])
def test_trackers_of_opencv(name: str, tmp_path: Path) -> None:
    cv2: Any = pytest.importorskip("cv2")
    if not hasattr(cv2, name):
        pytest.skip(f"this OpenCV has no {name}")
    if name == "TrackerNano":
        folder = os.environ.get("TRACKFAIL_NANOTRACK")
        if folder is None:
            pytest.skip("TRACKFAIL_NANOTRACK names no folder with NanoTrack's networks")
        params = cv2.TrackerNano_Params()
        params.backbone = os.path.join(folder, "nanotrack_backbone_sim.onnx")
        params.neckhead = os.path.join(folder, "nanotrack_head_sim.onnx")
        tracker = cv2.TrackerNano.create(params)
    else:
        tracker = getattr(cv2, name).create()
    for t in range(12):
        assert cv2.imwrite(str(tmp_path / f"{t:04}.png"), scene(t))
    watched = list(watch_opencv(tracker, tmp_path / "%04d.png", BOX))
    assert len(watched) == 12 and all(judgement.probability is not None for _, judgement in watched)
    last = watched[-1][0]
    assert last is not None and abs(last[0] - (BOX[0] + 11)) < 4
    with pytest.raises(ValueError, match="OpenCV cannot open"):
        next(watch_opencv(tracker, tmp_path / "nowhere.mp4", BOX))


class Tensors:
    """Boxes as Ultralytics has them: corners, id, confidence and class."""

    def __init__(self, rows: list[tuple[float, ...]]) -> None:
        data = np.array(rows, dtype=np.float32).reshape(-1, 7)
        self.xyxy, self.id, self.conf = data[:, :4], data[:, 4], data[:, 5]

    def cpu(self) -> Tensors:
        return self

    numpy = cpu


def row(name: int, x: float) -> tuple[float, ...]:
    return (x, 20, x + 24, 44, name, 0.75, 0)


def test_each_id_has_a_monitor() -> None:
    rows = [[row(1, 30 + t)] + [row(7, 90)] * (t in {1, 2, 9}) for t in range(10)]
    results = [SimpleNamespace(orig_img=scene(t), boxes=Tensors(rows[t]), obb=None) for t in range(10)]
    judged = list(watch_results(results, patience=3))
    assert [sorted(frame) for frame in judged] == [[1], *[[1, 7]] * 5, *[[1]] * 3, [1, 7]]
    assert [frame[7].state for frame in judged[3:6]] == ["absent"] * 3
    # One that comes back after that is a new one.
    assert (judged[9][1].index, judged[9][7].index) == (9, 0)
    alone = trackfail.Monitor(colors="bgr")
    want = [alone.update(scene(t), (30 + t, 20, 24, 24), 0.75) for t in range(10)]
    assert [frame[1] for frame in judged] == want
    none = SimpleNamespace(orig_img=scene(0), boxes=SimpleNamespace(id=None), obb=None)
    turned = SimpleNamespace(
        id=np.array([3.0]), conf=np.array([0.5]), xyxyxyxy=np.array([[[9, 5], [30, 9], [28, 20], [7, 16]]])
    )
    turned.cpu = turned.numpy = lambda: turned
    both = list(watch_results([none, SimpleNamespace(orig_img=scene(0), boxes=None, obb=turned)]))
    assert both[0] == {} and both[1][3].state == "tracking"


@pytest.mark.filterwarnings("ignore")
def test_results_of_ultralytics() -> None:
    results: Any = pytest.importorskip("ultralytics.engine.results")
    made = [results.Results(scene(t), "clip.mp4", {0: "box"}, boxes=np.array([row(1, 30 + t)])) for t in range(4)]
    made.append(results.Results(scene(4), "clip.mp4", {0: "box"}, boxes=np.zeros((0, 6))))
    states = [judged[1].state for judged in watch_results(made, method="First colors")]
    assert states == ["tracking"] * 4 + ["absent"]


MOT = "1,4,10,20,30,40,0.9,-1,-1,-1\n3,4,12,20,30,40,0.9,-1,-1,-1\n\n2,2,50,60,7,8,0.5,-1,-1,-1\n"


def test_a_table_by_id(tmp_path: Path) -> None:
    file = tmp_path / "mot.txt"
    file.write_text(MOT)
    want = {2: [None, (50, 60, 7, 8), None], 4: [(10, 20, 30, 40), None, (12, 20, 30, 40)]}
    assert by_id(file) == want and list(by_id(file)) == [2, 4]
    assert by_id(np.loadtxt(MOT.splitlines()[:1], delimiter=",")) == {4: [(10, 20, 30, 40)]}
    rows = np.loadtxt(MOT.splitlines(), delimiter=",")
    assert by_id(pd.DataFrame(rows)) == want
    assert by_id(rows) == want and by_id(rows.tolist(), frames=4)[2] == [*want[2], None]
    rows[:, 0] -= 1
    assert by_id(rows) == want
    judged = trackfail.judge(None, by_id(rows), method="Displacement")
    assert list(judged) == [2, 4] and judged[4].state.tolist() == ["tracking", "absent", "tracking"]
    for table, words in [
        ([[1, 2, 3]], "less than six numbers"),
        (
            np.array([[1, 4, 0, 0, 9, 9], [np.nan, 4, 0, 0, 9, 9]]),
            r"row 1 \(from 0\) of the table: frame and id have to be whole",
        ),
        ([[1, np.inf, 0, 0, 9, 9]], "not 1 and inf"),
        ([[1.5, 4, 0, 0, 9, 9]], "not 1.5 and 4"),
        ([[1, 4, 0, 0, 9, 9]] * 2, "frame 1 has two boxes of target 4"),
        ([[5, 4, 0, 0, 9, 9]], "frames 1 to 5, the video 3"),
    ]:
        with pytest.raises(ValueError, match=words):
            by_id(table, frames=3)
    file.write_text("\n1,4.5,10,20,30,40\n")
    with pytest.raises(ValueError, match=r"mot\.txt, line 2: frame and id"):
        by_id(file)
    file.write_text("1,4,ten,20,30,40\n")
    with pytest.raises(ValueError, match=r"mot\.txt, line 1: want numbers"):
        by_id(file)
    assert by_id([]) == {}


@pytest.mark.filterwarnings("ignore")
def test_tables_of_norfair(tmp_path: Path) -> None:
    norfair: Any = pytest.importorskip("norfair")
    (tmp_path / "seqinfo.ini").write_text("[Sequence]\nseqLength=8\n")
    table = norfair.metrics.PredictionsTextFile(str(tmp_path), str(tmp_path))
    tracker = norfair.Tracker(distance_function="mean_euclidean", distance_threshold=30, initialization_delay=0)
    for t in range(8):
        corners = [np.array([[x, 20.0], [x + 24, 44]]) for x in (30.0 + t, 100.0 - t)]
        table.update(tracker.update([norfair.Detection(points) for points in corners]))
    tracks = by_id(tmp_path / "predictions" / f"{tmp_path.name}.txt", frames=8)
    assert len(tracks) == 2 and all(None not in boxes[1:] for boxes in tracks.values())
    assert [len(judged) for judged in trackfail.judge(None, tracks).values()] == [8, 8]


@pytest.mark.filterwarnings("ignore")
def test_tables_of_boxmot() -> None:
    boxmot: Any = pytest.importorskip("boxmot")
    tracker = boxmot.ByteTrack()
    rows = []
    for t in range(8):
        found = np.array([[30 + t, 20, 54 + t, 44, 0.9, 0], [100 - t, 50, 124 - t, 74, 0.9, 0]], dtype=np.float32)
        # left, top, right, bottom, id, ...
        for x1, y1, x2, y2, name, *_ in np.asarray(tracker.update(found, scene(t))):
            rows.append((t + 1, name, x1, y1, x2 - x1, y2 - y1))
    tracks = by_id(rows, frames=8)
    assert [len(judged) for judged in trackfail.judge(None, tracks).values()] == [8, 8]


def write(folder: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def test_folders_of_pytracking(tmp_path: Path) -> None:
    folder = write(
        tmp_path / "dimp50_000",
        {
            "Car.txt": "10\t20\t30\t40\n11\t20\t30\t40\n-1\t-1\t-1\t-1\n",
            "Car_time.txt": "0.1\n0.1\n0.1\n",
            "Car_object_presence_scores.txt": "1.000000\n0.998765\nnan\n",
            "Dog.txt": "1\t2\t3\t4\n",
        },
    )
    tracks = read_pytracking(folder)
    assert tracks["Car"] == Track([(10, 20, 30, 40), (11, 20, 30, 40), None], [1.0, 0.998765, None])
    assert list(tracks) == ["Car", "Dog"] and tracks["Dog"] == Track([(1, 2, 3, 4)], None)
    judged = trackfail.judge(None, tracks["Car"].boxes, confidence=tracks["Car"].confidence, base=1)
    assert judged.method == "Confidence" and judged.state.tolist() == ["tracking", "tracking", "absent"]
    write(folder, {"Dog.txt": "1\t2\t3\n"})
    with pytest.raises(ValueError, match=r"Dog\.txt, line 1: 3 numbers are no box"):
        read_pytracking(folder)
    with pytest.raises(ValueError, match="has no result files"):
        read_pytracking(tmp_path)


def test_folders_of_pysot(tmp_path: Path) -> None:
    flat = write(tmp_path / "OTB100/model", {"Car.txt": "10.5,20.0,30,40\n11,20,30,40\n"})
    assert read_pysot(flat) == {"Car": Track([(10.5, 20, 30, 40), (11, 20, 30, 40)], None)}
    got = write(tmp_path / "GOT-10k/model", {"v/v_001.txt": "1,2,3,4\n", "v/v_time.txt": "0.1\n"})
    assert read_pysot(got) == {"v": Track([(1, 2, 3, 4)], None)}
    corners = "1.0000,1.0000,5.0000,2.0000,4.0000,6.0000,0.0000,5.0000"
    vot = write(tmp_path / "VOT2018/model", {"baseline/ants/ants_001.txt": f"1\n{corners}\n2\n0\n0\n0\n5,5,5,5,5,5,5,5\n1\n"})
    boxes = read_pysot(vot)["ants"].boxes
    assert boxes == [None, (1, 1, 5, 2, 4, 6, 0, 5), *[None] * 6]
    longterm = {"longterm/cat/cat_001.txt": "1\n1,2,3,4\n", "longterm/cat/cat_001_confidence.value": "\n0.998765\n"}
    folder = write(tmp_path / "VOT2018-LT/model", longterm)
    assert read_pysot(folder) == {"cat": Track([None, (1, 2, 3, 4)], [None, 0.998765])}
    write(folder, {"longterm/cat/cat_001_confidence.value": "\n"})
    with pytest.raises(ValueError, match=r"confidence\.value has 1 lines, cat_001\.txt 2"):
        read_pysot(folder)
