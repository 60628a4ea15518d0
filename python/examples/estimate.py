"""Estimate a log, print its findings and its speed, and compare with a smoothed solution.

usage: python estimate.py LOG
"""

from __future__ import annotations

import sys

import numpy as np

import hovernav as hn


def main(path: str) -> None:
    log = hn.read(path)
    print(log)
    solution = hn.estimate(log)
    for finding in solution.findings:
        print(f"{finding.start_s:8.1f} s  {finding.severity}: {finding.words}")
    speed_mps = np.linalg.norm(solution.velocity_ned_mps, axis=1)
    print(f"speed: {speed_mps.mean():.2f} m/s on average, {speed_mps.max():.2f} m/s at most")
    smoothed = hn.estimate(log, smooth=True)
    difference = solution.score(smoothed)["error"]["vn_mps"]
    print(f"smoothing changes the velocity north by {difference['rmse']:.3f} m/s rms")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        main(sys.argv[1])
    except hn.Error as error:
        sys.exit(f"estimate.py: {error}")
