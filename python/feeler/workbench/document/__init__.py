"""What is drawn and known, how commands change it, and the messages that say so: values and pure functions."""
