"""Signals and detectors in Python, for experiments.

A signal is a class with a method `update(frame, box)` that returns a number for each frame of a track:

    from trackfail import plugin

    @plugin.signal(good="low")
    class Size:
        def __init__(self, rate=0.1):
            self.rate, self.mean = rate, None

        def update(self, frame, box):
            size = box[2] * box[3]
            self.mean = size if self.mean is None else self.mean
            change = abs(size - self.mean)
            self.mean += self.rate * (size - self.mean)
            return change

A detector is a class with a method `update(value)` that returns a score, high where the tracker seems to have failed, and
whether it has; of a method with several signals, `update(value, *more)`. There is an object for each track, which is made
with the `params` of the experiment as keywords.

    python -m trackfail.plugin my_methods.py > plugins.toml

writes the file of programs for all classes of a file, beside which it has to stay, with the line for an experiment above
each; `trackfail run my.toml --plugins plugins.toml` then runs them in processes of their own. What they print goes to stderr,
and an error that they raise fails the cell with its last lines. `frame` is an RGB array with `reads="pixels"`, else None.
`update` is also given `confidence`, `absent`, `polygon`, `posterior` and `response`, where it has arguments of these names.
"""

from __future__ import annotations

import importlib.util
import inspect
import json
import math
import os
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Literal, TypeAlias, TypeVar

from ._trackfail import Frame
from ._types import Good, checked

Reads: TypeAlias = Literal["boxes", "pixels", "confidence", "response", "posterior"]
Role: TypeAlias = Literal["signal", "detector"]
Class = TypeVar("Class", bound=type)

_EXTRAS = ("confidence", "absent", "polygon", "posterior", "response")


@dataclass(frozen=True)
class Plugin:
    """A registered class."""

    role: Role
    name: str
    """Name of the program in `plugins.toml`."""
    made: Callable[..., Any]
    """The class."""
    version: str
    """Part of every address: raise it when the answers change."""
    options: Mapping[str, object]
    """Keys of the experiment's line beside `kind` and `program`."""
    deterministic: bool = False
    """True for a detector whose answers do not depend on `TRACKFAIL_SEED`."""


_REGISTERED: dict[tuple[str, str], Plugin] = {}


def signal(
    name: str | None = None, *, good: Good = "high", reads: Reads = "boxes", version: str = "1"
) -> Callable[[Class], Class]:
    """Registers a class as a signal; its name otherwise is that of the class in small letters."""
    return _register("signal", name, version, {"good": checked(good), "reads": reads}, True)


def detector(
    name: str | None = None, *, signals: int = 1, version: str = "1", deterministic: bool = True
) -> Callable[[Class], Class]:
    """Registers a class as a detector of so many signals."""
    return _register("detector", name, version, {} if signals == 1 else {"signals": signals}, deterministic)


def _register(
    role: Role, name: str | None, version: str, options: Mapping[str, object], deterministic: bool
) -> Callable[[Class], Class]:
    def keep(made: Class) -> Class:
        known = name if name is not None else re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", made.__name__).lower()
        if not callable(getattr(made, "update", None)):
            raise TypeError(f"{role} `{known}`: the class has no method `update`")
        _REGISTERED[role, known] = Plugin(role, known, made, version, options, deterministic)
        return made

    return keep


def _import(path: Path) -> list[Plugin]:
    """The classes that a file registers."""
    before = dict(_REGISTERED)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise ValueError(f"{path} is no file of Python")
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    sys.path.insert(0, str(path.parent))
    spec.loader.exec_module(module)
    found = [plugin for key, plugin in _REGISTERED.items() if plugin is not before.get(key)]
    if not found:
        raise ValueError(f"{path} registers no class with @plugin.signal or @plugin.detector")
    return found


