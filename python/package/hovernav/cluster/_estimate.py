"""Logs of a fleet, estimated in shards."""

from __future__ import annotations

import glob
import json
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Union

from .. import _hovernav as core
from .._errors import ConfigError, Error
from ._campaign import _bytes_of
from ._run import Progress, Run, Work, run, write_whole

_Path = Union[str, "os.PathLike[str]"]

#: Errors against the reference of a log, as columns `rmse_NAME`; missing without one.
_ERRORS = ["horizontal_m", "down_m", "vn_mps", "ve_mps", "vd_mps", "roll_deg", "pitch_deg", "yaw_deg"]


def _schema() -> Any:
    import pyarrow as pa

    words, number, count = pa.string(), pa.float64(), pa.int64()
    return pa.schema(
        [
            ("path", words),
            ("error", words),
            ("vehicle", words),
            ("verdict", words),
            ("reasons", pa.list_(words)),
            ("warnings", pa.list_(words)),
            ("kinds", pa.list_(words)),
            ("duration_s", number),
            ("imu_samples", count),
            ("gps_fixes_used", count),
            ("gps_fixes_rejected", count),
            ("smoothed", pa.bool_()),
            *((f"rmse_{name}", number) for name in _ERRORS),
            ("summary", words),
        ]
    )


@dataclass(frozen=True)
class _Estimate:
    """Estimates some logs."""

    smooth: bool
    config: Optional[str]

    def __call__(self, parts: Sequence[str], threads: int) -> bytes:
        with ThreadPoolExecutor(max_workers=threads) as pool:
            return _rows(list(pool.map(self._row, parts)))

    def _row(self, path: str) -> Dict[str, Any]:
        config = None if self.config is None else json.loads(self.config)
        try:
            log = core.read(path)
            solution = core.estimate(log, smooth=self.smooth, config=config)
        except Error as error:
            # Settings that are wrong for every log end the run; those of one log are its reason.
            if isinstance(error, ConfigError) and str(error).startswith("config:"):
                raise
            return {"path": path, "error": f"{type(error).__name__}: {error}"}
        summary = solution.summary
        # The time of the run is no result: it differs with the machine.
        del summary["wall_s"]
        findings = [finding for finding in solution.findings if finding.severity != "info"]
        errors = summary.get("error") or {}
        return {
            "path": path,
            "vehicle": log.vehicle,
            "verdict": solution.verdict,
            "reasons": solution.reasons,
            "warnings": summary["warnings"],
            "kinds": sorted({finding.kind for finding in findings}),
            **{name: summary[name] for name in ["duration_s", "imu_samples", "smoothed"]},
            **{name: summary[name] for name in ["gps_fixes_used", "gps_fixes_rejected"]},
            **{f"rmse_{name}": errors[name]["rmse"] for name in _ERRORS if name in errors},
            "summary": json.dumps(summary),
        }


def _rows(rows: Sequence[Dict[str, Any]]) -> bytes:
    import pyarrow as pa

    return _bytes_of(pa.Table.from_pylist(list(rows), schema=_schema()))


