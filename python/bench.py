"""Time of a frame at 640 x 480: the monitor in this process, and `trackfail monitor` as a process of its own.

    python bench.py [--method NAME] [--frames N] [--rounds N] [--program PATH]

*Frame* is handed a decoded frame, so that it is the time of the judging itself and of the call; what an *array* costs beyond it
is the conversion. A process is handed the same pixels in a file in memory, or in base64. All ways are timed in turn, frame by
frame; the medians of the rounds' medians are told, and how far the rounds were apart.
"""

from __future__ import annotations

import argparse
import base64
import json
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

import trackfail

WIDTH, HEIGHT = 640, 480
Pixels: TypeAlias = npt.NDArray[np.uint8]
Box: TypeAlias = tuple[float, float, float, float]


def video(frames: int) -> list[tuple[Pixels, Box]]:
    """BGR frames of a target that moves by a pixel a frame, with its boxes."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    ground = np.stack((x // 4, y // 2, (x + y) // 5), axis=2).astype(np.uint8)
    rows, columns = np.mgrid[:60, :50]
    target = np.stack((rows * 4, columns * 5, (rows * columns) % 255), axis=2).astype(np.uint8)
    made = []
    for t in range(frames):
        left = 100 + t % 400
        frame = ground.copy()
        frame[200:260, left : left + 50] = target
        made.append((frame, (float(left), 200.0, 50.0, 60.0)))
    return made


class Process:
    """A running `trackfail monitor`."""

    def __init__(self, program: str, method: str, in_file: bool) -> None:
        self.folder = tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None)
        self.file = Path(self.folder.name) / "frame" if in_file else None
        command = [program, "monitor", "--method", method]
        self.run = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def update(self, frame: Pixels, box: Box) -> float | None:
        """Hands a frame over and waits for the answer."""
        raw: dict[str, Any] = {"width": WIDTH, "height": HEIGHT, "format": "bgr"}
        if self.file is None:
            raw["data"] = base64.b64encode(frame.tobytes()).decode()
        else:
            self.file.write_bytes(frame.tobytes())
            raw["path"] = str(self.file)
        assert self.run.stdin is not None and self.run.stdout is not None
        self.run.stdin.write(json.dumps({"frame": {"raw": raw}, "box": box}).encode() + b"\n")
        self.run.stdin.flush()
        answer = json.loads(self.run.stdout.readline())
        if "error" in answer:
            raise ValueError(answer["error"])
        probability: float | None = answer["probability"]
        return probability

    def __enter__(self) -> Process:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.run.communicate()
        self.folder.cleanup()


Way: TypeAlias = Callable[[Pixels, trackfail.Frame, Box], float | None]


def ways(method: str, files: Process | None, texts: Process | None) -> dict[str, Way]:
    """The ways to have a frame judged: each is given its pixels, the decoded frame and the box."""
    bare, same, turned = (trackfail.Monitor(method=method, colors=colors) for colors in (None, "bgr", "rgb"))
    found: dict[str, Way] = {
        "Frame": lambda _, frame, box: bare.update(frame, box).probability,
        "array": lambda pixels, _, box: same.update(pixels, box).probability,
        "array, colors reversed": lambda pixels, _, box: turned.update(pixels[..., ::-1], box).probability,
    }
    if files is not None and texts is not None:
        found["process, a file"] = lambda pixels, _, box: files.update(pixels, box)
        found["process, base64"] = lambda pixels, _, box: texts.update(pixels, box)
    return found


def one_round(frames: list[tuple[Pixels, Box]], method: str, program: str | None) -> dict[str, float]:
    """The median of each way, without the first frames, in which memory and networks are set up."""
    if program is None:
        return timed(frames, ways(method, None, None))
    with Process(program, method, True) as files, Process(program, method, False) as texts:
        return timed(frames, ways(method, files, texts))


def timed(frames: list[tuple[Pixels, Box]], found: dict[str, Way]) -> dict[str, float]:
    """The median time of each way in milliseconds; all have to give the same answers."""
    times: dict[str, list[float]] = {name: [] for name in found}
    for pixels, box in frames:
        told = []
        for name, way in found.items():
            ready = trackfail.Frame(pixels, "bgr")
            start = time.perf_counter()
            probability = way(pixels, ready, box)
            times[name].append(1000 * (time.perf_counter() - start))
            told.append(-1.0 if probability is None else probability)
        # The program rounds to four digits.
        if max(told) - min(told) > 1e-4:
            raise AssertionError(f"the ways differ: {told}")
    return {name: statistics.median(of[min(5, len(of) // 2) :]) for name, of in times.items()}


def main() -> int:
    """Prints a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--method", action="append", help="may be given several times")
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--program", default=shutil.which("trackfail"), help="the program `trackfail`")
    given = parser.parse_args()
    if given.program is None:
        print("there is no program `trackfail` on the PATH, so that no process is timed", file=sys.stderr)
    frames = video(given.frames)
    print("| method | way | ms a frame | over Frame | least to largest |\n|---|---|--:|--:|--:|")
    for method in given.method or ["First colors", "Agreement", trackfail.recommended(frames=True)]:
        rounds = [one_round(frames, method, given.program) for _ in range(given.rounds)]
        bare = statistics.median(one["Frame"] for one in rounds)
        for way in rounds[0]:
            of = [one[way] for one in rounds]
            median = statistics.median(of)
            print(f"| {method} | {way} | {median:.2f} | {median - bare:.2f} | {min(of):.2f} to {max(of):.2f} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
