"""Experiments on haptic forces, one per module. They return plain data and run on simulated time.

`engine` and `tight` also measure time.
"""
