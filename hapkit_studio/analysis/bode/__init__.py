"""Settings and columns of a Bode diagram, in a module that is quick to import."""

from hapkit_studio.columns import Column
from hapkit_studio.formatting import hertz
from hapkit_studio.parameters import Parameter

AMPLITUDE = Parameter("amplitude", "Amplitude", "m", 1e-3, 20e-6, 0.01, "Largest motion of the handle")
LINEAR = 0.9  # coherence below which a point is unreliable
COMPARED = 0.4  # fraction of Nyquist up to which measurement and theory are compared


def _from(frequency: float) -> str:
    return hertz(frequency) if frequency == frequency else "–"


CURVE_COLUMNS = (
    Column("Loop", lambda curve: curve.name.replace(", ", "\n"), right=False),
    Column("−3 dB", lambda curve: _from(curve.softens), lambda curve: curve.softens),
    Column("Damping\n< 0", lambda curve: _from(curve.negative), lambda curve: curve.negative),
    Column("Gives\nenergy", lambda curve: _from(curve.gives_energy), lambda curve: curve.gives_energy),
)
