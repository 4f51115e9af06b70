"""The check: photosites computed again from the scene itself (docs/rendering.md: what it shares with the engines)."""