def toml(path: str | os.PathLike[str]) -> str:
    """The file of programs for the classes that a file registers."""
    file = Path(path)
    parts = [
        "# Programs for `trackfail run --plugins`. Commands run in the folder of this file and name the file of classes "
        "relatively: keep both in one folder."
    ]
    for plugin in _import(file.resolve()):
        options = {"kind": "process", "program": plugin.name, **plugin.options}
        line = ", ".join(f"{key} = {_text(value)}" for key, value in options.items())
        command = [sys.executable, "-m", "trackfail.plugin", file.name, f"{plugin.role}.{plugin.name}"]
        part = [
            f"# In an experiment: {plugin.role} = {{ {line} }}",
            f"[{plugin.role}.{_text(plugin.name)}]",
            f"command = {_text(command)}",
            f"version = {_text(plugin.version)}",
            f"digest = {_text([file.name])}",
        ]
        if plugin.role == "detector":
            part.append(f"deterministic = {_text(plugin.deterministic)}")
        parts.append("\n".join(part))
    return "\n\n".join(parts) + "\n"


def _text(value: object) -> str:
    """A value as JSON and TOML both write it; TOML takes no escaped halves of a character."""
    return json.dumps(value, ensure_ascii=False)


def serve(plugin: Plugin, lines: Iterable[bytes], out: IO[bytes]) -> None:
    """Answers the messages of one track, a line of JSON each.

    Raises:
        ValueError: For an answer that is no finite number.
    """
    messages = (json.loads(line) for line in lines)
    made = plugin.made(**next(messages)["meta"]["params"])
    answer = _signal(made) if plugin.role == "signal" else _detector(made)
    for message in messages:
        told = {"index": message["index"], **answer(message)}
        if not math.isfinite(told["score"]):
            raise ValueError(f"{plugin.role} `{plugin.name}`: the score of frame {told['index']} is {told['score']}")
        out.write(json.dumps(told).encode() + b"\n")
        out.flush()


def _signal(made: Any) -> Callable[[Mapping[str, Any]], dict[str, Any]]:
    takes = inspect.signature(made.update).parameters
    takes_all = any(taken.kind is inspect.Parameter.VAR_KEYWORD for taken in takes.values())
    extras = [name for name in _EXTRAS if takes_all or name in takes]

    def answer(message: Mapping[str, Any]) -> dict[str, Any]:
        path = message["frame"]
        frame = None if path is None else Frame.decode(Path(path).read_bytes()).to_numpy()
        more = {name: message.get(name) for name in extras}
        return {"score": float(made.update(frame, tuple(message["box"]), **more))}

    return answer


def _detector(made: Any) -> Callable[[Mapping[str, Any]], dict[str, Any]]:
    def answer(message: Mapping[str, Any]) -> dict[str, Any]:
        score, has_failed = made.update(message["value"], *message.get("more", ()))
        return {"score": float(score), "label": int(bool(has_failed))}

    return answer


def main(arguments: list[str]) -> int:
    """Writes the file of programs for a file of classes, or answers as one of them."""
    if len(arguments) == 1:
        sys.stdout.buffer.write(toml(arguments[0]).encode())
        return 0
    if len(arguments) != 2:
        print("usage: python -m trackfail.plugin FILE.py [signal.NAME | detector.NAME]", file=sys.stderr)
        return 2
    # What the class prints, also from native code, is no answer.
    with os.fdopen(os.dup(1), "wb") as out:
        os.dup2(2, 1)
        plugins = {f"{plugin.role}.{plugin.name}": plugin for plugin in _import(Path(arguments[0]).resolve())}
        if arguments[1] not in plugins:
            print(f"{arguments[0]} has no {arguments[1]}; it has {', '.join(plugins)}", file=sys.stderr)
            return 2
        serve(plugins[arguments[1]], sys.stdin.buffer, out)
    return 0


if __name__ == "__main__":
    # The classes register in the module of this name, not in `__main__`.
    from trackfail.plugin import main as run

    sys.exit(run(sys.argv[1:]))
