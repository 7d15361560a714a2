"""Measurements that back one claim of the documentation each; run once for it, and not by `make bench`."""
