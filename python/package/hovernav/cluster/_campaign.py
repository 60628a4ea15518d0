"""Campaigns of simulated flights in shards."""

from __future__ import annotations

import io
import json
import os
import pickle
from dataclasses import dataclass
from hashlib import sha256
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from .. import _hovernav as core
from .._errors import ConfigError
from ._run import ClusterError, Progress, Run, Work, run, write_whole

#: First flight and number of flights.
_Part = Tuple[int, int]


def _bytes_of(table: Any) -> bytes:
    import pyarrow.parquet as parquet

    out = io.BytesIO()
    parquet.write_table(table, out, compression="zstd")
    return out.getvalue()


@dataclass(frozen=True)
class _Fly:
    """Flies some flights."""

    pickled: bytes
    options: Dict[str, Any]

    def __call__(self, parts: Sequence[_Part], threads: int) -> bytes:
        import pyarrow

        del threads  # The library flies on the threads that the environment allows.
        model, autopilot = pickle.loads(self.pickled)
        tables = [
            pyarrow.table(
                dict(
                    core.campaign(
                        model, autopilot, seed=seed, flights=flights, **self.options
                    ).table()
                )
            )
            for seed, flights in parts
        ]
        return _bytes_of(pyarrow.concat_tables(tables).combine_chunks())


class _Campaign(Work):
    def __init__(
        self,
        model: core.Model,
        autopilot: core.Autopilot,
        flights: int,
        seed: int,
        shard_flights: int,
        options: Dict[str, Any],
    ) -> None:
        self.flights, self.seed, self.shard_flights = flights, seed, shard_flights
        pickled = pickle.dumps((model, autopilot), protocol=4)
        self._task = _Fly(pickled, options)
        self.settings = {
            "kind": "campaign",
            "version": core.__version__,
            "model": model.name,
            "model_and_autopilot": sha256(pickled).hexdigest(),
            "flights": flights,
            "seed": seed,
            "shard_flights": shard_flights,
            **options,
        }

    def shards(self) -> int:
        return -(-self.flights // self.shard_flights)

    def parts(self, shard: int) -> Sequence[_Part]:
        first = shard * self.shard_flights
        return [(self.seed + first, min(self.shard_flights, self.flights - first))]

    @property
    def task(self) -> Callable[[Sequence[Any], int], bytes]:
        return self._task

    def without(self, part: Any, reason: str) -> bytes:
        seed, flights = part
        raise ClusterError(f"flights {seed} to {seed + flights - 1}: {reason}")

    def joined(self, results: Sequence[bytes]) -> bytes:
        (one,) = results
        return one


@dataclass(frozen=True)
class CampaignRun(Run):
    """A campaign in its directory; `frame()` has the columns of `results.csv`."""

    #: Number of flights by outcome.
    outcomes: Dict[str, int]
    #: Percentiles of each measure, such as `percentiles["vn_error_rms_mps"]["p95"]`.
    percentiles: Dict[str, Dict[str, float]]

    def column(self, name: str) -> Any:
        """One column of all flights, as an array."""
        return _column(self, name)


def campaign(
    model: core.Model,
    autopilot: core.Autopilot,
    *,
    out: Union[str, "os.PathLike[str]"],
    flights: int = 10_000,
    seed: int = 1,
    duration_s: float = 60.0,
    wind_mps: float = 5.0,
    outages: float = 0.25,
    power_loss: float = 0.0,
    jams: float = 0.0,
    fuel_kg: float = 0.4,
    shard_flights: int = 500,
    engine: str = "auto",
    attempts: int = 3,
    progress: Optional[Progress] = None,
) -> CampaignRun:
    """`hovernav.campaign` in shards: the same flights, to the bit.

    Parameters
    ----------
    out : path
        Directory of the run, of this machine. It continues a run with the same settings.
    shard_flights : int
        Flights in a shard. A shard of 500 flights of a minute takes some ten seconds of one core.
    engine : str
        "ray", "local", or "auto": Ray if `ray.init` was called.
    attempts : int
        Number of workers that a shard may lose.
    progress : callable, optional
        Called with the number of shards done and their total.

    Raises
    ------
    ConfigError
        If a value is out of range, or `out` holds a run with other settings.
    ModelError
        If a flight is not possible.
    ClusterError
        If a shard loses its worker `attempts` times. Run again to continue.
    """
    options: Dict[str, Any] = {
        "duration_s": duration_s,
        "wind_mps": wind_mps,
        "outages": outages,
        "power_loss": power_loss,
        "jams": jams,
        "fuel_kg": fuel_kg,
    }
    for name, value in {"flights": flights, "shard_flights": shard_flights}.items():
        if value < 1:
            raise ConfigError(f"{name}: found {value}, expected 1 or more")
    work = _Campaign(model, autopilot, flights, seed, shard_flights, options)
    done = run(work, out, engine=engine, attempts=attempts, progress=progress)
    outcomes = {name: 0 for name in ["hovered", "degraded", "not_engaged", "crashed"]}
    names, counts = np.unique(_column(done, "outcome"), return_counts=True)
    outcomes.update({str(name): int(count) for name, count in zip(names, counts)})
    percentiles = {name: core._percentiles(_column(done, name)) for name in _measures(done)}
    summary = {
        "tool": "hovernav",
        "version": core.__version__,
        "flights": flights,
        "outcomes": outcomes,
        "percentiles": percentiles,
        "lost": done.lost,
        "wall_s": done.wall_s,
    }
    write_whole(done.out / "summary.json", (json.dumps(summary, indent=2) + "\n").encode())
    return CampaignRun(**vars(done), outcomes=outcomes, percentiles=percentiles)


def _column(done: Run, name: str) -> Any:
    """One column of all flights: the memory of one column."""
    import pyarrow.parquet as parquet

    read = [parquet.read_table(path, columns=[name]).column(0).to_numpy() for path in done.paths]
    return np.concatenate(read)


def _measures(done: Run) -> List[str]:
    """The columns that are measured in every flight."""
    import pyarrow.parquet as parquet

    known = parquet.read_schema(done.paths[0]).names
    return [name for name in core._MEASURES if name in known]
