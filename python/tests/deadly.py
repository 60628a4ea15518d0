"""A fleet with a log that ends the process that reads it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Callable, List, Sequence

from hovernav.cluster._estimate import _Estimate, _Fleet


@dataclass(frozen=True)
class _Deadly:
    inner: _Estimate
    deadly: str

    def __call__(self, parts: Sequence[str], threads: int) -> bytes:
        if self.deadly in parts:
            os._exit(1)
        return self.inner(parts, threads)


class DeadlyFleet(_Fleet):
    def __init__(self, paths: List[str], deadly: str) -> None:
        super().__init__(paths, smooth=False, config=None, shard_logs=3)
        self._deadly = deadly

    @property
    def task(self) -> Callable[[Sequence[Any], int], bytes]:
        return _Deadly(self._task, self._deadly)
