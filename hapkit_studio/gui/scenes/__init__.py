"""Scenes: each environment drawn as what it is, one file a drawing, found by the name ``SCENE``."""

from hapkit_studio.gui.scenes.view import SceneView

__all__ = ["SceneView"]
