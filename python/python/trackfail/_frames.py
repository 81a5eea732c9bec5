"""Frames of a video in their order, from whatever has them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
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


def source(frames: Frames, count: int) -> Callable[[int], Picture]:
    """A function from the index of a frame to the frame, which is asked in their order; there have to be `count`."""
    if isinstance(frames, (str, os.PathLike)):
        path = Path(frames)
        if not path.is_dir():
            return _following(_video(path), count)
        frames = _images(path)
    if isinstance(frames, (Sequence, np.ndarray)):
        if len(frames) != count:
            raise ValueError(f"there are {len(frames)} frames and {count} boxes; there must be one box for each frame")
        return frames.__getitem__
    return _following(iter(frames), count)


def _following(frames: Iterator[Picture], count: int) -> Callable[[int], Picture]:
    """Frames that come one after the other; those that nobody asks for are passed over."""
    given = 0

    def frame(t: int) -> Picture:
        nonlocal given
        for picture in frames:
            given += 1
            if given == t + 1:
                return picture
        raise ValueError(f"there are {given} frames and {count} boxes; there must be one box for each frame")

    return frame


def _images(folder: Path) -> list[Picture]:
    """The image files of a folder, or of its folder `img`, in the order of the numbers in their names."""
    folder = folder / "img" if (folder / "img").is_dir() else folder
    files = [path for path in folder.iterdir() if path.suffix.lower() in _IMAGES]
    if not files:
        raise ValueError(f"{folder} has no .jpg or .png file")

    def numbers(path: Path) -> tuple[list[int], str]:
        return [int(number) for number in re.findall(r"\d+", path.stem)], path.name

    return [*sorted(files, key=numbers)]


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
