"""Columns of equal length."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict

# NumPy is loaded with the first array: an import of this package is then ten times as fast.
if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas as pd


class Table(Dict[str, "npt.NDArray[Any]"]):
    """A dictionary of arrays of shape (n,), one a column. The end of a name is the unit; NaN is an unknown value."""

    def frame(self) -> pd.DataFrame:
        """The columns as a pandas data frame, with the same names.

        Raises ImportError without pandas.
        """
        import pandas as pd

        frame: pd.DataFrame = pd.DataFrame(dict(self))
        return frame

    def __repr__(self) -> str:
        rows = len(next(iter(self.values()))) if self else 0
        return f"<Table of {rows} rows: {', '.join(self)}>"
