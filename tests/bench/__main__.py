"""Run all or the named benchmarks, and print each result: ``python -m tests.bench [NAME ...]``."""

import argparse
import inspect
import math
import sys
import traceback
from collections.abc import Callable
from pathlib import Path

from tests.bench.frame import Row, discover, new_file, print_head, print_rows, save


def main() -> int:
    """Run the benchmarks; return 1 if a row misses its target, 2 if a name is unknown."""
    benchmarks = discover()
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(benchmarks))
    parser.add_argument("--output", type=Path, default=Path("bench-results"), help="folder for the JSON")
    parser.add_argument("--pictures", type=Path, metavar="FOLDER", help="draw the charts into this folder")
    options = parser.parse_args()
    unknown = [name for name in options.names if name not in benchmarks]
    if unknown:
        parser.error(f"no benchmark {unknown[0]!r}; there are: {', '.join(benchmarks)}")
    rows: list[Row] = []
    path = new_file(options.output)
    print_head()
    for name in options.names or benchmarks:
        print(f"{name} ...", file=sys.stderr, flush=True)
        found = measured(name, benchmarks[name], options.pictures)
        rows += found
        print_rows(found)
        save(rows, path)
    print(f"written to {path}")
    return int(any(row.ok is False for row in rows))


def measured(name: str, run: Callable[..., list[Row]], pictures: Path | None) -> list[Row]:
    """Return a benchmark's rows; a failure becomes a row with its reason."""
    try:
        return run(pictures) if inspect.signature(run).parameters else run()
    except (Exception, SystemExit) as error:
        traceback.print_exc()
        reason = next(iter(str(error).splitlines()), "") or type(error).__name__
        return [Row(f"{name} failed: {reason}", math.nan, "", ok=False)]


if __name__ == "__main__":
    sys.exit(main())
