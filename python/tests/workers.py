"""Work of which a worker ends at a chosen log, or waits on a chosen node."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, List, Sequence

from hovernav.cluster._campaign import _Fly
from hovernav.cluster._estimate import _Estimate, _Fleet

#: Longest wait for the other node, s: its first worker takes seconds to start.
PATIENCE = 300.0


@dataclass(frozen=True)
class _Deadly:
    inner: _Estimate
    deadly: str

    def __call__(self, parts: Sequence[str], threads: int) -> bytes:
        if self.deadly in parts:
            os._exit(1)
        return self.inner(parts, threads)


class DeadlyFleet(_Fleet):
    """A fleet with a log that ends the process that reads it."""

    def __init__(self, paths: List[str], deadly: str) -> None:
        super().__init__(paths, smooth=False, config=None, shard_logs=3)
        self._deadly = deadly

    @property
    def task(self) -> Callable[[Sequence[Any], int], bytes]:
        return _Deadly(self._task, self._deadly)


@dataclass(frozen=True)
class Held:
    """Flights that never end on the node `held`. Flights on other nodes first wait for the file `begun`."""

    inner: _Fly
    held: str
    begun: Path

    def __call__(self, parts: Sequence[Any], threads: int) -> bytes:
        import ray

        here = ray.get_runtime_context().get_node_id() == self.held
        if here:
            self.begun.touch()
        awaited = "its end" if here else "flights on the other node"
        started = time.monotonic()
        while here or not self.begun.exists():
            if time.monotonic() - started > PATIENCE:
                raise TimeoutError(f"expected {awaited} within {PATIENCE} s")
            time.sleep(0.05)
        return self.inner(parts, threads)
