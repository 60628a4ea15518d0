"""From a flight to a model, an autopilot and its flights."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import List

import numpy as np
import pytest
from conftest import FLIGHT

import hovernav as hn


def test_a_model_is_the_commands(command: Path, tmp_path: Path) -> None:
    out = tmp_path / "identified"
    options = ["--model", "yaw", "--no-report", "--out", str(out)]
    # Its exit status is 1 for a model that must not be flown.
    subprocess.run([str(command), "identify", str(FLIGHT), *options], capture_output=True)
    model = hn.identify(FLIGHT, structure="yaw")
    model.write(tmp_path / "model.toml")
    assert (tmp_path / "model.toml").read_text() == (out / "model.toml").read_text()
    assert model.states == ["r"] and model.a.shape == (1, 1) and model.b.shape == (1, 2)
    assert model.verdict in {"good", "care", "do not fly"}
    assert len(model.parameters) > 2
    again = hn.Model.open(tmp_path / "model.toml")
    assert np.array_equal(again.a, model.a) and again.reasons == model.reasons


def test_a_model_is_one_of_python_control() -> None:
    model = hn.Model.open("raptor60")
    control = model.to_control()
    assert np.array_equal(control.A, model.a) and np.array_equal(control.B, model.b)
    assert np.array_equal(control.C, model.c) and np.array_equal(control.D, model.d)
    assert control.state_labels == model.states and control.input_labels == model.inputs
    assert control.output_labels == model.outputs and control.dt == 0
    assert "ss(A, B, C, D)" in model.to_matlab()


def test_an_autopilot_is_the_commands(
    command: Path, tmp_path: Path, autopilot: hn.Autopilot
) -> None:
    arguments = ["design", "raptor60", "--no-report", "--out", str(tmp_path)]
    subprocess.run([str(command), *arguments], capture_output=True, check=True)
    autopilot.write(tmp_path / "mine.toml")

    def settings(name: str) -> List[str]:
        lines = (tmp_path / name).read_text().splitlines()
        return [line for line in lines if not line.startswith("#")]

    assert settings("mine.toml") == settings("autopilot.toml")
    assert hn.Autopilot.open(tmp_path / "mine.toml").period_s == autopilot.period_s


def test_a_simulated_flight_is_the_commands(
    command: Path, tmp_path: Path, autopilot: hn.Autopilot
) -> None:
    autopilot.write(tmp_path / "autopilot.toml")
    out = tmp_path / "flown"
    options = ["--autopilot", tmp_path / "autopilot.toml", "--duration", 60, "--seed", 7]
    arguments = ["simulate", *options, "--no-report", "--out", out]
    subprocess.run([str(command), *map(str, arguments)], capture_output=True, check=True)
    theirs, ours = hn.read(out), hn.simulate(autopilot, duration_s=60, seed=7)
    for name, column in theirs.imu.items():
        assert np.array_equal(column, ours.imu[name], equal_nan=True), name
    solution = hn.estimate(ours)
    assert solution.summary["error"]["vn_mps"]["rmse"] < 0.3
    other = hn.simulate(autopilot, duration_s=60, seed=8)
    assert not np.array_equal(other.imu["gyro_x_radps"], ours.imu["gyro_x_radps"])


def test_what_is_not_possible_is_refused(log: hn.Log, autopilot: hn.Autopilot) -> None:
    with pytest.raises(hn.ModelError, match="no-such-model"):
        hn.Model.open("no-such-model")
    with pytest.raises(hn.ConfigError, match="structure"):
        hn.identify(log, structure="wings")
    without = hn.Log.from_arrays(log.imu, log.gps, axes="frd")
    with pytest.raises(hn.ModelError, match="found no sticks"):
        hn.identify(without)
    with pytest.raises(hn.ConfigError, match="duration_s"):
        hn.simulate(autopilot, duration_s=float("nan"))
    with pytest.raises(hn.ConfigError, match="sensors"):
        hn.simulate(autopilot, sensors="best")
    with pytest.raises(hn.ConfigError, match="start"):
        hn.simulate(autopilot, start=(91.0, 0.0, 0.0))
    with pytest.raises(hn.ConfigError, match="test_points"):
        hn.simulate(autopilot, test_points=3.0)
    with pytest.raises(TypeError):
        hn.design("raptor60")  # type: ignore[arg-type]
