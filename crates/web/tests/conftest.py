"""A browser, the page on a server, and pages that fail on errors in their console.

`.ci/web` builds the page; BARNARD_WEB names its folder, target/web by default.
"""

import functools
import http.server
import os
import shutil
import threading
from pathlib import Path

import pytest

browsers = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
PAGE = Path(os.environ.get("BARNARD_WEB", Path(__file__).parents[3] / "target" / "web"))

if CHROMIUM is None or not (PAGE / "barnard_bg.wasm").exists():
    pytest.skip("NOT CHECKED: no Chromium, or no page (.ci/web builds it)", allow_module_level=True)


class Handler(http.server.SimpleHTTPRequestHandler):
    """Files of the page, with a policy that forbids eval."""

    def end_headers(self):
        self.send_header("Content-Security-Policy", "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; img-src 'self' data: blob:")
        super().end_headers()

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def address():
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=PAGE))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()


@pytest.fixture(scope="module")
def browser():
    with browsers.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser):
    """A small page without errors in its console."""
    page = browser.new_page(viewport={"width": 620, "height": 300}, accept_downloads=True)
    complaints = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda message: complaints.append(message.text) if message.type == "error" else None)
    yield page
    page.close()
    assert complaints == []
