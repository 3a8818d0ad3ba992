"""A minute of rendering through the virtual board with the window open: frames lost, round trip."""

from tests.bench.frame import Row, child, without_board

NAME, ORDER = "board", 40
SECONDS = 60


def run() -> list[Row]:
    """Return frames lost, the rate and the round trip by the board's clock; nothing where it is not built."""
    if without_board():
        return []
    seen = child("board_minute", str(SECONDS))
    lost, trip = seen["lost"], 1e3 * seen["round_trip"]
    return [
        Row(f"virtual board, {SECONDS} s: frames lost", lost, "", target="0", ok=lost == 0),
        Row("virtual board: rate", seen["rate"], "Hz"),
        Row("virtual board: round trip, median", trip, "ms", target="< 1 ms", ok=trip < 1.0),
    ]
