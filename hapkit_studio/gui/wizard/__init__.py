"""The dialogs *Set up my Hapkit* and *Test my Hapkit*, which work on the board itself."""
