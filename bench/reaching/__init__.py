"""The bench of the tool catalogue: `feeler.access` with all its tools."""
