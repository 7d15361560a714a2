"""What is felt: each module one experiment, plain data out, decided on simulated time (`engine` alone has a clock)."""
