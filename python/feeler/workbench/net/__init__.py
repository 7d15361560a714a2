"""The server: who may connect, and what is sent to each page."""