class _Fleet(Work):
    def __init__(self, paths: List[str], smooth: bool, config: Optional[str], shard_logs: int) -> None:
        self.paths, self.shard_logs = paths, shard_logs
        self._task = _Estimate(smooth, config)
        self.settings = {
            "kind": "estimate",
            "version": core.__version__,
            "logs": len(paths),
            "paths": sha256("\0".join(paths).encode()).hexdigest(),
            "smooth": smooth,
            "config": config,
            "shard_logs": shard_logs,
        }

    def shards(self) -> int:
        return -(-len(self.paths) // self.shard_logs)

    def parts(self, shard: int) -> Sequence[str]:
        return self.paths[shard * self.shard_logs : (shard + 1) * self.shard_logs]

    @property
    def task(self) -> Callable[[Sequence[Any], int], bytes]:
        return self._task

    def without(self, part: Any, reason: str) -> bytes:
        return _rows([{"path": part, "error": f"ClusterError: {reason}"}])

    def joined(self, results: Sequence[bytes]) -> bytes:
        import pyarrow as pa
        import pyarrow.parquet as parquet

        tables = [parquet.read_table(pa.BufferReader(result)) for result in results]
        return _bytes_of(pa.concat_tables(tables).combine_chunks())


@dataclass(frozen=True)
class FleetRun(Run):
    """A fleet in its directory: `report.html` lists the worst logs, and counts logs by finding and by vehicle.

    `frame()` has one row per log: `path`, `error` (why there is no solution), `vehicle`, `verdict`, `reasons`,
    `warnings`, `kinds` of the warnings, counts, `rmse_*` against the reference of the log, and `summary`, the content of
    its `summary.json`.
    """

    #: Numbers of logs by verdict: `good`, `care`, `bad`, `none` without a solution.
    counts: Dict[str, int]

    def _repr_html_(self) -> str:
        return _page(self).framed(self.lost)


def estimate(
    logs: Union[_Path, Sequence[_Path]],
    *,
    out: _Path,
    smooth: bool = False,
    config: Union[_Path, Dict[str, Any], None] = None,
    shard_logs: int = 20,
    engine: str = "auto",
    attempts: int = 3,
    progress: Optional[Progress] = None,
) -> FleetRun:
    """`hovernav.estimate` over many logs. A log that cannot be estimated gives a row with the reason.

    Parameters
    ----------
    logs : sequence of paths, pattern, or Parquet file
        A pattern such as "logs/**/*.ulg"; a Parquet file has the paths in its column `path`. Every worker must reach
        the logs by the same paths.
    out : path
        Directory of the run, of this machine. It continues a run with the same settings.
    smooth, config
        As of `hovernav.estimate`. The file `config` is read once.
    shard_logs : int
        Logs in a shard.
    engine, attempts, progress
        As of `hovernav.cluster.campaign`. A log that loses its workers each time gives a row with that reason.

    Raises
    ------
    ConfigError
        If there are no logs, a value or a setting is out of range, or `out` holds a run with other settings.
    """
    if shard_logs < 1:
        raise ConfigError(f"shard_logs: found {shard_logs}, expected 1 or more")
    work = _Fleet(_paths(logs), smooth, _settings(config), shard_logs)
    done = run(work, out, engine=engine, attempts=attempts, progress=progress)
    fleet = _page(done)
    fleet.report(done.out / "report.html", done.lost)
    counts = dict(zip(["good", "care", "bad", "none"], fleet.counts))
    summary = {
        "tool": "hovernav",
        "version": core.__version__,
        "logs": len(work.paths),
        "counts": counts,
        "lost": done.lost,
        "wall_s": done.wall_s,
    }
    write_whole(done.out / "summary.json", (json.dumps(summary, indent=2) + "\n").encode())
    return FleetRun(**vars(done), counts=counts)


def _paths(logs: Union[_Path, Sequence[_Path]]) -> List[str]:
    paths: List[str]
    if isinstance(logs, (str, os.PathLike)):
        name = os.fspath(logs)
        if name.endswith(".parquet"):
            import pyarrow.parquet as parquet

            try:
                table = parquet.read_table(name)
            except (OSError, ValueError) as error:
                raise ConfigError(f"logs: {name}: {error}") from None
            if "path" not in table.column_names:
                raise ConfigError(f"logs: {name}: found no column path")
            paths = [path for path in table.column("path").to_pylist() if path]
        elif glob.has_magic(name):
            paths = sorted(glob.glob(name, recursive=True))
        else:
            raise ConfigError(f"logs: found {name}, expected a list of paths, a pattern, or a Parquet file")
    else:
        paths = [os.fspath(path) for path in logs]
    if not paths:
        raise ConfigError(f"logs: found none in {logs}")
    return paths


def _settings(config: Union[_Path, Dict[str, Any], None]) -> Optional[str]:
    """The settings as JSON: workers do not read the file."""
    if config is None:
        return None
    return core._settings_json(config)


def _page(done: Run) -> core._Fleet:
    """The page of the fleet, from one shard after another."""
    import pyarrow.parquet as parquet

    columns = ["path", "error", "vehicle", "verdict", "reasons", "warnings", "kinds", "duration_s"]
    fleet = core._Fleet()
    for path in done.paths:
        for row in parquet.read_table(path, columns=columns).to_pylist():
            reasons = row["reasons"] or row["warnings"] or [""]
            fleet.add(
                row["path"],
                row["vehicle"] or "",
                float("nan") if row["duration_s"] is None else row["duration_s"],
                row["verdict"],
                row["kinds"] or [],
                row["error"] or reasons[0],
            )
    return fleet
