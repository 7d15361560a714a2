"""The mock-up against itself: which pairs of parts clash, touch, are too near, hold each other or are the same."""
