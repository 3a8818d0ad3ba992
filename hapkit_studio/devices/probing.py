"""Who answers on a device: its firmware, kit and settings, or why it cannot be used."""

from typing import Any

from hapkit_studio.devices.base import DeviceEntry
from hapkit_studio.devices.discovery import Role, at
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.errors import DeviceError
from hapkit_studio.protocol.messages import Board, Origin

_ORIGIN = {
    Origin.DEFAULT: "default settings",
    Origin.STORED: "stored settings",
    Origin.DAMAGED: "stored settings damaged, defaults instead",
    Origin.UNSAVED: "settings not saved",
}


def probe(entry: DeviceEntry) -> dict[str, Any]:
    """Return what a device says of itself: ``text`` in words, ``ok``, and the numbers behind it."""
    port = at(entry.key)
    if port is not None and port.role is Role.OTHER:
        return {"ok": False, "text": "Not asked: not a Hapkit."}
    device = entry.make()
    if not isinstance(device, HapkitBoard):
        return {"ok": True, "text": "Always there: part of the studio."}
    try:
        device.open()
        return _answers(device)
    except DeviceError as error:
        run = f" Run `hapkit-studio flash {entry.key}`." if error.step else ""
        return {"ok": False, "text": f"{error}{run}", "step": error.step, "command": error.command}
    finally:
        device.close()


def _answers(board: HapkitBoard) -> dict[str, Any]:
    hello, latency = board.hello, board.latency
    words = [f"Firmware {hello.build}, version {hello.version}, {hello.arena} bytes for a law"]
    found: dict[str, Any] = {"ok": True, "port": board.port, "build": hello.build, "version": hello.version}
    found |= {"arena": hello.arena, "rate_Hz": board.rate, "latency_timer_s": latency.timer}
    try:
        settings = board.settings()
        kit = f"Kit {settings.label!r}, {_ORIGIN[Origin(settings.origin)]}"
        words.append(f"{kit}, {1e6 * settings.quantum:.1f} µm a count, limit {settings.max_force:.1f} N")
        found["settings"] = {f.name: getattr(settings, f.name) for f in Board.layout()}
        found["settings"]["origin"] = Origin(settings.origin).name.lower()
    except DeviceError as error:
        words.append(str(error).rstrip("."))
    return found | {"text": " ".join(f"{line}." for line in words) + f" {latency.words}".rstrip()}
