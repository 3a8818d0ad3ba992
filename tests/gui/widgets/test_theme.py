"""The theme: contrast computed from its colours, style changes, icons, numbers."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QStyleHints
from PySide6.QtWidgets import QPushButton

from hapkit_studio.gui.widgets import icons, style
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import MODES, TOKENS, luminance, table


def contrast(first: str, second: str) -> float:
    """Return the contrast ratio of two colours by WCAG 2.1."""
    light, dark = sorted((luminance(first), luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


STATED = {
    ("ink", "surface"): ((16.5, 14.6, 21), 4.5),
    ("ink2", "surface"): ((8.3, 9.4, 21), 4.5),
    ("ink3", "side"): ((5.4, 6.8, 17), 4.5),
    ("accent", "accentsoft"): ((5.6, 5.6, 8.2), 4.5),
    ("danger", "dangersoft"): ((5.5, 6.2, 7.4), 4.5),
    ("danger", "unstable"): ((5.4, 6.5, 7.2), 4.5),
    ("warn", "warnsoft"): ((5.9, 7.5, 9.3), 4.5),
    ("ok", "stable"): ((5.7, 7.0, 8.4), 4.5),
    ("onstop", "stop"): ((5.8, 5.3, 7.4), 4.5),
    ("edge", "surface"): ((3.9, 4.1, 21), 3.0),
    ("stop", "side"): ((5.5, 3.3, 7.4), 3.0),
    ("position", "plot"): ((6.2, 7.6, 9.5), 4.5),
    ("velocity", "plot"): ((5.8, 8.5, 9.0), 4.5),
    ("asked", "plot"): ((7.5, 8.0, 11.3), 4.5),
    ("applied", "plot"): ((5.2, 7.3, 7.1), 4.5),
    ("applied", "theory"): ((3.7, 4.3, 5.0), 3.0),
    ("edge", "plot"): ((3.9, 4.1, 21), 3.0),
}


@pytest.mark.parametrize("pair", STATED, ids="-".join)
def test_contrast_is_as_stated_in_the_design(pair):
    stated, need = STATED[pair]
    computed = [contrast(TOKENS[pair[0]][mode], TOKENS[pair[1]][mode]) for mode in range(3)]
    assert computed == pytest.approx(stated, rel=0.03)
    assert min(computed) >= need


# source: Machado, Oliveira, Fernandes (2009), matrices of severity 1 for linear RGB
VISION = {
    "protan": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deutan": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritan": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
# The design requires a colour difference of 40. Models of dichromacy differ by 1 or 2, and this model gives
# at least 39.5.
APART = 39.0


def lab(color: str, vision: str) -> np.ndarray:
    """Return CIE L*a*b* (D65) of a colour as a dichromat sees it."""
    channels = np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.array(VISION[vision]) @ linear, 0.0, 1.0)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    ratio = to_xyz @ seen / np.array([0.9505, 1.0, 1.089])
    f = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize("mode", MODES)
def test_force_colours_are_distinguishable_with_colour_blindness(vision, mode):
    colors = table(mode)
    distance = np.linalg.norm(lab(colors["applied"], vision) - lab(colors["asked"], vision))
    assert distance >= APART


def test_every_token_has_three_colours_and_the_style_sheet_uses_no_unknown_token(qapp):
    for name, colors in TOKENS.items():
        assert len(colors) == len(MODES), name
        assert all(QColor(color).isValid() and len(color) == 7 for color in colors), name
    for mode in MODES:
        theme.set_mode(mode)
        sheet = style.stylesheet()
        assert "@" not in sheet
        assert "%" not in sheet
        assert theme.tokens["accent"] in sheet


def test_icons_follow_the_theme(qapp):
    button = QPushButton()
    icons.bind(button, "record", "danger", 24)

    def middle() -> str:
        return button.icon().pixmap(24, 24).toImage().pixelColor(12, 12).name()

    theme.set_mode("light")
    assert middle() == TOKENS["danger"][0].lower()
    theme.set_mode("dark")
    assert middle() == TOKENS["danger"][1].lower()


def test_every_icon_is_drawn_in_the_requested_colour(qapp):
    for name in icons.names():
        picture = icons.pixmap(name, 24, "ink", 2.0)
        assert (picture.width(), picture.devicePixelRatio()) == (48, 2.0)
        image = picture.toImage()
        colors = (image.pixelColor(x, y) for x in range(48) for y in range(48))
        solid = [color.name() for color in colors if color.alpha() == 255]
        assert len(solid) > 20, name
        assert set(solid) == {TOKENS["ink"][0].lower()}, name


def test_the_theme_follows_the_system_until_it_is_set(qapp, monkeypatch):
    scheme = {"now": Qt.ColorScheme.Light}
    monkeypatch.setattr(QStyleHints, "colorScheme", lambda self: scheme["now"])
    style.apply(qapp)
    theme.set_mode("system")
    assert theme.name == "light"
    scheme["now"] = Qt.ColorScheme.Dark
    qapp.styleHints().colorSchemeChanged.emit(scheme["now"])
    assert theme.name == "dark"
    theme.set_mode("light")
    qapp.styleHints().colorSchemeChanged.emit(scheme["now"])
    assert theme.name == "light"


def test_several_changes_style_the_widgets_once_and_an_unchanged_theme_never(dressed):
    changes = []
    theme.changed.connect(lambda: changes.append((theme.name, theme.scale)))
    with theme.together():
        theme.set_mode("dark")
        theme.set_scale(1.5)
        assert changes == []
    assert changes == [("dark", 1.5)]
    with theme.together():
        theme.set_scale(1.5)
    theme.set_scale(1.0)
    assert changes == [("dark", 1.5), ("dark", 1.0)]
