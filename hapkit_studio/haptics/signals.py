"""The signals: every number that a tick writes into its row, declared once.

Rows, session files, tables for other programs, plots, cursors and trigger take name, unit, scale and storage
from here. The order is that of the row's columns; after them come the law's state variables.
"""

from dataclasses import dataclass

ALWAYS, ON_REQUEST, NEVER = "always", "on request", "never"
"""When a signal is recorded in a session."""


@dataclass(frozen=True)
class Signal:
    """A number of every row, in SI units.

    shown_unit, scale: its unit in the window, and how many of these one SI unit has.
    step: session files store multiples of it, without one 32-bit floats; in_counts: of the sensor's quantum.
    delta_to: session files store the difference to this signal, which it mostly equals.
    whole: its values are integers. extremes: session files keep the extremes of every block, to draw from.
    header: its column in tables for other programs, where that is not the name with the unit.
    gaps: a single NaN breaks its line in a plot, however many samples a column of pixels holds.
    """

    name: str
    unit: str = ""
    shown_unit: str = ""
    scale: float = 1.0
    step: float | None = None
    in_counts: bool = False
    delta_to: str = ""
    whole: bool = False
    recorded: str = ALWAYS
    extremes: bool = False
    header: str = ""
    gaps: bool = False

    @property
    def column_name(self) -> str:
        """Return the name of its column in tables for other programs, as "velocity_m_per_s"."""
        return self.header or "_".join(filter(None, (self.name, self.unit.replace("/", "_per_"))))


# energy: work on the handle since the loop began; energy_given: since the passivity observer restarted;
# energy_limit: the most that a passive scene could have given since then. Both are NaN without the observer.
SIGNALS = (
    Signal("tick", step=1.0, whole=True),
    Signal("time", "s", "s", step=1e-6),
    Signal("board_time", "s", "s", step=1e-6),
    Signal("position", "m", "mm", 1e3, in_counts=True, extremes=True),
    Signal("velocity", "m/s", "mm/s", 1e3, extremes=True),
    Signal("force", "N", "N", extremes=True, header="force_asked_N"),
    Signal("applied_force", "N", "N", delta_to="force", extremes=True, header="force_applied_N"),
    Signal("lateness", "s", "µs", 1e6, step=1e-6),
    Signal("compute", "s", "µs", 1e6, step=1e-7),
    Signal("energy", "J", "mJ", 1e3, extremes=True),
    Signal("energy_given", "J", "mJ", 1e3, step=1e-6, extremes=True, gaps=True),
    Signal("energy_limit", "J", "mJ", 1e3, step=1e-6, extremes=True, gaps=True),
    Signal("flags", step=1.0, whole=True),
    Signal("true_position", "m", "mm", 1e3, recorded=ON_REQUEST),
    Signal("true_velocity", "m/s", "mm/s", 1e3, recorded=ON_REQUEST),
    Signal("hand_force", "N", "N", recorded=ON_REQUEST),
    Signal("hand_target", "m", "mm", 1e3, recorded=ON_REQUEST),
    Signal("period", "s", "ms", 1e3, recorded=NEVER),
)
BY_NAME = {signal.name: signal for signal in SIGNALS}
COLUMN = {signal.name: column for column, signal in enumerate(SIGNALS)}
"""The column of each signal in a row."""
