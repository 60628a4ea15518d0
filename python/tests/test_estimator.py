"""The estimator, sample by sample."""

from __future__ import annotations

from typing import Any, Iterator, List, Optional, Set, Tuple

import numpy as np
import pytest
from conftest import CONFIG

import hovernav as hn


def events(log: hn.Log) -> Iterator[Tuple[float, int, int]]:
    """Time, kind (0 for a sample, 1 for a fix) and row, in order of arrival; a sample goes first."""
    kinds = [(log.imu["t_s"], 0), (log.gps["t_s"], 1)]
    return iter(sorted((t, kind, row) for times, kind in kinds for row, t in enumerate(times)))


def columns(table: hn.Table, *names: str) -> Any:
    return np.column_stack([table[name] for name in names])


def test_a_flight_fed_one_by_one_is_the_whole_one(log: hn.Log, solution: hn.Solution) -> None:
    imu, gps = log.imu, log.gps
    gyro = columns(imu, "gyro_x_radps", "gyro_y_radps", "gyro_z_radps")
    accel = columns(imu, "accel_x_mps2", "accel_y_mps2", "accel_z_mps2")
    attitude = columns(imu, "roll_deg", "pitch_deg", "yaw_deg")
    field = columns(imu, "mag_x_gauss", "mag_y_gauss", "mag_z_gauss")
    velocity = columns(gps, "vn_mps", "ve_mps", "vd_mps")
    position_sigma = columns(gps, "sigma_n_m", "sigma_e_m", "sigma_d_m")
    velocity_sigma = columns(gps, "sigma_vn_mps", "sigma_ve_mps", "sigma_vd_mps")
    estimator = hn.Estimator(CONFIG)
    assert estimator.solution is None
    kinds: Set[str] = set()
    states: List[Optional[hn.State]] = []
    fixes = 0
    for t, kind, row in events(log):
        if kind == 0:
            notices = estimator.imu(
                t, gyro[row], accel[row], attitude_deg=attitude[row], mag_gauss=field[row]
            )
            states.append(estimator.solution)
        else:
            notices = estimator.gps(
                t,
                gps["lat_deg"][row],
                gps["lon_deg"][row],
                gps["height_m"][row],
                velocity_mps=velocity[row],
                position_sigma_m=position_sigma[row],
                velocity_sigma_mps=velocity_sigma[row],
            )
        kinds.update(notice.kind for notice in notices)
        fixes += sum(bool(notice.accepted) and "position" in notice.words for notice in notices)
    assert {"aligned", "updated"} <= kinds
    assert fixes == pytest.approx(solution.summary["gps_fixes_used"], abs=2)
    found = [state for state in states if state is not None]
    assert len(found) == len(solution)
    # Attitudes in degrees and back have another last bit.
    speeds = np.array([state.velocity_ned_mps for state in found])
    assert np.allclose(speeds, solution.velocity_ned_mps, atol=1e-6)


def at_rest(count: int) -> Tuple[Any, Any, Any]:
    noise = np.random.default_rng(3).normal(0.0, 1e-3, (count, 6))
    return 0.01 * np.arange(count), noise[:, :3], noise[:, 3:] + [0.0, 0.0, -9.81]


def test_a_batch_gives_the_bits_of_single_samples() -> None:
    t, gyro, accel = at_rest(1500)
    one, many = hn.Estimator(), hn.Estimator()
    for estimator in (one, many):
        estimator.gps(0.0, 48.1, 11.6, 520.0)
    table, notices = many.imu_batch(t[:1200], gyro[:1200], accel[:1200])
    more, _ = many.imu_batch(t[1200:], gyro[1200:], accel[1200:])
    rows = []
    for k in range(len(t)):
        one.imu(t[k], tuple(gyro[k]), list(accel[k]))
        state = one.solution
        if state is not None:
            rows.append(state.velocity_ned_mps)
    batch = np.vstack([columns(part, "vn_mps", "ve_mps", "vd_mps") for part in (table, more)])
    assert np.array_equal(batch, np.array(rows).reshape(-1, 3))


