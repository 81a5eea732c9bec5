"""The Python of the documents runs, unless a comment says why not."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import CHECKOUT

BLOCK = re.compile(r"^(<!-- not-run: [^\n]+ -->\n)?```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("document", ["python/README.md", "docs/python.md"])
def test_blocks_run(document: str, tmp_path: Path) -> None:
    blocks = BLOCK.findall((CHECKOUT / document).read_text(encoding="utf-8"))
    texts = [text for comment, text in blocks if not comment]
    assert texts
    for text in texts:
        ran = subprocess.run([sys.executable, "-c", text], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, f"{text}\n{ran.stderr}"
