"""What a board says about itself, as the loop and the stability limits take it."""

from hapkit_studio.errors import DeviceError
from hapkit_studio.protocol.messages import Hello


class BoardConstants:
    """The constants in a board's Hello, and the usual ones where it has none."""

    title: str
    mass = 0.044
    """kg at the handle, the kit's usual value."""
    viscous = 0.5
    """N·s/m at the handle, usual value."""
    coulomb_force = 0.10
    """N at the handle, usual value."""
    _hello: Hello | None = None

    @property
    def hello(self) -> Hello:
        """What the board said about itself; DeviceError before open."""
        if self._hello is None:
            raise DeviceError(f"{self.title} is not open.")
        return self._hello

    @property
    def max_force(self) -> float:
        return self.hello.max_force

    @property
    def quantum(self) -> float:
        return self.hello.quantum

    @property
    def rate(self) -> float:
        """Samples per second, set by the board's clock."""
        return float(self.hello.sample_rate)

    @property
    def full_force(self) -> float:
        """Force at full duty [N]; at duty d it is full_force * d^2 (reference: torque = C * duty^2)."""
        h = self.hello
        return h.motor_constant * h.sector_radius / (h.handle_radius * h.pulley_radius)
