"""The check: photosites computed again from the scene itself (docs/mathematics.md: what it shares with the engines)."""
