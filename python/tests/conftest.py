"""Flights and the command that the tests compare with."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import List

import pytest

import hovernav as hn

ROOT = Path(__file__).resolve().parents[2]
FLIGHT = ROOT / "datasets" / "heli-hover"

# The settings of that flight.
CONFIG = {
    "imu": {
        "lever_arm_m": [0.03, -0.02, 0.28],
        "angle_random_walk_deg_per_sqrt_h": 2.25,
        "velocity_random_walk_mps_per_sqrt_h": 0.45,
        "gyro_bias_sigma_degps": 0.25,
        "accel_bias_sigma_mps2": 0.09,
        "magnetic_declination_deg": 0.42,
        "gyro_range_degps": 200.0,
        "accel_range_g": 4.0,
    },
    "gps": {"antenna_lever_arm_m": [-0.35, 0.0, 0.2]},
}


def sets() -> List[Path]:
    """The included flight, and two more where the shared sets are."""
    shared = ROOT.parent / "shared" / "datasets"
    more = [shared / name for name in ["quad-hover-aided", "quad-ardupilot-5hz"]]
    missing = [flight for flight in more if not flight.is_dir()]
    if missing and os.environ.get("HOVERNAV_STRICT") == "1":
        raise FileNotFoundError(f"expected the shared sets: {missing}")
    return [FLIGHT, *(flight for flight in more if flight not in missing)]


@pytest.fixture(scope="session")
def command() -> Path:
    """The command `hovernav`: from HOVERNAV_COMMAND, or built by cargo."""
    given = os.environ.get("HOVERNAV_COMMAND")
    if given:
        return Path(given)
    options = ["--quiet", "--no-default-features", "--features", "formats,lab"]
    target = ROOT / "target" / "python" / "command"
    build = ["cargo", "build", "-p", "hovernav-cli", *options, "--target-dir", str(target)]
    subprocess.run(build, cwd=ROOT, check=True)
    return target / "debug" / "hovernav"


@pytest.fixture(scope="session")
def log() -> hn.Log:
    return hn.read(FLIGHT)


@pytest.fixture(scope="session")
def solution(log: hn.Log) -> hn.Solution:
    return hn.estimate(log)


@pytest.fixture(scope="session")
def model() -> hn.Model:
    return hn.Model.open("raptor60")


@pytest.fixture(scope="session")
def autopilot(model: hn.Model) -> hn.Autopilot:
    return hn.design(model)
