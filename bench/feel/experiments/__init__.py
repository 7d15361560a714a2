"""What is felt: each module one experiment, plain data out, decided on simulated time.

`engine` and `tight` alone have a clock.
"""
