"""A minute of rendering through the virtual board with the window open: frames lost, round trip."""

import json
import os
import subprocess
import sys

from hapkit_studio.devices import virtual_board
from tests.bench.frame import Row

NAME = "board"
ORDER = 40
SECONDS = 60


def run() -> list[Row]:
    """Return frames lost, the rate and the round trip by the board's clock; nothing where it is not built."""
    if not virtual_board.built():
        print("  the virtual board is not built: make firmware", file=sys.stderr)
        return []
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.board_minute", f"--seconds={SECONDS}"],
        env={"QT_QPA_PLATFORM": "offscreen", **os.environ},
        capture_output=True,
        text=True,
        timeout=SECONDS + 240,
        check=True,
    )
    seen = json.loads(done.stdout.splitlines()[-1])
    lost = seen["lost"] + seen["overrun"]
    trip = 1e3 * seen["round_trip"]
    return [
        Row(f"virtual board, {SECONDS} s: frames lost", lost, "", target="0", ok=lost == 0),
        Row("virtual board: rate", seen["rate"], "Hz"),
        Row("virtual board: round trip, median", trip, "ms", target="< 1 ms", ok=trip < 1.0),
    ]
