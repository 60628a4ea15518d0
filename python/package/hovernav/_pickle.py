"""Models and autopilots in other processes: pickled as the text of their files, which reads back to the bit."""

from __future__ import annotations

import copyreg
from pathlib import Path
from typing import Callable, Tuple, TypeVar

from ._hovernav import Autopilot, Model

_Kind = TypeVar("_Kind", Model, Autopilot)


def _opened(open_file: Callable[[Path], _Kind], text: str) -> _Kind:
    import tempfile

    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "pickled.toml"
        path.write_text(text, encoding="utf-8")
        return open_file(path)


def _text(write: Callable[[Path], None]) -> str:
    import tempfile

    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "pickled.toml"
        write(path)
        return path.read_text(encoding="utf-8")


def _model(model: Model) -> Tuple[Callable[..., Model], Tuple[object, ...]]:
    return _opened, (Model.open, _text(model.write))


def _autopilot(autopilot: Autopilot) -> Tuple[Callable[..., Autopilot], Tuple[object, ...]]:
    return _opened, (Autopilot.open, _text(autopilot.write))


copyreg.pickle(Model, _model)
copyreg.pickle(Autopilot, _autopilot)
