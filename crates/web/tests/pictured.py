"""Pictures of a page."""

import numpy as np

#: Longest time until a picture [ms].
PATIENCE = 120_000


def pictures(page):
    return int(page.evaluate("() => document.getElementById('canvas').dataset.pictures || 0"))


def await_picture(page, quality=None, after=0):
    page.wait_for_function(
        "([quality, after]) => { const d = document.getElementById('canvas').dataset; return d.pictures > after && (!quality || d.quality === quality) }",
        arg=[quality, after],
        timeout=PATIENCE,
    )


def pixels(page):
    """Colours of the canvas, height x width x 4."""
    data = page.evaluate(
        "() => { const c = document.getElementById('canvas'); return [c.width, c.height, Array.from(c.getContext('2d').getImageData(0, 0, c.width, c.height).data)] }"
    )
    return np.array(data[2], np.uint8).reshape(data[1], data[0], 4)


def change(page, action):
    """Colours before and after an action, when both are settled."""
    await_picture(page, "final")
    before, count = pixels(page), pictures(page)
    action()
    await_picture(page, "final", count)
    return before, pixels(page)
