"""The package as a whole: its size, its import, its types."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

import hovernav as hn


def test_everything_public_is_documented_and_typed() -> None:
    stub = (Path(hn.__file__).parent / "_hovernav.pyi").read_text()
    for name in hn.__all__:
        thing = getattr(hn, name)
        if name in {"__version__", "cluster"}:
            continue
        assert inspect.getdoc(thing), name
        if thing.__module__ == "hovernav":
            assert re.search(rf"(class|def) {name}\b", stub), name
        if inspect.isclass(thing) and thing.__module__ == "hovernav":
            body = re.split(r"\n(?=class |def )", stub.split(f"class {name}:")[1])[0]
            for member in (member for member in vars(thing) if not member.startswith("_")):
                assert f"def {member}(" in body, f"{name}.{member}"
                assert inspect.getdoc(getattr(thing, member)), f"{name}.{member}"


@pytest.mark.parametrize("folder", ["examples", "package", "tests"])
def test_the_types_are_correct(folder: str) -> None:
    check = [sys.executable, "-m", "mypy", "--strict", "."]
    done = subprocess.run(check, capture_output=True, text=True, cwd=ROOT / "python" / folder)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_example_runs() -> None:
    example = ROOT / "python" / "examples" / "estimate.py"
    flight = ROOT / "datasets" / "heli-hover"
    done = subprocess.run([sys.executable, str(example), str(flight)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "m/s" in done.stdout


def test_an_import_loads_neither_numpy_nor_pandas() -> None:
    code = "import sys, hovernav; assert not {'numpy', 'pandas', 'pyarrow', 'ray'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
