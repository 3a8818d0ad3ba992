"""The Live view: the feed of rows, their history, the scene and the plots."""
