"""Shards of work, on this machine or on Ray."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Deque, Dict, Iterator, List, Optional, Sequence, Tuple, Union

from .._errors import ConfigError, Error

Progress = Callable[[int, int], object]


class ClusterError(Error):
    """A shard that cannot be finished: its workers are lost each time."""


class Work(ABC):
    """Work in shards. A shard has one or more parts, which give the same result alone and together."""

    #: The settings of the result. A run in the same directory continues only with equal settings.
    settings: Dict[str, Any]

    @abstractmethod
    def shards(self) -> int:
        """Number of shards."""

    @abstractmethod
    def parts(self, shard: int) -> Sequence[Any]:
        """The parts of a shard, as the arguments of `task`."""

    @property
    @abstractmethod
    def task(self) -> Callable[[Sequence[Any], int], bytes]:
        """Runs some parts on a number of threads: a Parquet file. It can be pickled."""

    @abstractmethod
    def without(self, part: Any, reason: str) -> bytes:
        """The result of a part that loses its worker each time. Raises ClusterError where that is not a result."""

    @abstractmethod
    def joined(self, results: Sequence[bytes]) -> bytes:
        """The result of a shard, from those of its parts: the bytes that `task` gives for all of them."""


@dataclass(frozen=True)
class Run:
    """A finished run, in its directory."""

    #: The directory: `run.json`, `shards`, `summary.json`.
    out: Path
    #: Number of shards.
    shards: int
    #: Shards that were finished by an earlier run.
    resumed: int
    #: One sentence for each lost worker: shard, reason, remedy.
    lost: List[str]
    #: Time of this run, s.
    wall_s: float

    @property
    def paths(self) -> List[Path]:
        """The Parquet files, in order."""
        return [partition(self.out, shard) for shard in range(self.shards)]

    def frame(self) -> Any:
        """All rows as one pandas data frame. Raises ImportError without pandas."""
        import pyarrow.parquet as parquet

        return parquet.read_table([str(path) for path in self.paths]).to_pandas()


def partition(out: Path, shard: int) -> Path:
    """The file of a shard."""
    return out / "shards" / f"{shard:06}.parquet"


def write_whole(path: Path, data: bytes) -> None:
    """Write a file whole or not at all."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise


def run(
    work: Work,
    out: Union[str, "os.PathLike[str]"],
    *,
    engine: str,
    attempts: int,
    progress: Optional[Progress],
) -> Run:
    """Run all shards that are not finished in the directory `out`."""
    started = time.monotonic()
    if attempts < 1:
        raise ConfigError(f"attempts: found {attempts}, expected 1 or more")
    on_ray = _is_on_ray(engine)
    out = Path(out)
    (out / "shards").mkdir(parents=True, exist_ok=True)
    _continue(out, work.settings)
    for part in (out / "shards").glob(".*.part"):
        part.unlink()
    total = work.shards()
    pending = [shard for shard in range(total) if not partition(out, shard).exists()]
    resumed = total - len(pending)
    lost: List[str] = []
    finished = _on_ray(work, pending, attempts, lost) if on_ray else _here(work, pending)
    done = resumed
    if progress is not None:
        progress(done, total)
    for shard, data in finished:
        write_whole(partition(out, shard), data)
        done += 1
        if progress is not None:
            progress(done, total)
    return Run(out, total, resumed, lost, time.monotonic() - started)


def _continue(out: Path, settings: Dict[str, Any]) -> None:
    """Start a run in `out`, or continue one with the same settings."""
    text = json.dumps(settings, indent=1, sort_keys=True) + "\n"
    path = out / "run.json"
    if not path.exists():
        write_whole(path, text.encode())
        return
    before = path.read_text(encoding="utf-8")
    if before != text:
        then, now = json.loads(before), json.loads(text)
        keys = sorted(key for key in {*then, *now} if then.get(key) != now.get(key))
        raise ConfigError(
            f"{out}: found a run with another {', '.join(keys)}, expected the same settings or an empty directory"
        )


