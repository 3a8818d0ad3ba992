"""All colours of window and figures. Each token has a light, a dark and a high-contrast colour."""

MODES = ("light", "dark", "contrast")

# fmt: off
TOKENS: dict[str, tuple[str, str, str]] = {
    # surfaces and text
    "canvas":     ("#E9EDF2", "#0E1318", "#FFFFFF"),
    "surface":    ("#FFFFFF", "#182028", "#FFFFFF"),
    "side":       ("#F6F8FA", "#131A21", "#FFFFFF"),
    "line":       ("#D3DAE2", "#2B3641", "#000000"),
    "edge":       ("#76828F", "#71808F", "#000000"),
    "ink":        ("#15202B", "#EEF2F6", "#000000"),
    "ink2":       ("#43505D", "#BBC5CF", "#000000"),
    "ink3":       ("#5A6774", "#97A3AF", "#1C1C1C"),
    # disabled controls
    "off":        ("#5A6774", "#97A3AF", "#6B6B6B"),
    "offedge":    ("#D3DAE2", "#2B3641", "#8C8C8C"),
    # semantic
    "accent":     ("#0A5AA8", "#6DB3F7", "#003B8E"),
    "accentsoft": ("#DCEAF8", "#1B3653", "#D6E6FF"),
    "onaccent":   ("#FFFFFF", "#0B1620", "#FFFFFF"),
    "danger":     ("#B4231B", "#FF8A7E", "#9B0000"),
    "dangersoft": ("#FDE7E4", "#46201D", "#FDE7E4"),
    "warn":       ("#855000", "#F6BF57", "#5E3600"),
    "warnsoft":   ("#FFF0D2", "#40310F", "#FFF0D2"),
    "ok":         ("#19683A", "#63CF93", "#004D22"),
    "oksoft":     ("#DFF3E6", "#153826", "#DFF3E6"),
    "stop":       ("#C3261C", "#C9302A", "#B00000"),
    "onstop":     ("#FFFFFF", "#FFFFFF", "#FFFFFF"),
    "stoprim":    ("#8E150D", "#FF8A7E", "#000000"),
    # plots
    "plot":       ("#FFFFFF", "#182028", "#FFFFFF"),
    "grid":       ("#E6EAEF", "#26303A", "#D0D5DA"),
    "axis":       ("#43505D", "#BBC5CF", "#000000"),
    "contact":    ("#EEF3F8", "#1E2A35", "#E6EEF7"),
    "position":   ("#0A62AE", "#67B7F7", "#003F9E"),
    "velocity":   ("#00735C", "#41D1A7", "#00543E"),
    "applied":    ("#C2410C", "#FF8F52", "#A62B00"),
    "asked":      ("#7B3794", "#D9A0EC", "#5C0E84"),
    "hold":       ("#6B7783", "#97A3AF", "#3C3C3C"),
    "theory":     ("#D5DCE3", "#3A4650", "#D3D9DF"),
    "energy":     ("#8A6100", "#F6BF57", "#5E3600"),
    "lecture":    ("#B0226B", "#F58CC0", "#7A0F46"),
    # scenes: fixed objects are blue, moving objects amber
    "scene":      ("#F9FBFC", "#141B22", "#FFFFFF"),
    "scenegrid":  ("#EBEFF3", "#1C252E", "#E3E7EB"),
    "rail":       ("#8A96A3", "#71808F", "#000000"),
    "handle":     ("#26333F", "#E4EAF0", "#000000"),
    "ridge":      ("#6F7F8E", "#8797A6", "#8C8C8C"),
    "ghost":      ("#9BA7B3", "#5B6875", "#6B6B6B"),
    "mat":        ("#C9D6E3", "#31465B", "#C4D4E6"),
    "mat2":       ("#9FB3C7", "#4A6680", "#8EA9C6"),
    "matline":    ("#4A6077", "#9DB9D3", "#1D3A5C"),
    "obj":        ("#F1C873", "#C79A3D", "#F1C873"),
    "objline":    ("#7A5A12", "#FFE3A1", "#7A5A12"),
    # regions of a map
    "stable":     ("#DDEFE3", "#173428", "#DDEFE3"),
    "passive":    ("#B9DFC8", "#1F5A40", "#B9DFC8"),
    "unstable":   ("#FBE3DE", "#3A211F", "#FBE3DE"),
}
# fmt: on


def table(mode: str) -> dict[str, str]:
    """Return the colours of one of MODES as "#RRGGBB", by token."""
    column = MODES.index(mode)
    return {name: colors[column] for name, colors in TOKENS.items()}


def paler(color: str, ground: str, share: float = 0.4) -> str:
    """Return a mixture of two colours "#RRGGBB"; ``share`` is the weight of the first one."""
    pairs = ((int(color[i : i + 2], 16), int(ground[i : i + 2], 16)) for i in (1, 3, 5))
    return "#" + "".join(f"{round(share * a + (1.0 - share) * b):02X}" for a, b in pairs)


def luminance(color: str) -> float:
    """Return the relative luminance of "#RRGGBB" (WCAG 2.1)."""
    channels = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
