"""Every snippet of docs/python.md and docs/cluster.md runs, in order."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Dict

import numpy as np
import pytest
from conftest import ROOT


def run(page: str, names: Dict[str, Any]) -> int:
    """Runs the snippets of a page; returns their number."""
    text = (ROOT / "docs" / page).read_text()
    snippets = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    for snippet in snippets:
        exec(compile(snippet, page, "exec"), names)
    return len(snippets)


def test_the_page_of_clusters_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pyarrow")
    (tmp_path / "datasets").symlink_to(ROOT / "datasets")
    monkeypatch.chdir(tmp_path)
    names: Dict[str, Any] = {}
    assert run("cluster.md", names) >= 1
    assert "{'good': 1, 'care': 0, 'bad': 0, 'none': 1}" in capsys.readouterr().out
    assert sum(names["flights"].outcomes.values()) == 100


def test_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "datasets").symlink_to(ROOT / "datasets")
    monkeypatch.chdir(tmp_path)
    names: Dict[str, Any] = {}
    assert run("python.md", names) >= 7
    assert names["smoothed"].is_smoothed
    assert np.abs(names["still"].velocity_ned_mps[-1]).max() < 0.1
    assert "axes forward, left, up" in capsys.readouterr().out
    assert abs(names["estimator"].solution.attitude_deg[2] - 45.0) < 1.0
    assert len(names["found"]) == 2
