"""Pictures of what was measured, one file a picture: large enough to read on a projector."""
