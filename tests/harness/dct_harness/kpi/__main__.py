"""Rewrite KPIS.md from the registry: `python -m dct_harness.kpi`."""

from .registry import DOCUMENT, markdown

DOCUMENT.write_text(markdown(), encoding="utf-8", newline="\n")
