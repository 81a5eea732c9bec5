"""A folder of images is read in the order of one number, or refused in the words of the program."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable
from pathlib import Path

import pytest

from trackfail._frames import source


def folder_of(names: Iterable[str], folder: Path) -> Path:
    for name in names:
        (folder / name).touch()
    return folder


IN_ORDER = [
    [f"{t}.png" for t in range(8, 13)],
    [f"DJI_1000({t}).png" for t in range(8, 13)],
    [f"cam2_{t:04}.png" for t in range(98, 103)],
    ["img_9.jpeg", "img_10.PNG", "img_11.png"],
    ["7.png"],
    ["frame.png"],
]
REFUSED = [
    (["1.png", "1.jpg", "2.png"], "frame 1 again, after "),
    (["img1.png", "img01.png", "img2.png"], "frame 1 again, after "),
    (["1.png", "2.png", "4.png"], "frame 3 is missing; frames 1 to 4 are needed"),
]
DOUBTFUL = [
    ["1.png", "10.png", "background.png"],
    ["left1.png", "right1.png", "left2.png", "right2.png"],
    ["a.png", "b.png"],
    ["cam1_01.png", "cam1_02.png", "cam2_01.png"],
    ["0.5.png", "1.25.png"],
]


@pytest.mark.parametrize("names", IN_ORDER, ids=lambda names: str(names[0]))
def test_one_number_of_a_name_counts(names: list[str], tmp_path: Path) -> None:
    frame_of = source(folder_of(names, tmp_path), len(names))
    assert [frame_of(t) for t in range(len(names))] == [tmp_path / name for name in names]


def test_hidden_files_are_no_frames(tmp_path: Path) -> None:
    frame_of = source(folder_of(["1.png", "._1.png", ".hidden.jpg", "2.png", "notes.txt"], tmp_path), 2)
    assert [frame_of(t) for t in range(2)] == [tmp_path / "1.png", tmp_path / "2.png"]


@pytest.mark.parametrize(("names", "words"), REFUSED + [(names, "the order of the frames is in doubt") for names in DOUBTFUL])
def test_a_doubtful_order_is_refused(names: list[str], words: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError) as caught:
        source(folder_of(names, tmp_path), len(names))
    assert words in str(caught.value) and str(tmp_path) in str(caught.value)


@pytest.mark.parametrize("names", [names for names, _ in REFUSED], ids=lambda names: str(names[0]))
def test_the_words_are_those_of_the_program(names: list[str], program: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError) as caught:
        source(folder_of(names, tmp_path), len(names))
    boxes = tmp_path / "boxes.txt"
    boxes.write_text("1,1,8,8\n" * len(names))
    ran = subprocess.run(
        [program, "detect", "--frames", tmp_path, "--boxes", boxes], capture_output=True, text=True, check=False
    )
    assert ran.returncode != 0 and str(caught.value).split(";", maxsplit=1)[0] in ran.stderr
