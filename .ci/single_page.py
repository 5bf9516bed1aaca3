"""Joins the page of the explorer into one file: single_page.py FOLDER writes FOLDER/barnard.html.

It opens from a disk and works offline. `barnard html` adds a scene at the mark.
"""

import base64
import gzip
import pathlib
import re
import sys

folder = pathlib.Path(sys.argv[1])


def text(name):
    content = (folder / name).read_text()
    assert "</script" not in content, f"{name} would end its element"
    return content


def replaced(page, old, new):
    assert page.count(old) == 1, old
    return page.replace(old, new)


page = (folder / "index.html").read_text()
page = replaced(page, '<link rel="stylesheet" href="style.css">', f"<style>\n{(folder / 'style.css').read_text()}</style>")
# No time of day, so that equal input gives equal bytes.
module = base64.b64encode(gzip.compress((folder / "barnard_bg.wasm").read_bytes(), 9, mtime=0)).decode()
first, *others = re.findall(r'<script src="(.*?)"></script>\n', page)
data = f"""<!-- scene -->
<script type="text/plain" id="barnard-module">{module}</script>
<script type="text/plain" id="barnard-worker">
{text("barnard.js")}
{text("worker.js")}</script>
<script>
{text("single.js")}</script>
"""
for name in [first, *others]:
    inline = f"<script>\n{text(name)}</script>\n"
    page = replaced(page, f'<script src="{name}"></script>\n', data + inline if name == first else inline)
(folder / "barnard.html").write_text(page)
