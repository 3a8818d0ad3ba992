"""Framework: each module with ``NAME`` and ``run()`` is a benchmark, whose rows have a reference value."""

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
    """One result, with reference and ratio if available; ``ok`` is None without a target."""

    what: str
    value: float
    unit: str
    reference: str = ""
    reference_value: float | None = None
    ratio: float | None = None
    target: str = ""
    ok: bool | None = None


def discover() -> dict[str, Callable[..., list[Row]]]:
    """Return {name: run} of every ``bench_*.py`` in this folder, sorted by ``ORDER``.

    If a benchmark draws figures, the folder for the figures is its argument.
    """
    files = sorted(Path(__file__).parent.glob("bench_*.py"))
    modules = [importlib.import_module(f"tests.bench.{path.stem}") for path in files]
    return {module.NAME: module.run for module in sorted(modules, key=lambda m: getattr(m, "ORDER", 100))}


def child(module: str, *args: str, **environment: str) -> dict[str, Any]:
    """Run a program of this folder without a display; return the JSON object that it prints last."""
    done = subprocess.run(
        [sys.executable, "-m", f"tests.bench.{module}", *args],
        # use cached byte code, like a program that was started before
        env={"QT_QPA_PLATFORM": "offscreen", **os.environ, "PYTHONDONTWRITEBYTECODE": "", **environment},
        capture_output=True,
        text=True,
        timeout=300,
    )
    if done.returncode:
        last = next(iter(reversed(done.stderr.splitlines())), "it said nothing")
        raise RuntimeError(f"{module} ended with {done.returncode}: {last}")
    return json.loads(done.stdout.splitlines()[-1])


def without_board() -> bool:
    """Return True and print a message if the virtual board is missing."""
    if not virtual_board.built():
        print("  the virtual board is not built: make firmware", file=sys.stderr)
    return not virtual_board.built()


def resident() -> float:
    """Return this program's resident memory in MB (Linux)."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return 1e-6 * pages * os.sysconf("SC_PAGE_SIZE")


def machine() -> dict[str, object]:
    """Return the properties of the machine on which figures depend."""
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


def new_file(folder: Path) -> Path:
    """Return a file for the results of a new run."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder / time.strftime("%Y%m%d-%H%M%S.json")


def save(rows: Iterable[Row], path: Path) -> None:
    """Write machine and rows as one JSON object, in which a value that is not a number is null."""
    found = [{k: None if v != v else v for k, v in asdict(row).items()} for row in rows]
    path.write_text(json.dumps({"machine": machine(), "rows": found}, indent=2))


def print_head() -> None:
    """Print the header of a Markdown table of rows."""
    print("| what | value | reference in the same run | ratio | to reach | reached |")
    print("|---|---|---|---|---|---|", flush=True)


def print_rows(rows: Iterable[Row]) -> None:
    """Print rows of a Markdown table."""
    for row in rows:
        reference = ""
        if row.reference_value is not None:
            reference = f"{row.reference}: {number(row.reference_value)} {row.unit}"
        ratio = "" if row.ratio is None else number(row.ratio)
        reached = {True: "yes", False: "NO", None: ""}[row.ok]
        value = "" if row.value != row.value else f"{number(row.value)} {row.unit}"
        print("| " + " | ".join((row.what, value, reference, ratio, row.target, reached)) + " |", flush=True)


def number(value: float) -> str:
    """Return a number with three significant digits, without an exponent."""
    return f"{float(f'{value:.3g}'):,.10g}"
