"""Set up my Hapkit, and Test my Hapkit: beside the window, on the board itself."""
