"""Import Qt and numba: the part of a start that the studio cannot shorten, a reference for the rest."""

import numba  # noqa: F401
import PySide6.QtWidgets  # noqa: F401
