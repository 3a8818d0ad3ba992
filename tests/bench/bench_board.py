"""A minute of rendering through the virtual board while the window is open: lost frames and round trip."""

from tests.bench.frame import Row, child, without_board

NAME, ORDER = "board", 40
SECONDS = 60


def run() -> list[Row]:
    """Return lost frames, rate, round trip by the board's clock, and faults; no rows without the board."""
    if without_board():
        return []
    seen = child("board_minute", str(SECONDS))
    lost, trip = seen["lost"], 1e3 * seen["round_trip"]
    what = f"virtual board: round trip, median of {seen['round_trips']:,}"
    return [
        Row(f"virtual board, {SECONDS} s: frames lost", lost, "", target="0", ok=lost == 0),
        Row("virtual board: rate", seen["rate"], "Hz"),
        Row(what, trip, "ms", target="< 1 ms", ok=trip < 1.0),
        Row("virtual board: faults cleared meanwhile", seen["faults"], "", target="0", ok=not seen["faults"]),
    ]
