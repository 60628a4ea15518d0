"""Fleets and campaigns in shards: without Ray, and on a Ray cluster of two nodes that loses one."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Dict, Iterator, List

import numpy as np
import pytest
from conftest import FLIGHT

import hovernav as hn

pytest.importorskip("pyarrow")


@pytest.fixture(scope="module")
def two_nodes() -> Iterator[Any]:
    """A cluster of two nodes of one core each."""
    pytest.importorskip("ray")
    import ray
    from ray.cluster_utils import Cluster

    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    # Workers import `workers`.
    paths = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
    small = {"num_cpus": 1, "object_store_memory": 100_000_000}
    cluster = Cluster(initialize_head=True, head_node_args={**small, "include_dashboard": False})
    cluster.add_node(**small)
    ray.init(address=cluster.address, log_to_driver=False)
    yield cluster
    ray.shutdown()
    cluster.shutdown()


def partitions(out: Path) -> Dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted((out / "shards").iterdir())}


def test_a_campaign_in_shards_has_the_flights_of_one(
    tmp_path: Path, model: hn.Model, autopilot: hn.Autopilot
) -> None:
    options: Dict[str, Any] = {"flights": 50, "seed": 3, "duration_s": 30.0}
    whole = hn.campaign(model, autopilot, **options)
    steps: List[int] = []
    run = hn.cluster.campaign(
        model,
        autopilot,
        out=tmp_path,
        shard_flights=20,
        engine="local",
        progress=lambda done, total: steps.append(done),
        **options,
    )
    assert (run.shards, run.resumed, run.lost, steps) == (3, 0, [], [0, 1, 2, 3])
    assert run.outcomes == whole.outcomes and run.percentiles == whole.percentiles
    for name, column in whole.table().items():
        ours = run.column(name)
        same = np.array_equal(ours, column, equal_nan=column.dtype.kind == "f")
        assert same, name
    assert json.loads((tmp_path / "summary.json").read_text())["outcomes"] == whole.outcomes


def test_a_run_continues_where_it_ended(
    tmp_path: Path, model: hn.Model, autopilot: hn.Autopilot
) -> None:
    options: Dict[str, Any] = {"flights": 60, "duration_s": 30.0, "shard_flights": 20}
    options["engine"] = "local"

    def interrupt(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        hn.cluster.campaign(model, autopilot, out=tmp_path / "a", progress=interrupt, **options)
    assert len(partitions(tmp_path / "a")) == 2
    # The unfinished file of a killed writer.
    (tmp_path / "a" / "shards" / ".x.part").write_bytes(b"half")
    again = hn.cluster.campaign(model, autopilot, out=tmp_path / "a", **options)
    assert (again.shards, again.resumed) == (3, 2)
    hn.cluster.campaign(model, autopilot, out=tmp_path / "b", **options)
    assert partitions(tmp_path / "a") == partitions(tmp_path / "b")
    with pytest.raises(hn.ConfigError, match="run with another wind_mps, expected"):
        hn.cluster.campaign(model, autopilot, out=tmp_path / "a", wind_mps=9.0, **options)


def fleet(place: Path, logs: int, unreadable: int) -> List[Path]:
    """Logs of the included flight, cut, with faults, or unreadable."""
    place.mkdir()
    faults = ["glitch-step=60@100:15", "gyro-bias=0.5", "outage@120:20", "vibration=6"]
    made = [FLIGHT]
    for index, fault in enumerate(faults):
        path = place / f"made-{index}"
        hn.inject(FLIGHT, fault, seed=index).write(path)
        made.append(path)
    paths = []
    every = logs // unreadable if unreadable else logs + 1
    for index in range(logs):
        path = place / f"flight-{index:03}"
        if index % every == every - 1 and index // every < unreadable:
            kind = index // every % 4
            if kind == 0:
                path.write_bytes(os.urandom(1000))
            elif kind == 1:
                path.mkdir()
            elif kind == 2:
                path.mkdir()
                (path / "imu.csv").write_text("t_s,gyro_x_radps\n1,x\n")
            # And a log that is not there.
        else:
            path.symlink_to(made[index % len(made)])
        paths.append(path)
    return paths


def test_a_fleet_has_a_row_for_every_log(tmp_path: Path) -> None:
    paths = fleet(tmp_path / "logs", 15, 3)
    run = hn.cluster.estimate(paths, out=tmp_path / "out", shard_logs=4, engine="local")
    assert sum(run.counts.values()) == 15 and run.counts["none"] == 3
    rows = run.frame()
    assert rows["path"].tolist() == [str(path) for path in paths]
    assert rows["error"].notna().sum() == 3
    assert all(reason.startswith("LogError: ") for reason in rows["error"].dropna())
    good = rows[rows["path"] == str(paths[5])].iloc[0]
    own = hn.estimate(paths[5])
    assert good["rmse_vn_mps"] == own.summary["error"]["vn_mps"]["rmse"]
    assert good["verdict"] == own.verdict and list(good["reasons"]) == own.reasons
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Without a solution" in page and "flight-004" in page
    assert "srcdoc" in run._repr_html_()


def test_logs_are_named_by_a_pattern_or_a_table(tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as parquet

    paths = fleet(tmp_path / "logs", 3, 0)
    by_list = hn.cluster.estimate(paths, out=tmp_path / "a", engine="local")
    pattern = str(tmp_path / "logs" / "flight-*")
    hn.cluster.estimate(pattern, out=tmp_path / "b", engine="local")
    parquet.write_table(pa.table({"path": [str(path) for path in paths]}), tmp_path / "p.parquet")
    hn.cluster.estimate(tmp_path / "p.parquet", out=tmp_path / "c", engine="local")
    assert partitions(tmp_path / "a") == partitions(tmp_path / "b") == partitions(tmp_path / "c")
    assert by_list.counts["none"] == 0
    parquet.write_table(pa.table({"file": ["a.ulg"]}), tmp_path / "q.parquet")
    with pytest.raises(hn.ConfigError, match="found no column path"):
        hn.cluster.estimate(tmp_path / "q.parquet", out=tmp_path / "d")
    (tmp_path / "r.parquet").write_bytes(b"not a table")
    with pytest.raises(hn.ConfigError, match="r.parquet"):
        hn.cluster.estimate(tmp_path / "r.parquet", out=tmp_path / "d")
    with pytest.raises(hn.ConfigError, match="found none"):
        hn.cluster.estimate(str(tmp_path / "nothing-*"), out=tmp_path / "d")
    with pytest.raises(hn.ConfigError, match="expected a list of paths"):
        hn.cluster.estimate(tmp_path, out=tmp_path / "d")
    with pytest.raises(hn.ConfigError, match="engine"):
        hn.cluster.estimate(paths, out=tmp_path / "d", engine="spark")
    with pytest.raises(hn.ConfigError, match="attempts"):
        hn.cluster.estimate(paths, out=tmp_path / "d", attempts=0)


def test_settings_of_a_fleet_are_those_of_estimate(tmp_path: Path) -> None:
    config = {"gps": {"antenna_lever_arm_m": np.array([-0.3, 0.0, 0.2])}}
    run = hn.cluster.estimate(
        [FLIGHT], out=tmp_path, smooth=True, config=config, engine="local"
    )
    own = hn.estimate(FLIGHT, smooth=True, config=config)
    row = run.frame().iloc[0]
    with pytest.raises(hn.ConfigError, match="antenna_lever_arm_m"):
        wrong = {"gps": {"antenna_lever_arm_m": [1.0]}}
        hn.cluster.estimate([FLIGHT], out=tmp_path / "wrong", config=wrong, engine="local")
    assert row["smoothed"] and row["rmse_vn_mps"] == own.summary["error"]["vn_mps"]["rmse"]


def test_a_killed_node_loses_nothing_and_changes_no_bit(
    two_nodes: Any,
    tmp_path: Path,
    model: hn.Model,
    autopilot: hn.Autopilot,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from workers import Held

    from hovernav.cluster._campaign import _Fly

    options: Dict[str, Any] = {"flights": 600, "duration_s": 30.0, "shard_flights": 50}
    alone = hn.cluster.campaign(
        model, autopilot, out=tmp_path / "alone", engine="local", **options
    )
    (second,) = [node for node in two_nodes.list_all_nodes() if node != two_nodes.head_node]

    def held(pickled: bytes, options: Dict[str, Any]) -> Held:
        return Held(_Fly(pickled, options), second.node_id, tmp_path / "begun")

    def kill(done: int, total: int) -> None:
        # The first shard to finish is of the other node. A shard has begun on this one, which never ends it.
        if done == 1:
            two_nodes.remove_node(second, allow_graceful=False)

    monkeypatch.setattr("hovernav.cluster._campaign._Fly", held)
    run = hn.cluster.campaign(
        model, autopilot, out=tmp_path / "ray", engine="ray", progress=kill, **options
    )
    assert run.lost and all("lost its worker" in words for words in run.lost), run.lost
    assert partitions(tmp_path / "alone") == partitions(tmp_path / "ray")
    assert run.outcomes == alone.outcomes and run.percentiles == alone.percentiles
    two_nodes.add_node(num_cpus=1, object_store_memory=100_000_000)


def test_a_log_that_kills_its_workers_costs_no_other(
    two_nodes: Any, tmp_path: Path
) -> None:
    # A worker that meets this log ends, as by the kernel for lack of memory.
    from workers import DeadlyFleet

    from hovernav.cluster._run import run

    paths = [str(path) for path in fleet(tmp_path / "logs", 6, 0)]
    work = DeadlyFleet(paths, deadly=paths[4])
    done = run(work, tmp_path / "out", engine="ray", attempts=2, progress=None)
    rows = done.frame()
    assert rows["path"].tolist() == paths
    assert rows["error"].notna().tolist() == [path == paths[4] for path in paths]
    assert "its worker was lost 2 times" in rows["error"][4]
    assert any("its parts run alone" in words for words in done.lost)


@pytest.mark.skipif("HOVERNAV_LONG" not in os.environ, reason="minutes")
def test_three_hundred_logs_give_280_results_and_20_reasons(two_nodes: Any, tmp_path: Path) -> None:
    paths = fleet(tmp_path / "logs", 300, 20)
    run = hn.cluster.estimate(paths, out=tmp_path / "ray", engine="ray")
    rows = run.frame()
    assert (rows["error"].isna().sum(), rows["error"].notna().sum()) == (280, 20)
    assert rows["verdict"].notna().sum() == 280
    hn.cluster.estimate(paths, out=tmp_path / "local", engine="local")
    assert partitions(tmp_path / "ray") == partitions(tmp_path / "local")
