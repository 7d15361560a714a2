"""The Chromium of the bench, the tests and the documentation's pictures, and its drawing options."""

from __future__ import annotations

import os
import shutil

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    # Else the software renderer also composes the page, and copies each frame.
    "--disable-gpu-rasterization",
    "--disable-gpu-compositing",
)


def found() -> str | None:
    """The path of one: $FEELER_CHROMIUM, or one on the PATH; None where there is none."""
    return os.environ.get("FEELER_CHROMIUM") or next((path for name in NAMES if (path := shutil.which(name))), None)
