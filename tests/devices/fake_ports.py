"""Fake lists of the system's serial ports."""

from types import SimpleNamespace

from hapkit_studio.devices import serial_ports

FT232 = (0x0403, 0x6001)
UNO = (0x2341, 0x0043)
CH340 = (0x1A86, 0x7523)


def info(device, numbers=(None, None), serial=None, place=None, product=None, description="n/a"):
    """Return one port's entry; without ``numbers`` the port is not on USB."""
    vendor, number = numbers
    hwid = f"USB VID:PID={vendor:04X}:{number:04X}" if vendor else "PNP0501"
    return SimpleNamespace(
        device=device, vid=vendor, pid=number, serial_number=serial, location=place, product=product,
        description=description, hwid=hwid,
    )  # fmt: skip


def list_ports(monkeypatch, *known):
    """Replace the system's ports by these ports."""
    monkeypatch.setattr(serial_ports.list_ports, "comports", lambda: list(known))
