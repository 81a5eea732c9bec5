"""Asks `trackfail monitor` whether a tracker has lost its target. Needs Python 3.8 and nothing else."""
import json
import math
import os
import subprocess
import tempfile


def _numbers(box):
    return None if box is None else [float(number) for number in box]


class Monitor:
    """A running `trackfail monitor`. `arguments` are those of the command line: Monitor("--state", "track.state")."""

    def __init__(self, *arguments, program="trackfail"):
        command = [str(program), "monitor", *map(str, arguments)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        # Arrays are handed over in a file, in memory where there is such a folder: that is faster than base64.
        self.folder = tempfile.TemporaryDirectory(dir="/dev/shm" if os.path.isdir("/dev/shm") else None)

    def update(self, frame, box, confidence=None, companions=(), restart=False):
        """Judges the next frame and returns a dict with index, probability, state ("tracking", "lost" or "absent") and reasons.

        `frame` is a path, an array of rows of bytes (gray, or blue, green and red as in OpenCV), or None. `box` and
        `companions`, the boxes of other trackers, are (x, y, w, h) in pixels, or None. `restart`: the tracker starts anew here.
        """
        line = {"frame": self._picture(frame), "box": _numbers(box), "restart": bool(restart)}
        line["companions"] = [_numbers(box) for box in companions]
        if confidence is not None and math.isfinite(confidence):
            line["confidence"] = float(confidence)
        try:
            self.process.stdin.write(json.dumps(line).encode() + b"\n")
            self.process.stdin.flush()
            answer = self.process.stdout.readline()
        except BrokenPipeError:
            answer = b""
        if not answer.endswith(b"\n"):
            raise RuntimeError(f"trackfail monitor has ended with exit code {self.process.wait()}")
        answer = json.loads(answer)
        if "error" in answer:
            raise ValueError(answer["error"])
        return answer

    def _picture(self, frame):
        if not hasattr(frame, "tobytes"):
            return None if frame is None else str(frame)
        height, width, *channels = frame.shape
        path = os.path.join(self.folder.name, "frame")
        with open(path, "wb") as file:
            file.write(frame.tobytes())
        return {"raw": {"width": width, "height": height, "format": "bgr" if channels else "gray", "path": path}}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.communicate()
        self.folder.cleanup()
