"""Pictures rendered: fields of samples by their transforms (docs/pictures.md)."""
