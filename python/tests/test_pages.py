"""Pages of solutions, comparisons and campaigns: the files of the command."""

from __future__ import annotations

import html
import re
import subprocess
from pathlib import Path

import pytest
from conftest import FLIGHT

import hovernav as hn


def run(command: Path, *arguments: object) -> str:
    done = subprocess.run([str(command), *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("smooth", [False, True], ids=["causal", "smoothed"])
def test_a_report_is_the_commands_to_the_byte(
    command: Path, tmp_path: Path, smooth: bool
) -> None:
    options = ["--outage", "100:20", "--out", tmp_path / "out", *(["--smooth"] if smooth else [])]
    run(command, "estimate", FLIGHT, *options)
    solution = hn.estimate(FLIGHT, smooth=smooth, outages=[(100, 20)])
    solution.report(tmp_path / "mine.html")
    assert (tmp_path / "mine.html").read_bytes() == (tmp_path / "out" / "report.html").read_bytes()


def test_a_notebook_shows_the_page(solution: hn.Solution, tmp_path: Path) -> None:
    solution.report(tmp_path / "mine.html")
    frame = solution._repr_html_()
    found = re.fullmatch(r'<iframe title="heli-hover" style="[^"]*" srcdoc="([^"]*)"></iframe>', frame)
    assert found is not None
    assert html.unescape(found.group(1)) == (tmp_path / "mine.html").read_text()


def test_a_verdict_is_that_of_the_page(solution: hn.Solution, tmp_path: Path) -> None:
    assert solution.verdict == "good" and solution.reasons == []
    bad = hn.estimate(hn.inject(FLIGHT, "glitch-step=60@100:15", seed=3))
    assert bad.verdict in {"care", "bad"} and bad.reasons
    bad.report(tmp_path / "bad.html")
    page = html.unescape((tmp_path / "bad.html").read_text())
    assert f'class="verdict {bad.verdict}"' in page
    assert all(reason in page for reason in bad.reasons)


def test_a_comparison_is_the_commands(command: Path, tmp_path: Path) -> None:
    run(command, "estimate", FLIGHT, "--no-report", "--out", tmp_path / "causal")
    run(command, "estimate", FLIGHT, "--no-report", "--smooth", "--out", tmp_path / "smoothed")
    run(command, "compare", tmp_path / "causal", tmp_path / "smoothed", "--out", tmp_path / "out")
    both = hn.compare(tmp_path / "causal", tmp_path / "smoothed")
    both.report(tmp_path / "mine.html")
    assert (tmp_path / "mine.html").read_bytes() == (tmp_path / "out" / "report.html").read_bytes()
    (difference,) = both.summary["differences"]
    assert (difference["solution"], difference["less"]) == ("smoothed", "causal")
    assert difference["difference"]["north_m"]["rmse"] > 0.0


def test_solutions_in_memory_are_compared_without_rounding(solution: hn.Solution) -> None:
    smoothed = hn.estimate(FLIGHT, smooth=True)
    both = hn.compare(solution, smoothed, solution)
    names = [one["solution"] for one in both.summary["differences"]]
    assert names == ["heli-hover, smoothed", "heli-hover (3)", "heli-hover (3)"]
    same = both.summary["differences"][1]["difference"]
    assert all(axis["max"] < 1e-5 for axis in same.values()), same
    named = hn.compare(solution, smoothed, names=["mine", "yours"])
    assert repr(named) == "<Comparison of mine, yours>" and "mine and yours" in named._repr_html_()


def test_what_cannot_be_compared_or_written_is_refused(
    solution: hn.Solution, tmp_path: Path
) -> None:
    with pytest.raises(hn.ConfigError, match="found 1, expected 2 to 4"):
        hn.compare(solution)
    with pytest.raises(hn.ConfigError, match="names"):
        hn.compare(solution, solution, names=["one"])
    with pytest.raises(TypeError, match="solutions"):
        hn.compare(solution, 3)  # type: ignore[arg-type]
    with pytest.raises(hn.LogError, match="no-such-file"):
        hn.compare(solution, "no-such-file")
    with pytest.raises(hn.LogError, match="no-such-directory"):
        solution.report(tmp_path / "no-such-directory" / "report.html")
