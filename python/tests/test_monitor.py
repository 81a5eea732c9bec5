"""Monitors agree with the program, in one thread, in several and after a fork."""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.queues import SimpleQueue
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

from conftest import Rendered, Run, answers, told
from trackfail import Frame, Judgement, Monitor

BOX = (10.0, 8.0, 20.0, 16.0)
T = TypeVar("T")
HAS_FORK = pytest.mark.skipif(not hasattr(multiprocessing, "get_context") or sys.platform == "win32", reason="there is no fork")


def pixels(seed: int = 0, shape: tuple[int, ...] = (48, 64, 3)) -> np.ndarray[Any, np.dtype[np.uint8]]:
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


@pytest.mark.parametrize("method", [None, "First colors", "Agreement", "CovF"])
def test_answers_are_those_of_the_program(method: str | None, rendered: Rendered, run: Run) -> None:
    arguments = [] if method is None else ["--method", method]
    want = answers(run("monitor", *arguments, given=rendered.lines()))
    with Monitor(method=method, colors="bgr") as monitor:
        arrays = (frame.to_numpy("bgr") for frame in rendered.frames)
        got = [told(monitor.update(array, box)) for array, box in zip(arrays, rendered.boxes, strict=True)]
        assert monitor.method == (method or "Fused deep")
    assert got == want
    assert any(answer["state"] == "lost" for answer in got)


def test_confidence_companions_budget_and_base(rendered: Rendered, run: Run) -> None:
    lines = [
        {"box": box, "confidence": 0.5 + 0.01 * (t % 7), "companions": [truth, None]}
        for t, (box, truth) in enumerate(zip(rendered.boxes.tolist(), rendered.truth.tolist(), strict=True))
    ]
    given = "".join(json.dumps(line) + "\n" for line in lines)
    want = answers(run("monitor", "--budget", 2, "--base", 1, "--inputs", "confidence,companions", given=given))
    monitor = Monitor("confidence, companions", budget=2, base=1)
    got = [told(monitor.update(None, line["box"], line["confidence"], line["companions"])) for line in lines]
    assert got == want


def test_a_frame_may_come_in_many_forms(rendered: Rendered) -> None:
    forms: list[list[Judgement]] = []
    for form in range(7):
        monitor = Monitor(method="First colors", colors="rgb" if form == 1 else "bgr")
        told_of = []
        for path, frame, box in zip(rendered.paths[:20], rendered.frames, rendered.boxes, strict=False):
            bgr = frame.to_numpy("bgr")
            given = [
                path,
                bgr[..., ::-1],
                bgr,
                frame,
                np.asfortranarray(bgr),
                np.ascontiguousarray(bgr[::-1, ::-1])[::-1, ::-1],
                np.frombuffer(bgr.tobytes(), np.uint8).reshape(bgr.shape),
            ][form]
            told_of.append(monitor.update(given, tuple(box)))  # type: ignore[arg-type]
        forms.append(told_of)
    assert all(form == forms[0] for form in forms)
    gray = pixels(shape=(48, 64))
    assert (Frame(gray).to_numpy() == np.repeat(gray[..., None], 3, axis=2)).all()


