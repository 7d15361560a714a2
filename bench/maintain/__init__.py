"""Nightly runs: the sample engine and the sample gearbox, in full, unchanged, and with one part in a hundred moved."""
