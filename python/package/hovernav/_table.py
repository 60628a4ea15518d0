"""Columns of equal length."""

from __future__ import annotations

from typing import TYPE_CHECKING, Dict

# NumPy is loaded with the first array: an import of this package is then ten times as fast.
if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd


class Table(Dict[str, "npt.NDArray[np.float64]"]):
    """A dictionary of arrays of shape (n,), one a column. The end of a name is the unit; NaN is an unknown value."""

    def frame(self) -> pd.DataFrame:
        """The columns as a pandas data frame, with the same names.

        Raises ImportError without pandas.
        """
        import pandas as pd

        return pd.DataFrame(dict(self))

    def __repr__(self) -> str:
        rows = len(next(iter(self.values()))) if self else 0
        return f"<Table of {rows} rows: {', '.join(self)}>"
