"""Stability limits of a rendered spring: exact limits, passivity, simulation, and a chart of all limits.

``limits`` computes closed forms. ``passivity`` computes limits that are safe with any hand. ``rendered``
finds limits by simulation. ``kb_plane`` shows all limits over stiffness and damping. ``margin`` describes the
distance from the limit as text, and ``on_board`` computes the limits of a board.
"""
