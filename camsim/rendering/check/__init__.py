"""The check: photosites computed again from the scene itself; docs/rendering.md says what it shares with the engines."""
