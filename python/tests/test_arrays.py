"""Arrays of one's own."""

from __future__ import annotations

from typing import Any, Dict, List

import numpy as np
import pytest
from conftest import CONFIG

import hovernav as hn


def tables(log: hn.Log) -> Dict[str, Any]:
    return {"imu": log.imu, "gps": log.gps, "axes": "frd"}


def test_a_logs_own_tables_make_the_same_solution(log: hn.Log, solution: hn.Solution) -> None:
    tables: List[Any] = [log.imu, log.imu.frame()]
    for imu in tables:
        copy = hn.Log.from_arrays(imu, log.gps, axes="frd", config=CONFIG)
        again = hn.estimate(copy)
        assert len(again) == len(solution)
        # Attitudes in degrees and back have another last bit.
        assert np.allclose(again.velocity_ned_mps, solution.velocity_ned_mps, atol=1e-9)


def grouped(log: hn.Log, names: Dict[str, str], table: str) -> Dict[str, Any]:
    columns = getattr(log, table)
    return {
        group: np.column_stack([columns[name.format(axis)] for axis in "xyz"])
        for group, name in names.items()
    }


def test_three_columns_may_be_one_array_and_other_axes_are_turned(log: hn.Log) -> None:
    names = {"gyro_radps": "gyro_{}_radps", "accel_mps2": "accel_{}_mps2"}
    imu = {"t_s": log.imu["t_s"], **grouped(log, names, "imu")}
    plain = hn.Log.from_arrays(imu, log.gps, axes="frd")
    for name in ["gyro_y_radps", "accel_z_mps2"]:
        assert np.array_equal(plain.imu[name], log.imu[name])
    flipped = {name: imu[name] * [1.0, -1.0, -1.0] for name in names}
    flu = hn.Log.from_arrays({**imu, **flipped}, log.gps, axes="flu")
    for name in plain.imu:
        assert np.array_equal(flu.imu[name], plain.imu[name]), name


def test_wrong_axes_are_named_before_the_estimation(log: hn.Log) -> None:
    wrong = hn.Log.from_arrays(log.imu, log.gps, axes="flu")
    with pytest.raises(hn.SetupError, match="axes|upside|gravity"):
        hn.estimate(wrong)


def test_degrees_a_second_are_named_before_the_estimation(log: hn.Log) -> None:
    imu = dict(log.imu)
    for axis in "xyz":
        imu[f"gyro_{axis}_radps"] = np.degrees(imu[f"gyro_{axis}_radps"])
    with pytest.raises(hn.SetupError, match="°/s|degps"):
        hn.estimate(hn.Log.from_arrays(imu, log.gps, axes="frd"))


def changed(table: Any, column: str, row: int, value: float) -> Dict[str, Any]:
    copy = {name: np.array(values) for name, values in table.items()}
    copy[column][row] = value
    return copy


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        ("t_s", np.nan, "imu: row 5, column t_s: found NaN, expected seconds"),
        ("t_s", 0.0, "imu: row 5, column t_s: found 0, expected a time after"),
        ("gyro_x_radps", np.nan, "imu: row 5: a value is missing"),
        ("accel_x_mps2", np.inf, "imu: row 5: a value is beyond any vehicle's motion"),
        ("mag_x_gauss", 210.0, "imu: row 5: magnetic field"),
    ],
)
def test_a_bad_row_is_named(log: hn.Log, column: str, value: float, words: str) -> None:
    imu = changed(log.imu, column, 5, value)
    with pytest.raises(hn.ArrayError) as error:
        hn.Log.from_arrays(imu, log.gps, axes="frd")
    assert words in str(error.value)


