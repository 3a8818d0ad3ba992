"""Set up my Hapkit, and Test my Hapkit: dialogs that work on the board itself."""
