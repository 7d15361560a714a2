"""Plans: ways out of a mock-up, their order, access for tools, and the volume that a motion sweeps."""
