"""One benchmark a file, found by its ``NAME`` and ``run()``; rows that stand beside their reference."""

import importlib
import json
import os
import platform
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

ORDER = 100


@dataclass(frozen=True)
class Row:
    """One figure; reference and ratio where there is one, ok None where there is no target."""

    what: str
    value: float
    unit: str
    reference: str = ""
    reference_value: float | None = None
    ratio: float | None = None
    target: str = ""
    ok: bool | None = None


def discover() -> dict[str, Callable[..., list[Row]]]:
    """Return name -> run of every ``bench_*.py`` beside this file with a NAME, in their declared order.

    One that draws takes the folder for its pictures.
    """
    files = sorted(Path(__file__).parent.glob("bench_*.py"))
    modules = [importlib.import_module(f"tests.bench.{path.stem}") for path in files]
    modules = [module for module in modules if hasattr(module, "NAME")]
    modules.sort(key=lambda module: getattr(module, "ORDER", ORDER))
    return {module.NAME: module.run for module in modules}


def machine() -> dict[str, object]:
    """Return what the figures depend on."""
    info = Path("/proc/cpuinfo")
    models = [line.split(":")[1].strip() for line in _lines(info) if line.startswith("model name")]
    return {
        "processor": models[0] if models else platform.processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "time": time.strftime("%Y-%m-%dT%H:%M:%S%z"),
    }


def save(rows: Iterable[Row], folder: Path) -> Path:
    """Write machine and rows as one JSON object; return the file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / time.strftime("%Y%m%d-%H%M%S.json")
    path.write_text(json.dumps({"machine": machine(), "rows": [asdict(row) for row in rows]}, indent=2))
    return path


def print_table(rows: Iterable[Row]) -> None:
    """Print the rows as a Markdown table."""
    print("| what | value | reference in the same run | ratio | to reach | reached |")
    print("|---|---|---|---|---|---|")
    for row in rows:
        reference = ""
        if row.reference_value is not None:
            reference = f"{row.reference}: {number(row.reference_value)} {row.unit}"
        ratio = "" if row.ratio is None else number(row.ratio)
        reached = {True: "yes", False: "NO", None: ""}[row.ok]
        cells = (row.what, f"{number(row.value)} {row.unit}", reference, ratio, row.target, reached)
        print("| " + " | ".join(cells) + " |")


def number(value: float) -> str:
    """Return a number with three significant digits, without an exponent."""
    return f"{float(f'{value:.3g}'):,.10g}"


def _lines(path: Path) -> list[str]:
    return path.read_text().splitlines() if path.is_file() else []
