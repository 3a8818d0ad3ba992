"""Stability limits of a rendered spring: exact limits, passivity, simulation, and a plane of all of them.

``limits`` computes closed forms. ``passivity`` computes limits that are safe with any hand. ``rendered``
finds limits by simulation. ``kb_plane`` shows all limits over stiffness and damping. ``margin`` describes the
distance from the limit as text, and ``on_board`` computes the limits of a board.
"""
