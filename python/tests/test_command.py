"""Python gives the numbers of the command."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any, Dict, List, Tuple

import numpy as np
import pytest
from conftest import FLIGHT, sets

import hovernav as hn

# Decimals of the columns of solution.csv; the times have nine.
DECIMALS = [9, 10, 10, 4, *[5] * 9, *[7] * 3, *[4] * 3, *[5] * 6, *[8] * 6]
VARIANCES = ["n", "e", "d", "vn", "ve", "vd", "roll", "pitch", "yaw"]


def run(command: Path, *arguments: object) -> str:
    done = subprocess.run([str(command), *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def without_wall(summary: Dict[str, Any]) -> Dict[str, Any]:
    return {key: value for key, value in summary.items() if key != "wall_s"}


@pytest.mark.parametrize("smooth", [False, True], ids=["causal", "smoothed"])
@pytest.mark.parametrize("flight", sets(), ids=lambda flight: flight.name)
def test_a_solution_is_the_commands(
    command: Path, tmp_path: Path, flight: Path, smooth: bool
) -> None:
    options = ["--columns", "covariance", "--no-report", "--out", tmp_path]
    run(command, "estimate", flight, *options, *(["--smooth"] if smooth else []))
    written = np.genfromtxt(tmp_path / "solution.csv", delimiter=",", names=True)
    solution = hn.estimate(flight, smooth=smooth)
    table = solution.table()
    assert len(solution) == len(written) > 1000
    names = list(written.dtype.names or ())
    assert names[: len(table)] == list(table)
    for name, decimals in zip(table, DECIMALS):
        # The file has this many decimals. A turn of 180° may be written with the other sign.
        off = np.abs(table[name] - written[name])
        if name.endswith("_deg") and not name.startswith("sigma"):
            off = np.minimum(off, np.abs(off - 360.0))
        assert off.max() <= 0.50001 * 10.0**-decimals + 1e-15 * np.abs(table[name]).max(), name
    # Variances are written with all digits: the same bits.
    sigmas = np.hstack([solution.position_sigma_m, solution.velocity_sigma_mps])
    for column, name in enumerate(VARIANCES[:6]):
        unit = "m2" if column < 3 else "m2ps2"
        assert np.array_equal(sigmas[:, column] ** 2, written[f"var_{name}_{unit}"])
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert without_wall(solution.summary) == without_wall(summary)
    assert solution.is_smoothed == smooth


def test_outages_rates_and_settings_are_the_commands(command: Path, tmp_path: Path) -> None:
    settings = tmp_path / "mine.toml"
    settings.write_text("[gps]\nantenna_lever_arm_m = [-0.3, 0.0, 0.2]\n[filter.gate]\n")
    options = ["--outage", "100:20", "--gps-rate", "0.5", "--config", settings, "--no-report"]
    run(command, "estimate", FLIGHT, *options, "--out", tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    arm = {"antenna_lever_arm_m": np.array([-0.3, 0.0, 0.2])}
    same: List[Tuple[Any, Any]] = [(settings, (100, 20)), ({"gps": arm}, [100, 20])]
    for config, span in same:
        solution = hn.estimate(FLIGHT, outages=[span], gps_rate_hz=0.5, config=config)
        assert without_wall(solution.summary) == without_wall(summary)


def test_a_score_is_the_commands(
    command: Path, tmp_path: Path, solution: hn.Solution
) -> None:
    run(command, "estimate", FLIGHT, "--no-report", "--out", tmp_path)
    written = json.loads(run(command, "score", tmp_path, FLIGHT, "--json"))
    assert hn.score(tmp_path, FLIGHT) == written
    # The file is rounded, the solution in memory is not.
    own = solution.score(FLIGHT)
    for axis, statistics in written["error"].items():
        assert own["error"][axis]["rmse"] == pytest.approx(statistics["rmse"], abs=1e-3)


def test_a_faulty_copy_is_the_commands(command: Path, tmp_path: Path) -> None:
    faults: List[str] = ["glitch-step=60@100:15", "gyro-bias=0.5"]
    options = [part for fault in faults for part in ("--fault", fault)]
    run(command, "inject", FLIGHT, *options, "--seed", 5, "--out", tmp_path / "faulty")
    theirs, ours = hn.read(tmp_path / "faulty"), hn.inject(FLIGHT, faults, seed=5)
    for table in ["imu", "gps"]:
        for name, column in getattr(theirs, table).items():
            assert np.array_equal(column, getattr(ours, table)[name], equal_nan=True), name
    assert "error" in hn.estimate(ours).summary


def test_a_description_of_a_log_is_the_commands(command: Path, log: hn.Log) -> None:
    printed = json.loads(run(command, "info", FLIGHT, "--json"))
    assert log.info["sensors"] == printed["sensors"]
