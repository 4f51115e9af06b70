"""Images as sums over spatial frequencies: any source, any transfer."""
