"""Maintenance tasks: what holds a part."""
