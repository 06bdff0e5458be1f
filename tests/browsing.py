"""Headless Chromium for the tests of pages, patient with a busy machine."""

from __future__ import annotations

import shutil
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

ARGUMENTS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update",
)  # fmt: skip
DRAWN = "html[data-figures=drawn]"
PATIENCE = 600_000  # ms, for what takes about two seconds on an idle machine


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    found = shutil.which("chromium") or shutil.which("google-chrome")
    assert found, "needs Chromium: sudo apt-get install -y chromium"
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(
            executable_path=found, args=list(ARGUMENTS), timeout=PATIENCE
        )
        yield started
        started.close()


def new_page(browser: Browser, **options: object) -> Page:
    """Open a page on which nothing is given up after Playwright's own 30 s."""
    page = browser.new_page(**options)
    page.set_default_timeout(PATIENCE)
    return page