def _is_on_ray(engine: str) -> bool:
    if engine not in {"auto", "ray", "local"}:
        raise ConfigError(f'engine: found "{engine}", expected auto, ray or local')
    # A program that has not imported Ray has no cluster, and its import takes seconds.
    if engine == "local" or (engine == "auto" and "ray" not in sys.modules):
        return False
    import ray

    if engine == "ray" and not ray.is_initialized():
        ray.init()
    return bool(ray.is_initialized())


def _here(work: Work, shards: Sequence[int]) -> Iterator[Tuple[int, bytes]]:
    """One shard after another, each on all cores."""
    threads = os.cpu_count() or 1
    for shard in shards:
        yield shard, work.task(work.parts(shard), threads)


def _call(task: Callable[[Sequence[Any], int], bytes], parts: Sequence[Any]) -> bytes:
    """A task in a worker, which has one core."""
    # Read when the library starts its threads, at their first use.
    os.environ["RAYON_NUM_THREADS"] = "1"
    return task(parts, 1)


@dataclass
class _Job:
    """Parts of a shard that run together: all of them, or the one at `part`."""

    shard: int
    part: Optional[int] = None
    losses: int = 0


def _on_ray(
    work: Work, shards: Sequence[int], attempts: int, lost: List[str]
) -> Iterator[Tuple[int, bytes]]:
    """The shards on all cores of a Ray cluster, in the order in which they finish.

    The driver holds the results of at most two tasks a core. A shard that loses its worker `attempts` times is run
    again in single parts, so that the one that ends its workers costs no other.
    """
    import ray
    from ray.exceptions import RayError, RayTaskError

    # The driver submits a lost task again, because Ray does not report its own attempts.
    remote = ray.remote(num_cpus=1, max_retries=0)(_call)
    pending: Deque[_Job] = deque(_Job(shard) for shard in shards)
    running: Dict[Any, _Job] = {}
    single: Dict[int, Dict[int, bytes]] = {}

    def finished(job: _Job, data: bytes) -> Optional[bytes]:
        if job.part is None:
            return data
        parts = single[job.shard]
        parts[job.part] = data
        if len(parts) < len(work.parts(job.shard)):
            return None
        del single[job.shard]
        return work.joined([parts[part] for part in sorted(parts)])

    try:
        while pending or running:
            cores = int(ray.cluster_resources().get("CPU", 1))
            while pending and len(running) < 2 * max(cores, 1):
                job = pending.popleft()
                parts = work.parts(job.shard)
                parts = parts if job.part is None else [parts[job.part]]
                running[remote.remote(work.task, parts)] = job
            ready, _ = ray.wait(list(running), num_returns=1, timeout=5.0)
            for reference in ready:
                job = running.pop(reference)
                try:
                    data = ray.get(reference)
                except RayTaskError as error:
                    raise error.as_instanceof_cause() from None
                except RayError as error:
                    data = _again(work, job, error, attempts, lost, pending, single)
                    if data is None:
                        continue
                whole = finished(job, data)
                if whole is not None:
                    yield job.shard, whole
    finally:
        for reference in running:
            ray.cancel(reference, force=True)


def _again(
    work: Work,
    job: _Job,
    error: Exception,
    attempts: int,
    lost: List[str],
    pending: Deque[_Job],
    single: Dict[int, Dict[int, bytes]],
) -> Optional[bytes]:
    """Handles a lost worker: the job runs again, in single parts, or ends without a result."""
    job.losses += 1
    parts = work.parts(job.shard)
    where = f"shard {job.shard}" if job.part is None else f"shard {job.shard}, part {job.part}"
    reason = f"{where}: lost its worker ({type(error).__name__})"
    if job.losses < attempts:
        lost.append(f"{reason}; run again")
        pending.appendleft(job)
        return None
    if job.part is None and len(parts) > 1:
        lost.append(f"{reason} {job.losses} times; its parts run alone")
        single[job.shard] = {}
        pending.extendleft(_Job(job.shard, part) for part in range(len(parts)))
        return None
    lost.append(f"{reason} {job.losses} times; given up")
    part = parts[job.part or 0]
    return work.without(part, f"its worker was lost {job.losses} times, such as for lack of memory")
