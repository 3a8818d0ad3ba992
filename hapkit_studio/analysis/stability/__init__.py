"""How stiff may a rendered spring be? Exact limits, passivity, rendering, and the plane of both.

limits: closed form; passivity: safe in any hand; rendered: by simulation; kb_plane: all of them over the
plane of stiffness and damping; margin: how far from the limit, in words; on_board: limits of a board.
"""
