"""A page about a judged track."""

from __future__ import annotations

import os
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ._judge import Judged

_WIDTH, _HEIGHT = 900, 160

_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{method}: {verdict}</title><style>
body {{ font: 16px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; background: #fff }}
svg {{ width: 100%; height: auto; border: 1px solid #bbb }} td, th {{ padding: .1rem 1rem .1rem 0; text-align: right }}
</style></head><body>
<h1>{verdict}</h1>
<p>Method {method}, {frames} frames; {meaning}. Frames count from 0.</p>
<svg viewBox="0 0 {width} {height}" role="img" aria-label="Scores over frames; losses are shaded">{chart}</svg>
<table><tr><th>lost from</th><th>to</th><th>frames</th><th>{extreme} score</th></tr>{rows}</table>
</body></html>
"""


def write(path: str | os.PathLike[str], judged: Judged) -> None:
    """Writes the page."""
    rows = [
        f"<tr><td>{start}</td><td>{end - 1}</td><td>{end - start}</td><td>{_extreme(judged, start, end)}</td></tr>"
        for start, end in judged.losses
    ]
    page = _PAGE.format(
        method=escape(judged.method),
        verdict=escape(judged.verdict),
        frames=len(judged),
        meaning="the score is the probability that the target is lost" if judged.is_probability else "scores of the method",
        extreme="smallest" if judged.high_is_good else "largest",
        width=_WIDTH,
        height=_HEIGHT,
        chart=_chart(judged),
        rows="".join(rows),
    )
    Path(path).write_text(page, encoding="utf-8")


def _extreme(judged: Judged, start: int, end: int) -> str:
    """The score that speaks loudest for the loss."""
    part = judged.score[start:end]
    part = part[np.isfinite(part)]
    if not part.size:
        return ""
    return f"{part.min() if judged.high_is_good else part.max():.3g}"


def _chart(judged: Judged) -> str:
    """The scores as lines over the shaded losses."""
    known = judged.score[np.isfinite(judged.score)]
    levels = known if judged.threshold is None else np.append(known, judged.threshold)
    low, high = (0.0, 1.0) if judged.is_probability or not levels.size else (float(levels.min()), float(levels.max()))
    span = high - low or 1.0
    wide = _WIDTH / max(len(judged), 1)

    def y(value: float) -> float:
        return _HEIGHT - 5 - (_HEIGHT - 10) * (value - low) / span

    parts = [
        f'<rect x="{start * wide:.1f}" width="{(end - start) * wide:.1f}" height="{_HEIGHT}" fill="#f4c7c3"/>'
        for start, end in judged.losses
    ]
    if judged.threshold is not None:
        level = f"{y(judged.threshold):.1f}"
        parts.append(f'<path d="M0 {level}H{_WIDTH}" stroke="#888" stroke-dasharray="6 4"/>')
    step, line = "M", []
    for t, value in enumerate(judged.score.tolist()):
        if not np.isfinite(value):
            step = "M"
            continue
        line.append(f"{step}{(t + 0.5) * wide:.1f} {y(value):.1f}")
        step = "L"
    parts.append(f'<path d="{"".join(line)}" fill="none" stroke="#1f4e99" stroke-width="1.5"/>')
    return "".join(parts)
