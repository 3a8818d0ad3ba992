"""Replay of one hour at 4 kHz: time to open it, memory, and time of a frame while it is scrolled."""

from tests.bench.frame import Row, child

NAME, ORDER = "replay", 65


def run() -> list[Row]:
    """Return rows for opening, for memory, and for each way to scroll, relative to the live plots."""
    found = child("replay")
    live, opened = found["live_ms"], found["open_s"]
    what = f"open one hour at 4 kHz, {found['file_MB']:.0f} MB"
    rows = [
        Row(what, opened, "s", target="< 1 s", ok=opened < 1.0),
        Row("memory of an opened hour", found["open_MB"], "MB"),
    ]
    for key, text in (
        ("play_ms", "a frame while it plays, 60 s shown"),
        ("scroll_ms", "a frame while it is dragged through"),
        ("hour_ms", "reduce the whole hour to 1500 columns"),
    ):
        value = found[key]
        reference = "live, last 60 s"
        rows.append(Row(text, value, "ms", reference, live, value / live, "< 16 ms", value < 16.0))
    return rows
