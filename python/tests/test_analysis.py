"""Scores, faults, the Allan deviation, and rejected input."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any, List

import numpy as np
import pytest
from conftest import FLIGHT

import hovernav as hn


def test_white_noise_has_its_density_as_allan_deviation() -> None:
    density, rate_hz = 0.02, 100.0
    noise = np.random.default_rng(1).normal(0.0, density * np.sqrt(rate_hz), 200_000)
    table = hn.allan(noise, rate_hz=rate_hz)
    short = table["tau_s"] < 20.0
    expected = density / np.sqrt(table["tau_s"][short])
    assert np.allclose(table["deviation"][short], expected, rtol=0.2)


def test_an_allan_deviation_of_a_log_has_every_axis(log: hn.Log) -> None:
    table = hn.allan(log)
    assert list(table)[:2] == ["tau_s", "gyro_x_radps"] and len(table) == 7
    one = hn.allan(log.imu["accel_z_mps2"], rate_hz=1.0)
    assert np.allclose(one["deviation"], table["accel_z_mps2"])


@pytest.mark.parametrize(
    ("readings", "rate_hz", "words"),
    [
        ([], 1.0, "found 0, expected at least 2"),
        ([1.0, np.nan], 1.0, "row 1"),
        ([1.0, 2.0], None, "found no rate"),
        ([1.0, 2.0], -1.0, "found no rate"),
        (np.zeros((3, 3)), 1.0, "expected \\(n,\\)"),
        (None, 1.0, "readings"),
    ],
)
def test_readings_without_a_deviation_are_refused(readings: Any, rate_hz: Any, words: str) -> None:
    with pytest.raises(hn.ArrayError, match=words):
        hn.allan(readings, rate_hz=rate_hz)


def test_a_fault_changes_its_sensor_in_its_time_only(log: hn.Log) -> None:
    faulty = hn.inject(log, "glitch-step=60@100:15")
    t_s = log.gps["t_s"]
    moved = np.abs(faulty.gps["lat_deg"] - log.gps["lat_deg"]) > 1e-9
    moved |= np.abs(faulty.gps["lon_deg"] - log.gps["lon_deg"]) > 1e-9
    assert moved.any() and (t_s[moved] >= 100.0).all() and (t_s[moved] <= 115.0).all()
    assert np.array_equal(faulty.imu["gyro_x_radps"], log.imu["gyro_x_radps"])


def test_what_cannot_be_done_is_refused(log: hn.Log, solution: hn.Solution, tmp_path: Path) -> None:
    nothing = tmp_path / "nothing.ulg"
    with pytest.raises(hn.LogError, match="nothing.ulg"):
        hn.read(nothing)
    with pytest.raises(hn.LogError, match="nothing.ulg"):
        hn.estimate(str(nothing))
    (tmp_path / "text.ulg").write_bytes(b"\x00\x01garbage" * 50)
    with pytest.raises(hn.LogError, match="text.ulg"):
        hn.read(tmp_path / "text.ulg")
    with pytest.raises(hn.FaultError, match="no-such-fault"):
        hn.inject(log, "no-such-fault")
    with pytest.raises(hn.FaultError):
        hn.inject(log, ["glitch-step=60@100000:15"])
    with pytest.raises(TypeError):
        hn.inject(log, 7)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="expected a Log or a path"):
        hn.estimate(7)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="expected a Solution or a path"):
        solution.score(log)  # type: ignore[arg-type]
    with pytest.raises(hn.LogError):
        solution.score(tmp_path)
    with pytest.raises(hn.ConfigError, match="gps_rate_hz"):
        hn.estimate(log, gps_rate_hz=-1.0)
    with pytest.raises(hn.ConfigError, match="outages"):
        hn.estimate(log, outages=[(10.0, -1.0)])
    with pytest.raises(hn.ConfigError, match="no_such_setting"):
        hn.estimate(log, config={"filter": {"gps": {"no_such_setting": 1.0}}})
    with pytest.raises(hn.ConfigError, match="missing.toml"):
        hn.estimate(log, config=tmp_path / "missing.toml")
    with pytest.raises(hn.ConfigError, match="enu or ned"):
        hn.score(solution, solution, axes="xyz")
    for error in (hn.ArrayError, hn.ConfigError, hn.FaultError, hn.LogError, hn.SetupError):
        assert issubclass(error, hn.Error)


def test_threads_give_the_same_solution(log: hn.Log, solution: hn.Solution) -> None:
    found: List[hn.Solution] = []
    threads = [threading.Thread(target=lambda: found.append(hn.estimate(log))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    for one in found:
        assert np.array_equal(one.frame().to_numpy(), solution.frame().to_numpy())


def test_an_estimator_may_be_shared_by_threads() -> None:
    estimator = hn.Estimator()
    t_s = 0.01 * np.arange(20_000)
    gyro, accel = np.zeros((20_000, 3)), np.tile([0.0, 0.0, -9.81], (20_000, 1))
    batch = threading.Thread(target=lambda: estimator.imu_batch(t_s, gyro, accel))
    batch.start()
    while batch.is_alive():
        assert estimator.solution is None
        estimator.baro(0.0, 1.0)
    batch.join()


def test_a_written_copy_keeps_its_reference(log: hn.Log, tmp_path: Path) -> None:
    faulty = hn.inject(log, "gyro-bias=0.5", seed=2)
    faulty.write(tmp_path / "copy")
    own = hn.estimate(faulty).summary["error"]
    # Angles are written in degrees and read back to within rounding.
    near = {axis: pytest.approx(sizes, rel=1e-6) for axis, sizes in own.items()}
    assert hn.estimate(tmp_path / "copy").summary["error"] == near
    again = hn.read(tmp_path / "copy")
    again.write(tmp_path / "copy")
    assert hn.estimate(tmp_path / "copy").summary["error"] == near