def test_a_fix_without_a_position_is_skipped_and_reported(log: hn.Log) -> None:
    copy = hn.Log.from_arrays(log.imu, changed(log.gps, "lat_deg", 3, np.nan), axes="frd")
    assert len(copy.gps["t_s"]) == len(log.gps["t_s"]) - 1
    assert any("a coordinate is missing" in warning for warning in copy.warnings)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"imu": {}}, "imu: found no column t_s"),
        ({"imu": 7}, "imu: found <class 'int'>"),
        ({"imu": {"t_s": [0.0, 0.1]}}, "imu: found no column gyro_radps"),
        ({"imu": {"t_s": [0.0], "gyro_x_degps": [0.0]}}, "imu: found column gyro_x_degps"),
        (
            {"imu": {"t_s": [0.0, 0.1], "gyro_radps": np.zeros((2, 2))}},
            "imu: column gyro_radps: found shape (2, 2), expected (n, 3)",
        ),
        (
            {"imu": {"t_s": [0.0, 0.1], "gyro_radps": np.zeros((3, 3))}},
            "imu: column gyro_radps: found 3 values, expected 2",
        ),
        ({"imu": {"t_s": np.zeros((2, 2))}}, "found shape (2, 2), expected (n,)"),
        ({"imu": {"t_s": ["a", "b"]}}, "expected numbers: found values of type <U1"),
        ({"imu": {"t_s": [0.0], "gyro_x_radps": [0.0]}}, "found no column gyro_y_radps"),
        ({"gps": {"t_s": [1.0], "lat_deg": [48.0]}}, "gps: found no column lon_deg"),
        ({"imu": {"t_s": [0.0], "gyro_radps": np.zeros((1, 3), complex)}}, "type complex128"),
        ({"imu": {"t_s": ["1.5"]}}, "found values of type <U3"),
        ({"imu": {"t_s": np.array(["2025-01-01"], "datetime64[s]")}}, "type datetime64[s]"),
        (
            {"imu": {"t_s": [0.0], "gyro_radps": np.zeros((1, 3)), "gyro_x_radps": [0.0]}},
            "found columns gyro_radps and gyro_x_radps",
        ),
        (
            {"imu": {"t_s": [0.0], "gyro_radps": np.zeros((1, 3)), "dtheta_rad": np.zeros((1, 3))}},
            "found rates and increments",
        ),
        ({"baro": {"t_s": [1.0], "altitude_m": [np.nan]}}, "baro: row 0"),
        ({"controls": {"t_s": [1.0]}}, "controls: found no column lateral"),
    ],
)
def test_a_bad_table_is_named(log: hn.Log, change: Dict[str, Any], words: str) -> None:
    with pytest.raises(hn.ArrayError) as error:
        hn.Log.from_arrays(**{**tables(log), **change})
    assert words in str(error.value)


def test_masked_values_are_missing_ones(log: hn.Log) -> None:
    x = log.imu["gyro_x_radps"]
    masked = np.ma.masked_array(x, mask=np.arange(len(x)) == 7)
    with pytest.raises(hn.ArrayError, match="row 7: a value is missing"):
        hn.Log.from_arrays({**log.imu, "gyro_x_radps": masked}, log.gps, axes="frd")


def test_the_tables_of_a_log_are_read_only(log: hn.Log) -> None:
    with pytest.raises(ValueError, match="read-only"):
        log.imu["gyro_x_radps"][0] = 1.0


def test_axes_are_required_and_checked(log: hn.Log) -> None:
    with pytest.raises(TypeError, match="axes"):
        hn.Log.from_arrays(log.imu, log.gps)  # type: ignore[call-arg]
    with pytest.raises(hn.ConfigError, match="right-handed"):
        hn.Log.from_arrays(log.imu, log.gps, axes="fru")


def test_empty_arrays_are_refused_when_estimated() -> None:
    empty = np.zeros(0)
    imu = {"t_s": empty, "gyro_radps": np.zeros((0, 3)), "accel_mps2": np.zeros((0, 3))}
    gps = {"t_s": empty, "lat_deg": empty, "lon_deg": empty, "height_m": empty}
    log = hn.Log.from_arrays(imu, gps, axes="frd")
    assert len(log.imu["t_s"]) == 0 and "0 inertial samples" in repr(log)
    with pytest.raises(hn.LogError, match="found no inertial samples"):
        hn.estimate(log)
