"""The bench of clash checks: hard pairs, and times of whole assemblies; feeler and its peers."""
