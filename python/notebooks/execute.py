"""Execute the notebooks. The executed copies, and their figures as pictures, are written to a directory.

usage: python execute.py OUT [NAME]...

A notebook runs in a scratch directory with a link to the datasets of the repository, and to the shared logs where they
are. A notebook that fails ends the script. `first-look` is skipped without the shared logs.
"""

from __future__ import annotations

import base64
import sys
import tempfile
import time
from pathlib import Path
from typing import List

import nbformat
from nbclient import NotebookClient

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SHARED = ROOT.parent / "shared" / "logs"


def execute(path: Path, out: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    started = time.monotonic()
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "datasets").symlink_to(ROOT / "datasets")
        if SHARED.is_dir() and path.stem == "first-look":
            (Path(scratch) / "logs").symlink_to(SHARED)
        resources = {"metadata": {"path": scratch}}
        NotebookClient(notebook, timeout=3600, resources=resources).execute()
    nbformat.write(notebook, out / path.name)
    figures = 0
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            picture = output.get("data", {}).get("image/png")
            if picture:
                figures += 1
                name = f"{path.stem}-{figures}.png"
                (out / name).write_bytes(base64.b64decode(picture))
            for line in output.get("text", "").splitlines():
                print(f"    {line}")
    print(f"{path.stem}: {time.monotonic() - started:.0f} s, {figures} figures")


def main(out: Path, names: List[str]) -> None:
    out.mkdir(parents=True, exist_ok=True)
    for path in sorted(HERE.glob("*.ipynb")):
        if names and path.stem not in names:
            continue
        if path.stem == "first-look" and not SHARED.is_dir():
            print("first-look: skipped, the shared logs are missing")
            continue
        execute(path, out)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]), sys.argv[2:])
