"""Scenes: drawings of the environments. Each file declares one drawing, discovered by the name ``SCENE``."""

from hapkit_studio.gui.scenes.view import SceneView

__all__ = ["SceneView"]
