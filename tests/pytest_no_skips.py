"""Pytest plugin: a skipped or expected-to-fail test is a failed check.

`cargo xtask test` loads it with `-p pytest_no_skips`. Whatever a test needs, the set-up installs;
a test that could not run has checked nothing and must not look green.
"""

from __future__ import annotations

import pytest


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> object:
    """Turn the report of a skipped test into a failure that shows why it was skipped."""
    report = yield
    if report.skipped:
        report.outcome = "failed"
        report.longrepr = f"{item.nodeid} did not run: {call.excinfo.value if call.excinfo else ''}"
        report.wasxfail = ""
        del report.wasxfail
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> object:
    """Do the same for a module that is skipped as a whole, e.g. by `importorskip`."""
    report = yield
    if report.skipped:
        report.outcome = "failed"
        report.longrepr = f"{collector.nodeid} was not collected: {report.longrepr}"
    return report
