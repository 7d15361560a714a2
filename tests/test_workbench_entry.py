"""What a person types in fields of the page, and how it is shown: ranges, small figures, long names, the focus."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from browser import SCHEMES, document, opened, picture, program, settled, wait

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def luminance(pixels: np.ndarray) -> np.ndarray:
    """Relative luminance as of WCAG."""
    share = pixels / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4) @ LUMINANCE


def test_what_is_seen_through_is_seen_in_light_and_dark(context: Any, stand: Path) -> None:
    """Parts that are out, too. The luminance of their faces to that of the background is at least 1.15 to 1."""
    with program(stand) as started:
        page = opened(context, started)
        page.locator("#picture").focus()
        for scheme in SCHEMES:
            page.emulate_media(color_scheme=scheme)
            seen = []
            for key, state in (("x", "ghost"), ("h", "hidden")):
                for pressed in ("Control+a", key, "Escape"):
                    page.keyboard.press(pressed)
                wait(page, "state => window.feeler.document[state].length === 4", state)
                settled(page)
                seen.append(luminance(picture(page)) + 0.05)
            page.keyboard.press("Alt+h")
            wait(page, "() => window.feeler.document.hidden.length + window.feeler.document.ghost.length === 0")
            contrast = np.maximum(*seen) / np.minimum(*seen)
            assert (contrast > 1.15).mean() > 0.15, (scheme, "what is not seen has no contrast")
