"""Breakpoints: the window sizes below which parts are hidden or made smaller.

The numbers in the comments give the order of these changes. All sizes are device-independent pixels at scale
1. In a large window, all parts grow by the same factor.
"""

# A window that is larger than LARGE in both directions is scaled up in steps. A window that is smaller than
# SMALL, for example on a small screen with a scale of 150 or 200 %, is scaled down.
LARGE, SMALL, _STEPS, _LARGEST, _SMALLEST = (1600, 900), (800, 560), 10, 2.5, 0.6

# The projector view is drawn at twice the size on a screen of the size PROJECTED. The last value is the
# scene's fraction of the height.
PROJECTED, _TWICE, _PROJECTED_LARGEST, _PROJECTED_SCENE = (1920, 1080), 2.0, 4.0, 0.367
_FREE_FOR_FEW_PLOTS = 230
PROJECTED_PHASE, PROJECTED_VALUES = 0.32, 0.21
"""Fractions of the projector's width for the force–position plot and the card of values."""
FRAME = 2
"""px: width of thin lines in the projector view."""

GAP = 12
"""px: distance between cards, and margin around them."""

HEADER_HEIGHT, BANNER_HEIGHT = 52, 54
BANNERS = 2  # maximum number of banners shown at a time

# 1. If the centre is narrower than CENTRE, the gallery becomes a rail of icons and keys, and the panel
# becomes narrower.
CENTRE = 880
GALLERY, RAIL, GALLERY_MOST = 228, 64, 320
PANEL, PANEL_NARROW, PANEL_MOST = 300, 272, 440

# In a window narrower than LESSON_WINDOW, the lesson (in place of the gallery) and the panel are narrower.
LESSON, LESSON_NARROW, LESSON_WINDOW = 340, 300, 1440

# 2. If the free height below the banners is small, the scene has one of these heights, in px.
SCENE_LEAST, SCENE_LOW = 150, 180
_FREE_FOR_SCENE, _FREE_FOR_LOW_SCENE = 680, 480
# In a wide window the scene grows with its width, provided that the plots keep this height.
_USUAL_CENTRE, _FREE_FOR_PLOTS = 910, 430

# 3. In a header narrower than KEY_CAPS, key caps are hidden, tabs are closer together, and the device list is
# as wide as its text. In a header narrower than HEADER_ICONS, icons are hidden, too.
KEY_CAPS, HEADER_ICONS = 1440, 1180

# 4. If the centre is narrower than PLOTS_BESIDE, a switch selects the time plots or the force–position plot.
# Beside a law, the force–position plot needs a centre at least LAW_BESIDE wide.
PLOTS_BESIDE, LAW_BESIDE = 720, 1240
PHASE, _PHASE_SHARE, _PHASE_MOST = 348, 0.32, 680

# 5. If the window is smaller than DRAWER_WIDTH or DRAWER_HEIGHT, its panel is a drawer. In a window narrower
# than BANNERS_BESIDE_PANEL, banners have the whole width.
DRAWER_WIDTH, DRAWER_HEIGHT = 1280, 640
BANNERS_BESIDE_PANEL = 1100


def scale(width: int, height: int) -> float:
    """Return the scale factor of a window of this size in px."""
    room = min(width / LARGE[0], height / LARGE[1])
    short = min(width / SMALL[0], height / SMALL[1])
    small = min(max(int(_STEPS * short + 1e-6) / _STEPS, _SMALLEST), 1.0)
    return min(max(int(_STEPS * room) / _STEPS, small), _LARGEST)


def projected_scale(width: int, height: int) -> float:
    """Return the scale factor of a projector view of this size in px."""
    room = _TWICE * min(width / PROJECTED[0], height / PROJECTED[1])
    return min(max(int(_STEPS * room + 1e-6) / _STEPS, 1.0), _PROJECTED_LARGEST)


def projected_scene(window: int, free: int) -> int:
    """Return the scene's height in the projector view for the window's height and the free height."""
    return max(min(round(_PROJECTED_SCENE * window), free - _FREE_FOR_FEW_PLOTS), SCENE_LEAST)


def gallery_width(window: float, gallery: float, panel: float) -> float:
    """Return the gallery's width for preferred widths of gallery and panel.

    If there is little space, this is the width of the rail.
    """
    return RAIL if window - max(gallery, GALLERY) - max(panel, PANEL) < CENTRE else gallery


def lesson_width(window: float) -> int:
    """Return the width of a lesson, which takes the place of the gallery."""
    return LESSON if window >= LESSON_WINDOW else LESSON_NARROW


def scene_height(usual: int, width: int, free: int, law: bool | None) -> int:
    """Return the scene's height in a centre of this width and free height.

    ``law`` is True if the law replaces the plots, False if another page does, and None if the plots are
    visible.
    """
    if law is not None:
        return SCENE_LOW if free >= _FREE_FOR_SCENE and law else SCENE_LEAST
    if free < _FREE_FOR_SCENE:
        return SCENE_LOW if free >= _FREE_FOR_LOW_SCENE else SCENE_LEAST
    return max(usual, min(round(usual * width / _USUAL_CENTRE), free - _FREE_FOR_PLOTS))


def phase_width(width: int) -> int:
    """Return the force–position plot's width in a centre of this width."""
    return min(max(PHASE, round(_PHASE_SHARE * width)), _PHASE_MOST)
