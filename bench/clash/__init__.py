"""The bench of clash checks: pairs that they get wrong, and what a whole assembly takes; feeler and its peers."""
