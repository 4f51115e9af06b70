"""The Fourier engine: any lens and any photosite, by the scene's exact transform (docs/mathematics.md)."""
