"""The document of the workbench, its commands, and the messages to the page: values and pure functions."""
