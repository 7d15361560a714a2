"""The bench of the workbench: `feeler view` in a headless Chromium, measured as its users see it."""
