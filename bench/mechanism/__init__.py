"""The bench of mechanisms: a door of the sample engine, what steps miss, and bounds against random positions."""