def test_what_is_refused_says_why_and_counts() -> None:
    monitor = Monitor(method="First colors", colors="bgr")
    monitor.update(pixels(), BOX)
    cases: list[tuple[object, object, str]] = [
        (pixels().astype(np.float32), BOX, "float32; frames have uint8"),
        (pixels(shape=(48, 64, 4)), BOX, r"\(48, 64, 4\)"),
        (pixels(shape=(48,)), BOX, "shape"),
        (pixels(shape=(0, 64, 3)), BOX, "no pixels"),
        (np.broadcast_to(np.uint8(0), (1 << 20, 1 << 20, 3)), BOX, "the image is 1048576x1048576 pixels; at most"),
        (pixels(shape=(32, 64, 3)), BOX, "the frame has 64x32 pixels, those before had 64x48"),
        (pixels(), (1, 2, 3), "box: a region takes 4 numbers"),
        (pixels(), (1, 2, 0, 4), "box: the region has no area"),
        (pixels(), (1, 2, float("inf"), 4), "finite"),
        (pixels(), "1,2,3,4", "box: want the numbers"),
        (pixels(), 7, "box: want the numbers"),
        (pixels(), set(BOX), "box: want the numbers"),
    ]
    for frame, box, words in cases:
        with pytest.raises(ValueError, match=words):
            monitor.update(frame, box)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="not list"):
        monitor.update([[1]], BOX)  # type: ignore[arg-type]
    with pytest.raises(FileNotFoundError, match=r"nowhere\.png"):
        monitor.update("nowhere.png", BOX)
    with pytest.raises(ValueError, match='colors="bgr", as OpenCV'):
        Monitor(method="First colors").update(pixels(), BOX)
    # As if they had not been there, but for their number.
    alone = Monitor(method="First colors", colors="bgr")
    first, second = alone.update(pixels(), BOX), alone.update(pixels(1), BOX)
    after = monitor.update(pixels(1), BOX)
    assert (after.index, after.probability, after.state) == (len(cases) + 3, second.probability, second.state)
    assert first.index == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"method": "Watchdgo"}, "did you mean `Watchdog`"),
        ({"method": "EmpTh"}, "methods that can monitor: "),
        ({"method": "Watchdog", "budget": 3.0}, "takes no budget"),
        ({"budget": -1.0}, "must be from"),
        ({"inputs": "frames,sound"}, "unknown input `sound`"),
        ({"colors": "hsv"}, '"rgb" or "bgr"'),
        ({"base": 2}, "base: want 0 or 1"),
    ],
)
def test_options_that_are_refused(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Monitor(**arguments)


def test_a_box_may_be_missing() -> None:
    monitor = Monitor(method="Displacement")
    states = [monitor.update(None, box).state for box in (None, BOX, None, (float("nan"),) * 4, BOX)]
    assert states == ["absent", "tracking", "absent", "absent", "tracking"]


def test_a_confidence_may_be_missing_but_not_infinite() -> None:
    none, nan, infinite = (Monitor(method="Confidence") for _ in range(3))
    for monitor in (none, nan, infinite):
        monitor.update(None, BOX, 0.9)
    assert none.update(None, BOX, None) == nan.update(None, BOX, float("nan"))
    for number in (float("inf"), -float("inf")):
        with pytest.raises(ValueError, match=r"confidence: -?inf is not a finite number"):
            infinite.update(None, BOX, number)
    assert infinite.index == 3


def test_a_saved_monitor_goes_on(rendered: Rendered, run: Run, tmp_path: Path) -> None:
    pairs = list(zip(rendered.frames, rendered.boxes, strict=True))
    whole = Monitor(colors="rgb")
    want = [whole.update(frame, box) for frame, box in pairs]
    monitor = Monitor(colors="rgb")
    got = [monitor.update(frame, box) for frame, box in pairs[:60]]
    path = tmp_path / "track.state"
    assert monitor.save(path) == path.read_bytes()
    resumed = Monitor.load(path)
    assert (resumed.index, resumed.method) == (60, monitor.method)
    got += [resumed.update(frame, box) for frame, box in pairs[60:]]
    assert got == want
    assert all(Monitor.load(given(path.read_bytes())).index == 60 for given in (bytes, bytearray, memoryview))
    # The program goes on with it, too.
    rest = "".join(line + "\n" for line in rendered.lines().splitlines()[60:])
    assert answers(run("monitor", "--state", path, given=rest)) == [told(answer) for answer in want[60:]]
    for damaged in (b"", b"no state", path.read_bytes()[:-1]):
        with pytest.raises(ValueError, match="state"):
            Monitor.load(damaged)


@pytest.mark.skipif(sys.platform == "win32", reason="links and permissions are other ones")
def test_a_state_is_written_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monitor = Monitor(method="Displacement")
    monitor.update(None, BOX)
    file, link = tmp_path / "track.state", tmp_path / "link.state"
    file.write_bytes(b"old")
    file.chmod(0o640)
    link.symlink_to(file)

    def fail(*_: object) -> None:
        raise OSError("no room")

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", fail)
        with pytest.raises(OSError, match="no room"):
            monitor.save(link)
    assert file.read_bytes() == b"old" and sorted(tmp_path.iterdir()) == [link, file]
    assert monitor.save(link) == file.read_bytes() and link.is_symlink() and file.stat().st_mode & 0o777 == 0o640
    assert sorted(tmp_path.iterdir()) == [link, file]


def test_a_restart_is_that_of_the_program(rendered: Rendered, run: Run) -> None:
    lines = answers(rendered.lines())
    lines[100] |= {"restart": True, "box": rendered.truth[100].tolist()}
    given = "".join(json.dumps(line) + "\n" for line in lines)
    want = answers(run("monitor", "--method", "First colors", given=given))
    monitor = Monitor(method="First colors")
    got = [
        told(monitor.restart(line["box"], frame) if "restart" in line else monitor.update(frame, line["box"]))
        for line, frame in zip(lines, rendered.frames, strict=True)
    ]
    assert got == want
    # Without a frame it is about the last one that was not refused.
    one, other = (Monitor(method="First colors") for _ in range(2))
    for monitor in (one, other):
        monitor.update(rendered.frames[0], rendered.boxes[0])
        with pytest.raises(ValueError, match="box"):
            monitor.update(rendered.frames[1], (1, 2, 3))
    assert one.restart(rendered.truth[0]) == other.restart(rendered.truth[0], rendered.frames[0])
    assert one.update(rendered.frames[1], rendered.truth[1]) == other.update(rendered.frames[1], rendered.truth[1])


def test_a_closed_monitor_judges_no_more() -> None:
    with Monitor(method="Displacement") as monitor:
        monitor.update(None, BOX)
        assert not monitor.closed
    monitor.close()
    assert monitor.closed and "closed" in repr(monitor)
    for use in (lambda: monitor.update(None, BOX), monitor.save, lambda: monitor.method, lambda: monitor.index):
        with pytest.raises(ValueError, match="the monitor is closed"):
            use()


def test_many_objects_share_a_frame_in_many_threads(rendered: Rendered) -> None:
    frames = [Frame(frame.to_numpy(), "rgb") for frame in rendered.frames[:40]]
    places = [rendered.boxes[0] + (8 * k, 5 * k, 0, 0) for k in range(6)]

    def follow(place: Any) -> list[Judgement]:
        monitor = Monitor(method="Agreement")
        return [monitor.update(frame, place) for frame in frames]

    with ThreadPoolExecutor(len(places)) as pool:
        together = list(pool.map(follow, places))
    assert together == [follow(place) for place in places]


def test_others_run_while_it_judges(rendered: Rendered) -> None:
    monitor = Monitor(method="Fused deep")
    monitor.update(rendered.frames[0], rendered.boxes[0])
    turns, stop, before = 0, threading.Event(), sys.getswitchinterval()

    def turn() -> None:
        nonlocal turns
        while not stop.is_set():
            turns += 1
            time.sleep(1e-4)

    other = threading.Thread(target=turn)
    other.start()
    try:
        # No thread is made to give way.
        sys.setswitchinterval(1000)
        at_first = turns
        for _ in range(10):
            monitor.update(rendered.frames[1], rendered.boxes[1])
        in_between = turns - at_first
    finally:
        sys.setswitchinterval(before)
        stop.set()
        other.join()
    assert in_between > 0


def test_two_uses_at_once_are_refused() -> None:
    monitor = Monitor(method="Companions")

    def companions() -> Iterator[tuple[float, ...]]:
        monitor.update(None, BOX)
        yield BOX

    with pytest.raises(RuntimeError, match="a monitor of its own"):
        monitor.update(None, BOX, companions=companions())
    assert monitor.update(None, BOX).index == 1


def test_a_monitor_in_use_is_described_and_left() -> None:
    monitor = Monitor(method="Companions")

    def companions() -> Iterator[tuple[float, ...]]:
        assert "judging in another thread" in repr(monitor)
        # The error of the body comes first.
        with pytest.raises(KeyError, match="camera"), monitor:
            raise KeyError("camera")
        with pytest.raises(RuntimeError, match="a monitor of its own"), monitor:
            pass
        yield BOX

    monitor.update(None, BOX, companions=companions())
    assert "Companions, next frame 1" in repr(monitor) and not monitor.closed
    assert "closed" in repr(Monitor.__new__(Monitor))


def refusals() -> list[str]:
    """The errors of bad inputs."""
    monitor, closed = (Monitor(method="First colors", colors="bgr") for _ in range(2))
    monitor.update(pixels(), BOX)
    closed.close()
    cases: list[tuple[Monitor, Any, tuple[float, ...]]] = [
        (monitor, pixels().astype(np.float32), BOX),
        (monitor, pixels(shape=(32, 64, 3)), BOX),
        (monitor, pixels(), BOX[:3]),
        (closed, pixels(), BOX),
    ]
    errors = []
    for judging, frame, box in cases:
        with pytest.raises(ValueError) as caught:
            judging.update(frame, box)
        errors.append(str(caught.value))
    return errors


def test_bad_inputs_are_refused_in_many_threads() -> None:
    want = refusals()
    for said, words in zip(want, ("float32", "64x32 pixels", "takes 4 numbers", "is closed"), strict=True):
        assert words in said
    together = threading.Barrier(8)

    def refuse(_: int) -> list[list[str]]:
        together.wait(60)
        return [refusals() for _ in range(20)]

    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(refuse, range(8))) == [[want] * 20] * 8


def forked(work: Callable[[], list[T]]) -> list[T]:
    """What a forked process answers."""
    context = multiprocessing.get_context("fork")
    queue: SimpleQueue[list[T]] = context.SimpleQueue()
    process = context.Process(target=lambda: queue.put(work()))
    process.start()
    process.join(120)
    alive = process.is_alive()
    process.kill()
    assert not alive and process.exitcode == 0
    return queue.get()


@HAS_FORK
def test_a_forked_process_has_threads_of_its_own(rendered: Rendered) -> None:
    def follow() -> list[Judgement]:
        monitor = Monitor(method="Agreement")
        return [monitor.update(frame, box) for frame, box in zip(rendered.frames[:10], rendered.boxes, strict=False)]

    want = follow()
    assert forked(follow) == want


@HAS_FORK
def test_bad_inputs_are_refused_in_a_forked_process() -> None:
    want = refusals()
    assert forked(refusals) == want
