"""Every snippet of docs/python.md runs, in order."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Dict

import numpy as np
import pytest
from conftest import ROOT


def test_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "docs" / "python.md").read_text()
    snippets = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(snippets) >= 7
    (tmp_path / "datasets").symlink_to(ROOT / "datasets")
    monkeypatch.chdir(tmp_path)
    names: Dict[str, Any] = {}
    for snippet in snippets:
        exec(compile(snippet, "docs/python.md", "exec"), names)
    assert names["smoothed"].is_smoothed
    assert np.abs(names["still"].velocity_ned_mps[-1]).max() < 0.1
    assert "axes forward, left, up" in capsys.readouterr().out
    assert abs(names["estimator"].solution.attitude_deg[2] - 45.0) < 1.0
    assert len(names["found"]) == 2
