"""One benchmark a file, found by its ``NAME`` and ``run()``; rows that stand beside their reference."""

import importlib
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from hapkit_studio.devices import virtual_board


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
    """Return name -> run of every ``bench_*.py`` beside this file, in their declared order.

    One that draws takes the folder for its pictures.
    """
    files = sorted(Path(__file__).parent.glob("bench_*.py"))
    modules = [importlib.import_module(f"tests.bench.{path.stem}") for path in files]
    return {module.NAME: module.run for module in sorted(modules, key=lambda m: getattr(m, "ORDER", 100))}


def child(module: str, *words: str, **environment: str) -> dict[str, Any]:
    """Return the JSON object that a program of this folder prints last, run without a display."""
    done = subprocess.run(
        [sys.executable, "-m", f"tests.bench.{module}", *words],
        env={"QT_QPA_PLATFORM": "offscreen", **os.environ, **environment},
        stdout=subprocess.PIPE,
        text=True,
        timeout=300,
        check=True,
    )
    return json.loads(done.stdout.splitlines()[-1])


def without_board() -> bool:
    """Return whether the virtual board is missing; say so."""
    if not virtual_board.built():
        print("  the virtual board is not built: make firmware", file=sys.stderr)
    return not virtual_board.built()


def resident() -> float:
    """Return this program's resident memory in MB (Linux)."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return 1e-6 * pages * os.sysconf("SC_PAGE_SIZE")


def machine() -> dict[str, object]:
    """Return what the figures depend on."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.is_file() else []
    models = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
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
