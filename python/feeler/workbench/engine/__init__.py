"""What the hand holds and meets: the mock-up as it stands, the moves of the hand, and questions of geometry."""
