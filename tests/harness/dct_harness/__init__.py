"""Closed-loop harness for FMI 2.0 co-simulation FMUs."""

__version__ = "0.1.0"
