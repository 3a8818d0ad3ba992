"""An empty static picture, for every chart of the command line and notebooks."""

from pathlib import Path
from typing import Any

from hapkit_studio.errors import ParameterError


def new_figure(path: str | Path, size: tuple[float, float]) -> Any:
    """Return an empty figure of so many inches; raise ParameterError where path is no picture's."""
    from matplotlib.figure import Figure

    check(path)
    return Figure(figsize=size, layout="constrained")


def check(path: str | Path) -> None:
    """Raise ParameterError where path is no picture's."""
    from matplotlib.backend_bases import FigureCanvasBase

    ending, known = Path(path).suffix[1:].lower(), FigureCanvasBase.get_supported_filetypes()
    if ending and ending not in known:
        raise ParameterError(f"A picture is one of {', '.join(known)}, not {ending!r}.")
