"""What gives way where the window is small, in this order; every breakpoint stands here.

All sizes are device-independent pixels at the usual scale; in a large window everything grows by one factor.
"""

# a window larger than LARGE, both ways, has all of it larger by the same factor, in steps; one smaller than
# SMALL, as on a small screen with a scale of 150 or 200 %, has all of it smaller
LARGE, SMALL, _STEPS, _LARGEST, _SMALLEST = (1600, 900), (800, 560), 10, 2.5, 0.6

# a projector's picture: twice as large on a screen of this size, the scene with so much of the height
PROJECTED, _TWICE, _PROJECTED_LARGEST, _PROJECTED_SCENE = (1920, 1080), 2.0, 4.0, 0.367
_FREE_FOR_FEW_PLOTS = 230
PROJECTED_PHASE, PROJECTED_VALUES = 0.32, 0.21
"""Of the width: the force–position plot, the card of values."""
FRAME = 2
"""px of a thin line there."""

GAP = 12
"""Between cards, and around them."""

HEADER_HEIGHT, BANNER_HEIGHT = 52, 54
BANNERS = 2  # shown at once

# 1. a centre narrower than this makes the gallery a rail of icons and keys, and the panel narrow
CENTRE = 880
GALLERY, RAIL, GALLERY_MOST = 228, 64, 320
PANEL, PANEL_NARROW, PANEL_MOST = 300, 272, 440

# a lesson in the gallery's place is narrower in a window narrower than this, and so is the panel
LESSON, LESSON_NARROW, LESSON_WINDOW = 340, 300, 1440

# 2. scene height, with this much free below the banners
SCENE_LEAST, SCENE_LOW = 150, 180
_FREE_FOR_SCENE, _FREE_FOR_LOW_SCENE = 680, 480
# in a wide window the scene grows with its width, so that it keeps its proportions, while the plots have this
_USUAL_CENTRE, _FREE_FOR_PLOTS = 910, 430

# 3. header width: below the first its key caps go, tabs stand closer, and the device list is as wide as
# its words; below the second its icons go
KEY_CAPS, HEADER_ICONS = 1440, 1180

# 4. a centre narrower than this shows the force–position plot behind a switch; a law needs more beside it
PLOTS_BESIDE, LAW_BESIDE = 720, 1240
PHASE, _PHASE_SHARE, _PHASE_MOST = 348, 0.32, 680

# 5. a window smaller than this has its panel in a drawer; above a narrow one banners take the whole width
DRAWER_WIDTH, DRAWER_HEIGHT = 1280, 640
BANNERS_BESIDE_PANEL = 1100


def scale(width: int, height: int) -> float:
    """Return the factor by which everything is larger than usual, or smaller, in a window of so many px."""
    room = min(width / LARGE[0], height / LARGE[1])
    short = min(width / SMALL[0], height / SMALL[1])
    small = min(max(int(_STEPS * short + 1e-6) / _STEPS, _SMALLEST), 1.0)
    return min(max(int(_STEPS * room) / _STEPS, small), _LARGEST)


def projected_scale(width: int, height: int) -> float:
    """Return how many times larger than usual everything is on a projector of so many px."""
    room = _TWICE * min(width / PROJECTED[0], height / PROJECTED[1])
    return min(max(int(_STEPS * room + 1e-6) / _STEPS, 1.0), _PROJECTED_LARGEST)


def projected_scene(window: int, free: int) -> int:
    """Return the scene's height on a projector in a window of a height with so much free in its centre."""
    return max(min(round(_PROJECTED_SCENE * window), free - _FREE_FOR_FEW_PLOTS), SCENE_LEAST)


def gallery_width(window: float, gallery: float, panel: float) -> float:
    """Return the gallery's width, given what gallery and panel should have: a rail where room is short."""
    return RAIL if window - max(gallery, GALLERY) - max(panel, PANEL) < CENTRE else gallery


def lesson_width(window: float) -> int:
    """Return the width of a lesson in the gallery's place."""
    return LESSON if window >= LESSON_WINDOW else LESSON_NARROW


def scene_height(usual: int, width: int, free: int, law: bool | None) -> int:
    """Return the scene's height in a centre of so much width and free height.

    law: a page is in the plots' place, True for the law; None: no page is.
    """
    if law is not None:
        return SCENE_LOW if free >= _FREE_FOR_SCENE and law else SCENE_LEAST
    if free < _FREE_FOR_SCENE:
        return SCENE_LOW if free >= _FREE_FOR_LOW_SCENE else SCENE_LEAST
    return max(usual, min(round(usual * width / _USUAL_CENTRE), free - _FREE_FOR_PLOTS))


def phase_width(width: int) -> int:
    """Return the force–position plot's width in a centre of so much width."""
    return min(max(PHASE, round(_PHASE_SHARE * width)), _PHASE_MOST)
