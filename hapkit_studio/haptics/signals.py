"""The signals: every quantity that a tick writes into its row is declared once.

This table defines the name, unit, scale and storage format for rows, session files, exported tables, plots,
cursors and the trigger. Its entries are in the order of the row's columns. In a row, the law's state
variables follow these columns.
"""

from dataclasses import dataclass

ALWAYS, ON_REQUEST, NEVER = "always", "on request", "never"
"""When a session records a signal."""


@dataclass(frozen=True)
class Signal:
    """A quantity in every row, in SI units.

    ``shown_unit`` is its unit in the window, and ``scale`` the number of such units per SI unit. Session
    files store integer multiples of ``step``, or 32-bit floats without a step. If ``in_counts`` is True,
    ``step`` is in units of the sensor's quantum. ``delta_to`` is another signal; session files store the
    difference between the two signals. ``whole`` is True if the values are integers. If ``extremes`` is True,
    session files store the extremes of every block for the overview plot. ``header`` is the column's name in
    exported tables if it is not the name with the unit. If ``gaps`` is True, plots show every single NaN as a
    gap, even if a pixel column contains many samples.
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
        """Return the column name in exported tables, such as "velocity_m_per_s"."""
        return self.header or "_".join(filter(None, (self.name, self.unit.replace("/", "_per_"))))


# energy is the work on the handle since the loop started. energy_given is the work on the handle since the
# passivity observer restarted. energy_limit is the largest energy that a passive scene could have given since
# the observer restarted. energy_given and energy_limit are NaN while the observer is inactive.
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
"""Column index of each signal in a row."""
