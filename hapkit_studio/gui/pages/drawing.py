"""A widget that shows a matplotlib drawing of ``charts``, resizable and in the theme's colours."""

import warnings
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from PySide6.QtCore import QPointF, Qt, QTimer, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QSizePolicy, QToolTip, QWidget

from hapkit_studio.gui.widgets.parts import vbox
from hapkit_studio.gui.widgets.theme import theme

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.backend_bases import MouseEvent
    from numpy.typing import ArrayLike

    from hapkit_studio.charts.style import Paint

_NEAR = 16.0  # px: a point is near the pointer within this distance
_PAD = 10.0 / 72.0, 6.0 / 72.0  # inches: margin around the axes
# start of matplotlib's warning if the labels leave no space for the axes
_NO_ROOM = "constrained_layout not applied"
_PIXELS_AN_INCH = 72  # with this resolution, a size in points equals a size in pixels


class _Press(NamedTuple):
    """The start of a drag: the position, and the geometry of its axes at that time.

    A banner may shift the drawing during the drag. The stored geometry keeps the dragged value unchanged.
    """

    x: float
    y: float
    on_screen: QPointF
    box: Any
    to_data: Any


class Drawing(QWidget):
    """Shows a drawing; emits ``clicked`` and ``dragged`` in the axes' units.

    ``pointed`` is emitted with matplotlib's event, or with None when the pointer leaves the axes. The artists
    that a paint function returns are animated: ``follow`` redraws only them. ``pale``: the drawing is out of
    date.
    """

    clicked = Signal(float, float)
    dragged = Signal(float, float)
    pointed = Signal(object)

    def __init__(self, name: str, least: tuple[int, int] = (260, 120)):
        from matplotlib.backends.backend_qtagg import FigureCanvasQTAgg
        from matplotlib.figure import Figure
        from matplotlib.layout_engine import ConstrainedLayoutEngine

        super().__init__()
        self.figure = Figure(
            dpi=_PIXELS_AN_INCH, layout=ConstrainedLayoutEngine(w_pad=_PAD[0], h_pad=_PAD[1])
        )
        self.canvas = FigureCanvasQTAgg(self.figure)
        self.canvas.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self._least = least
        self._set_least()
        self.setAccessibleName(name)
        vbox(self.canvas, into=self)
        self._paint: Paint | None = None
        self.pale = self._old = False
        self.moving: list[Artist] = []
        self._ground: Any = None
        self._press: _Press | None = None
        self._soon = QTimer(self, interval=0, singleShot=True)
        self._soon.timeout.connect(self.redraw)
        theme.changed.connect(self._set_least)
        theme.changed.connect(self._outdate)
        connect = self.canvas.mpl_connect
        connect("draw_event", self._drawn)
        connect("resize_event", lambda _event: self.redraw())
        connect("button_press_event", self._pressed)
        connect("button_release_event", self._released)
        connect("motion_notify_event", self._moved)
        connect("axes_leave_event", lambda _event: self.pointed.emit(None))
        connect("figure_leave_event", lambda _event: self.pointed.emit(None))

    def _set_least(self) -> None:
        """Scale the minimum size with the size of the text."""
        self.setMinimumSize(*(theme.px(size) for size in self._least))

    def show_drawing(self, paint: "Paint", pale: bool = False) -> None:
        """Show another drawing; ``pale`` means that it is out of date."""
        self._paint, self.pale = paint, pale
        self._outdate()

    def fade(self) -> None:
        """Paint the drawing in pale colours to show that it is out of date."""
        self.pale = True
        self._outdate()

    def redraw(self) -> None:
        """Redraw now if visible, otherwise when the widget is next shown."""
        from hapkit_studio.charts import style

        self._soon.stop()
        self.figure.clear()
        self.moving, self._ground = [], None  # both are set again below
        canvas, least = self.canvas.size(), self.minimumSize()
        laid_out = canvas.width() >= least.width() and canvas.height() >= least.height()
        # before the layout is done, the widget may be too small for the axes; it is then drawn later
        self._old = not (self.isVisible() and laid_out)
        if self._old:
            return
        ratio, sharp = self.canvas.device_pixel_ratio, _PIXELS_AN_INCH * theme.scale
        self.figure.dpi = ratio * sharp
        self.figure.set_size_inches(canvas.width() / sharp, canvas.height() / sharp)
        colors = style.colors(theme.name)
        self.figure.set_facecolor(colors.surface)
        if self._paint is not None:
            try:
                with warnings.catch_warnings():
                    warnings.filterwarnings("error", _NO_ROOM)
                    moving: Any = self._paint(self.figure, style.pale(colors) if self.pale else colors)
            except UserWarning:  # the figure is too small while the window changes its size: draw later
                self.figure.clear()
                self._old = True
                return
            self.moving = list(moving or ())
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw_idle()

    def follow(self) -> None:
        """Redraw only the animated artists over the cached background."""
        if self._ground is None or self._soon.isActive():
            return
        self.canvas.restore_region(self._ground)
        self._draw_moving()
        self.canvas.blit(self.figure.bbox)

    def read(self, event: "MouseEvent | None", text: str = "") -> None:
        """Show a tooltip at the pointer; hide it without an event or text."""
        if event is not None and text:
            QToolTip.showText(event.guiEvent.globalPosition().toPoint(), text, self.canvas)
        else:
            QToolTip.hideText()

    def near(self, event: "MouseEvent", x: "ArrayLike", y: "ArrayLike") -> int | None:
        """Return the index of the point nearest to the pointer; None if none is within reach."""
        places = np.column_stack([x, y])
        if event.inaxes is None or not len(places):
            return None
        places = event.inaxes.transData.transform(places)
        away = np.hypot(*(places - (event.x, event.y)).T)
        nearest = int(np.nanargmin(away)) if np.isfinite(away).any() else 0
        return nearest if away[nearest] <= _NEAR * self.canvas.device_pixel_ratio else None

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._old:
            self._outdate()

    def _outdate(self) -> None:
        """Schedule a redraw through the event loop, so that several changes cause only one redraw."""
        self._old = True
        self._soon.start()

    def _drawn(self, _event: object) -> None:
        self._ground = self.canvas.copy_from_bbox(self.figure.bbox)
        self._draw_moving()

    def _draw_moving(self) -> None:
        for artist in self.moving:
            self.figure.draw_artist(artist)

    # pointer

    def _pressed(self, event: "MouseEvent") -> None:
        if event.button != 1 or event.inaxes is None or not event.inaxes.get_navigate():
            return
        axes, screen = event.inaxes, event.guiEvent.globalPosition()
        to_data = axes.transData.inverted().frozen()
        self._press = _Press(event.x, event.y, screen, axes.bbox.frozen(), to_data)
        self.clicked.emit(event.xdata, event.ydata)

    def _moved(self, event: "MouseEvent") -> None:
        self.pointed.emit(event if event.inaxes is not None else None)
        press = self._press
        if press is not None:
            away = (event.guiEvent.globalPosition() - press.on_screen) * self.canvas.device_pixel_ratio
            x = min(max(press.x + away.x(), press.box.x0), press.box.x1)
            y = min(max(press.y - away.y(), press.box.y0), press.box.y1)
            self.dragged.emit(*map(float, press.to_data.transform((x, y))))

    def _released(self, _event: object) -> None:
        self._press = None
