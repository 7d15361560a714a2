"""Tasks: plans of random assemblies against exhaustive search."""
