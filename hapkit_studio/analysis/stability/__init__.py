"""Stability limits of a rendered spring: exact limits, passivity, simulation, and a plane of all of them.

limits: closed form; passivity: safe with any hand; rendered: by simulation; kb_plane: all of them over
stiffness and damping; margin: distance from the limit as text; on_board: limits of a board.
"""
