"""The server: access control, and the messages to each page."""
