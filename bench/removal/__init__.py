"""The bench of removal and access: how long ways out take, beside a library of planners."""
