"""Frames of a video in their order, from whatever has them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice, pairwise
from pathlib import Path
from typing import IO, TypeAlias

import numpy as np
import numpy.typing as npt

from ._trackfail import Frame
from ._types import Picture

Frames: TypeAlias = npt.NDArray[np.uint8] | Iterable[Picture] | str | os.PathLike[str]

_IMAGES = (".jpg", ".jpeg", ".png")
# As the program calls it, so that the pixels are the same.
_FFMPEG = "-nostdin -hide_banner -loglevel error -xerror -err_detect explode -protocol_whitelist file"
_CONTAINERS = "mpeg,mpegvideo,mpegts,avi,mov,matroska,webm"
_COLORS = "-pix_fmt rgb24 -sws_flags bicubic+accurate_rnd+full_chroma_int+bitexact"


def source(frames: Frames, count: int) -> Callable[[int], Picture] | Following:
    """A function from the index of a frame to the frame, which is asked in their order; there have to be `count`."""
    if isinstance(frames, (str, os.PathLike)):
        path = Path(frames)
        if not path.is_dir():
            return Following(_video(path), count, ends=True)
        frames = _images(path)
    if isinstance(frames, (Sequence, np.ndarray)):
        if len(frames) != count:
            raise _other_count(str(len(frames)), count)
        return frames.__getitem__
    return Following(iter(frames), count, ends=False)


class Following:
    """Frames that come one after the other; those that nobody asks for are passed over. `ends`: they surely end."""

    def __init__(self, frames: Iterator[Picture], count: int, ends: bool) -> None:
        self._frames, self._count, self._ends = frames, count, ends
        self._given = 0

    def __call__(self, t: int) -> Picture:
        for picture in self._frames:
            self._given += 1
            if self._given == t + 1:
                return picture
        raise _other_count(str(self._given), self._count)

    def finish(self) -> None:
        """Checks the number of frames: reads them to their end or, where there may be none, one more than there should be."""
        rest = self._frames if self._ends else islice(self._frames, self._count + 1 - self._given)
        self._given += sum(1 for _ in rest)
        if self._given != self._count:
            is_more = self._given > self._count and not self._ends
            raise _other_count(f"more than {self._count}" if is_more else str(self._given), self._count)


def _other_count(frames: str, boxes: int) -> ValueError:
    return ValueError(f"there are {frames} frames and {boxes} boxes; there must be one box for each frame")


def _images(folder: Path) -> list[Picture]:
    """The image files of a folder, or of its folder `img`, in the order of the one number that differs in their names.

    `trackfail detect` also reads names with dates and times, and puts all of these in the same order.
    """
    folder = folder / "img" if (folder / "img").is_dir() else folder
    files = [path for path in folder.iterdir() if path.suffix.lower() in _IMAGES and not path.name.startswith(".")]
    if not files:
        raise ValueError(f"{folder} has no .jpg or .png file")
    names = [re.split("([0-9]+)", path.stem) for path in files]
    texts = {tuple(name[::2]) for name in names}
    places = [k for k in range(1, len(names[0]), 2) if len({int(name[k]) for name in names}) > 1] if len(texts) == 1 else []
    if len(files) > 1 and len(places) != 1:
        raise ValueError(
            f"{folder}: the order of the frames is in doubt, since not one number alone differs in their names; "
            "rename the files, or give a list of them in their order"
        )
    numbered = sorted((int(name[places[0]]) if places else 0, path) for name, path in zip(names, files, strict=True))
    for (number, path), (following, other) in pairwise(numbered):
        if following == number:
            raise ValueError(f"{other}: frame {number} again, after {path.name}; keep one file a frame")
        if following > number + 1:
            first, last = numbered[0][0], numbered[-1][0]
            raise ValueError(
                f"{folder}: frame {number + 1} is missing; frames {first} to {last} are needed: "
                "add it, or number the files without a gap"
            )
    return [path for _, path in numbered]


def _video(path: Path) -> Iterator[Picture]:
    """The frames of a video, as ffmpeg decodes them."""
    if not path.is_file():
        raise FileNotFoundError(f"{path}: there is no such folder or file")
    program = shutil.which("ffmpeg")
    if program is None:
        raise ValueError(f"{path}: its frames have to be decoded, but there is no `ffmpeg` on the PATH; install it")
    command = [program, *_FFMPEG.split(), "-format_whitelist", _CONTAINERS, "-i", f"file:{path.resolve()}"]
    command += [
        "-map",
        "0:v:0",
        "-fps_mode",
        "passthrough",
        *_COLORS.split(),
        "-c:v",
        "ppm",
        "-f",
        "image2pipe",
        "pipe:1",
    ]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
        assert run.stdout is not None and run.stderr is not None
        try:
            while (picture := _picture(run.stdout)) is not None:
                yield picture
            said = run.stderr.read().decode(errors="replace").strip()
            if run.wait() != 0:
                raise ValueError(f"{path}: this is no video that ffmpeg reads, or a damaged one (ffmpeg: {said[:200]})")
        finally:
            run.kill()


def _picture(pipe: IO[bytes]) -> Frame | None:
    """The next picture: `P6`, width and height, 255, and the bytes."""
    if pipe.readline().strip() != b"P6":
        return None
    width, height = (int(side) for side in pipe.readline().split())
    pipe.readline()
    data = pipe.read(3 * width * height)
    if len(data) != 3 * width * height:
        return None
    return Frame(np.frombuffer(data, np.uint8).reshape(height, width, 3), "rgb")
