"""Campaigns: the flights of the command, on one machine."""

from __future__ import annotations

import copy
import os
import pickle
import signal
import subprocess
import threading
from pathlib import Path
from typing import List, Tuple

import numpy as np
import pytest

import hovernav as hn


def test_a_campaign_is_the_commands_to_the_byte(
    command: Path, tmp_path: Path, model: hn.Model, autopilot: hn.Autopilot
) -> None:
    autopilot.write(tmp_path / "autopilot.toml")
    options = ["--autopilot", tmp_path / "autopilot.toml", "--flights", 40, "--seed", 7]
    options += ["--duration", 30, "--wind", 8, "--jams", 0.3, "--power-loss", 0.1]
    arguments = ["campaign", *options, "--out", tmp_path / "theirs"]
    subprocess.run([str(command), *map(str, arguments)], capture_output=True, check=True)
    done: List[Tuple[int, int]] = []
    flown = hn.campaign(
        model,
        autopilot,
        flights=40,
        seed=7,
        duration_s=30,
        wind_mps=8,
        jams=0.3,
        power_loss=0.1,
        progress=lambda *now: done.append(now),
    )
    flown.write(tmp_path / "ours")
    for name in ["results.csv", "percentiles.csv", "report.html"]:
        ours, theirs = tmp_path / "ours" / name, tmp_path / "theirs" / name
        assert ours.read_bytes() == theirs.read_bytes(), name
    assert done[0] == (0, 40) and done[-1] == (40, 40)
    assert len(flown) == sum(flown.outcomes.values()) == 40
    table = flown.table()
    assert list(table) == (tmp_path / "ours" / "results.csv").read_text().split("\n")[0].split(",")
    assert table["seed"].tolist() == list(range(7, 47))
    assert set(table["sensors"]) <= {"thesis", "modern", "poor"}
    known = table["u_rms_mps"][np.isfinite(table["u_rms_mps"])]
    assert flown.percentiles["u_rms_mps"]["p50"] == pytest.approx(np.median(known), rel=1e-12)
    assert flown.frame()["outcome"].value_counts().sum() == 40


def test_a_model_and_an_autopilot_can_be_pickled(
    tmp_path: Path, model: hn.Model, autopilot: hn.Autopilot
) -> None:
    again, gains = pickle.loads(pickle.dumps((model, autopilot)))
    assert np.array_equal(again.a, model.a) and repr(copy.copy(again)) == repr(model)
    gains.write(tmp_path / "again.toml")
    autopilot.write(tmp_path / "first.toml")

    def settings(name: str) -> List[str]:
        lines = (tmp_path / name).read_text().splitlines()
        return [line for line in lines if not line.startswith("#")]

    assert settings("again.toml") == settings("first.toml")


def test_impossible_campaigns_are_refused(model: hn.Model, autopilot: hn.Autopilot) -> None:
    for name, value in {
        "flights": 0,
        "duration_s": 29.0,
        "wind_mps": float("nan"),
        "outages": 1.1,
        "jams": -0.1,
        "fuel_kg": float("inf"),
    }.items():
        with pytest.raises(hn.ConfigError, match=name):
            hn.campaign(model, autopilot, **{name: value})  # type: ignore[arg-type]


def test_an_interrupt_ends_a_campaign(model: hn.Model, autopilot: hn.Autopilot) -> None:
    # A shell ignores interrupts of a program in its background.
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        hn.campaign(model, autopilot, flights=1_000_000)
    signal.signal(signal.SIGINT, handler)
