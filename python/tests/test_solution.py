"""What a solution gives."""

from __future__ import annotations

from pathlib import Path
from typing import List

import numpy as np
import pytest
from conftest import FLIGHT

import hovernav as hn


def test_arrays_a_frame_and_single_states_have_the_same_numbers(solution: hn.Solution) -> None:
    frame, count = solution.frame(), len(solution)
    assert list(frame.columns) == list(solution.table()) and len(frame) == count
    for name, columns in {
        "velocity_ned_mps": ["vn_mps", "ve_mps", "vd_mps"],
        "velocity_body_mps": ["u_mps", "v_mps", "w_mps"],
        "attitude_deg": ["roll_deg", "pitch_deg", "yaw_deg"],
        "angular_rate_radps": ["p_radps", "q_radps", "r_radps"],
        "position_sigma_m": ["sigma_n_m", "sigma_e_m", "sigma_d_m"],
        "velocity_sigma_mps": ["sigma_vn_mps", "sigma_ve_mps", "sigma_vd_mps"],
        "attitude_sigma_deg": ["sigma_roll_deg", "sigma_pitch_deg", "sigma_yaw_deg"],
        "gyro_bias_radps": [f"gyro_bias_{axis}_radps" for axis in "xyz"],
        "accel_bias_mps2": [f"accel_bias_{axis}_mps2" for axis in "xyz"],
    }.items():
        rows = getattr(solution, name)
        assert rows.shape == (count, 3)
        assert np.array_equal(rows, frame[columns].to_numpy())
        assert np.array_equal(getattr(solution[-1], name), rows[-1])
    for name, column in {
        "time_s": "t_s",
        "latitude_deg": "lat_deg",
        "longitude_deg": "lon_deg",
        "height_m": "height_m",
    }.items():
        assert np.array_equal(getattr(solution, name), frame[column].to_numpy())
        assert getattr(solution[7], name) == getattr(solution, name)[7]
    assert solution.quaternion.shape == (count, 4)
    assert np.allclose(np.linalg.norm(solution.quaternion, axis=1), 1.0)
    assert np.array_equal(solution[3].quaternion, solution.quaternion[3])
    with pytest.raises(ValueError):
        solution.time_s[0] = 0.0
    with pytest.raises(IndexError):
        solution[count]
    assert len(list(solution)) == count


def test_the_body_velocity_is_the_turned_velocity(solution: hn.Solution) -> None:
    w, x, y, z = solution.quaternion[1000]
    to_ned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    assert np.allclose(to_ned @ solution.velocity_body_mps[1000], solution.velocity_ned_mps[1000])


def test_the_covariance_has_the_solutions_sigmas(solution: hn.Solution) -> None:
    for row in [0, 1000, len(solution) - 1]:
        covariance = solution.covariance(float(solution.time_s[row]))
        assert covariance.shape == (9, 9)
        assert np.allclose(covariance, covariance.T, rtol=1e-9, atol=1e-15)
        assert np.linalg.eigvalsh(covariance).min() > 0.0
        state = solution[row]
        sigmas = np.concatenate(
            [
                state.position_sigma_m,
                state.velocity_sigma_mps,
                np.radians(state.attitude_sigma_deg),
            ]
        )
        assert np.allclose(np.sqrt(np.diag(covariance)), sigmas, rtol=1e-9)
    # Between two samples it is that of the earlier one.
    between = float(solution.time_s[10:12].mean())
    assert np.array_equal(
        solution.covariance(between), solution.covariance(float(solution.time_s[10]))
    )
    with pytest.raises(hn.ArrayError, match="expected a time from"):
        solution.covariance(float(solution.time_s[0]) - 1.0)
    with pytest.raises(hn.ArrayError, match="seconds"):
        solution.covariance(float("nan"))


def test_findings_name_sensor_time_and_cause() -> None:
    solution = hn.estimate(hn.inject(FLIGHT, "outage=20@100"))
    outages = [finding for finding in solution.findings if finding.sensor == "gps"]
    assert outages and all(finding.start_s <= finding.end_s for finding in outages)
    assert all(finding.severity in {"info", "warning", "error"} for finding in solution.findings)
    assert any(finding.words in solution.summary["warnings"] for finding in outages)


def test_smoothing_brings_the_errors_down() -> None:
    causal, smoothed = hn.estimate(FLIGHT), hn.estimate(FLIGHT, smooth=True)
    for axis in ["vn_mps", "ve_mps", "horizontal_m"]:
        errors = [one.score(FLIGHT)["error"][axis]["rmse"] for one in (causal, smoothed)]
        assert errors[1] < errors[0], axis
    assert smoothed.score(causal)["error"]["vn_mps"]["rmse"] > 0.0
    with pytest.raises(hn.ArrayError, match="smooth"):
        smoothed.covariance(100.0)


def test_progress_rises_to_the_number_of_samples(log: hn.Log) -> None:
    seen = []
    hn.estimate(log, progress=lambda done, total: seen.append((done, total)))
    count = len(log.imu["t_s"])
    assert seen[-1] == (count, count) and seen == sorted(seen)

    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hn.estimate(log, progress=stop)


def test_a_log_is_unchanged_by_its_estimation(log: hn.Log, solution: hn.Solution) -> None:
    again = hn.estimate(log)
    assert np.array_equal(again.velocity_ned_mps, solution.velocity_ned_mps)
    assert again.summary["notes"] == solution.summary["notes"]


def test_a_log_is_written_and_read_back(log: hn.Log, tmp_path: Path) -> None:
    log.write(tmp_path / "copy")
    copy = hn.read(tmp_path / "copy")
    assert np.array_equal(copy.imu["gyro_x_radps"], log.imu["gyro_x_radps"])
    assert list(copy.gps) == list(log.gps)


def test_a_smoothing_can_be_ended_in_its_backward_part(log: hn.Log) -> None:
    calls: List[int] = []

    def progress(done: int, total: int) -> None:
        calls.append(done)
        if len(calls) > 1 and done < calls[-2]:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hn.estimate(log, smooth=True, progress=progress)
    # Forward over all samples, then the first step backward.
    assert calls == [4096, 8192, 4096]
