"""Run every benchmark, or those named, print a table and write JSON: ``python -m tests.bench [NAME ...]``."""

import argparse
import inspect
import sys
from pathlib import Path

from tests.bench.frame import discover, print_table, save


def main() -> int:
    """Return 1 if a row misses its target, 2 if a name is unknown."""
    benchmarks = discover()
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(benchmarks))
    parser.add_argument("--output", type=Path, default=Path("bench-results"), help="folder for the JSON")
    parser.add_argument("--pictures", type=Path, metavar="FOLDER", help="draw the charts into this folder")
    options = parser.parse_args()
    unknown = [name for name in options.names if name not in benchmarks]
    if unknown:
        parser.error(f"no benchmark {unknown[0]!r}; there are: {', '.join(benchmarks)}")
    rows = []
    for name in options.names or benchmarks:
        print(f"{name} ...", file=sys.stderr, flush=True)
        draws = inspect.signature(benchmarks[name]).parameters
        rows += benchmarks[name](options.pictures) if draws else benchmarks[name]()
    print_table(rows)
    print(f"written to {save(rows, options.output)}")
    return int(any(row.ok is False for row in rows))


if __name__ == "__main__":
    sys.exit(main())
