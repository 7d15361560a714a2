"""The bench of removal and access: times to find removal paths, beside a library of planners."""