def test_other_axes_are_turned() -> None:
    t, gyro, accel = at_rest(300)
    frd, flu = hn.Estimator(), hn.Estimator({"imu": {"axes": "flu"}})
    turned = np.array([1.0, -1.0, -1.0])
    for estimator, sign in ((frd, 1.0), (flu, turned)):
        for k in range(300):
            if k % 100 == 50:
                estimator.gps(t[k], 48.1, 11.6, 520.0)
            estimator.imu(t[k], gyro[k] * sign, accel[k] * sign, attitude_deg=(0, 0, 45))
    assert frd.solution is not None and flu.solution is not None
    assert np.array_equal(frd.solution.attitude_deg, flu.solution.attitude_deg)
    assert abs(frd.solution.attitude_deg[2] - 45.0) < 1.0


def test_a_sample_with_nan_is_refused_with_a_notice() -> None:
    t, gyro, accel = at_rest(300)
    estimator = hn.Estimator()
    for k in range(300):
        if k == 200:
            estimator.gps(t[k], 48.1, 11.6, 520.0)
        estimator.imu(t[k], gyro[k], accel[k], attitude_deg=(0.0, 0.0, 0.0))
    assert estimator.solution is not None
    (notice,) = estimator.imu(3.0, (np.nan, 0, 0), accel[0])
    assert notice.kind == "sample refused" and notice.time_s == 3.0
    (notice,) = estimator.baro(3.0, float("inf"))
    assert notice.accepted is False and "not finite" in notice.words


def test_accelerations_in_g_are_named() -> None:
    t, gyro, accel = at_rest(1200)
    _, notices = hn.Estimator().imu_batch(t, gyro, accel / 9.80665)
    (suspect,) = (notice for notice in notices if notice.kind == "set-up suspect")
    assert "accelerations in g" in suspect.words


def test_wrong_arguments_are_named() -> None:
    estimator = hn.Estimator()
    with pytest.raises(hn.ArrayError, match="gyro_radps: found .*, expected three numbers"):
        estimator.imu(0.0, (0.0, 0.0), (0.0, 0.0, -9.81))
    with pytest.raises(hn.ArrayError, match="accel_mps2"):
        estimator.imu(0.0, (0.0, 0.0, 0.0), None)  # type: ignore[arg-type]
    with pytest.raises(hn.ArrayError, match="time_s: found NaN"):
        estimator.imu(float("nan"), (0.0, 0.0, 0.0), (0.0, 0.0, -9.81))
    with pytest.raises(hn.ArrayError, match="expected a position on Earth"):
        estimator.gps(0.0, 98.0, 11.6, 520.0)
    with pytest.raises(hn.ArrayError, match="found 2 rows, expected 3"):
        estimator.imu_batch([0.0, 0.1, 0.2], np.zeros((2, 3)), np.zeros((3, 3)))
    with pytest.raises(hn.ArrayError, match="expected a time after"):
        estimator.imu_batch([0.0, 0.1, 0.1], np.zeros((3, 3)), np.zeros((3, 3)))
    with pytest.raises(hn.ConfigError, match="imu.lever"):
        hn.Estimator({"imu": {"lever": [0, 0, 0]}})
    with pytest.raises(hn.ConfigError, match="expected a path or a dictionary"):
        hn.Estimator(3)  # type: ignore[arg-type]
    with pytest.raises(hn.ConfigError, match="NaN|nan|JSON"):
        hn.Estimator({"gps": {"latency_s": float("nan")}})
    with pytest.raises(hn.ConfigError):
        hn.Estimator({"gps": {"latency_s": None}})
    with pytest.raises(hn.ConfigError):
        hn.Estimator({"filter": {"gps": {"no_such_setting": 1.0}}})
