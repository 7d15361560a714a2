"""The engine of the workbench: the present state of the mock-up, the moves of the hand, and geometric questions."""
