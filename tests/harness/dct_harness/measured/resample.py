"""Channels with several time axes onto one."""

from __future__ import annotations

import numpy as np

from ..errors import ConfigError, instant
from ..formats import Table
from .channels import Channel

MOST = 1e8  # samples; their times alone take 0.8 GB
ROUNDING = 1e-9  # of a step: an end this close to a multiple of the step is one


def common(
    channels: list[Channel], step: float | None, start: float | None, stop: float | None
) -> Table:
    """Return one table of all channels.

    Parameters
    ----------
    channels
        At least one.
    step
        Distance of the samples [s]; None keeps the axis that all channels share. Reals are
        interpolated, integers held.
    start, stop
        Part to keep [s], of the channels' own time; the result then starts at 0.

    Raises
    ------
    ConfigError
        The channels have several time axes and no step is given, share no time, or the step is
        too short.
    """
    first, last = _stretch(channels, start, stop)
    if step is None:
        axis = _shared(channels)
        axis = axis[(axis >= first) & (axis <= last)]
    elif (last - first) / step > MOST:
        raise ConfigError(f"step = {step:g} s: more than {MOST:g} samples; take a longer one")
    else:
        axis = first + np.arange(int((last - first) / step + ROUNDING) + 1) * step
    columns = [_at(channel, axis) for channel in channels]
    shown = axis - first if start is not None else axis
    units = {"time": "s"} | {c.name: c.unit for c in channels if c.unit}
    return Table(["time", *(c.name for c in channels)], np.column_stack([shown, *columns]), units)


def _stretch(
    channels: list[Channel], start: float | None, stop: float | None
) -> tuple[float, float]:
    """Return the first and the last instant [s] that all channels have and that are asked for."""
    low = max([c.time[0] for c in channels if len(c.time)], default=0.0)
    high = min([c.time[-1] for c in channels if len(c.time)], default=-1.0)
    if not all(len(c.time) for c in channels) or low > high:
        raise ConfigError("the channels share no stretch of time")
    first, last = (
        low if start is None else max(low, start),
        high if stop is None else min(high, stop),
    )
    if first > last:
        asked = "" if start is None else f" from {instant(start)} s on"
        asked += "" if stop is None else f" up to {instant(stop)} s"
        there = f"the channels share {instant(low)} s to {instant(high)} s"
        raise ConfigError(f"there is no sample{asked}: {there}")
    return first, last


def _shared(channels: list[Channel]) -> np.ndarray:
    axis = channels[0].time
    for channel in channels:
        if not np.array_equal(channel.time, axis):
            first = instant(np.setxor1d(channel.time, axis)[0])
            raise ConfigError(
                f"'{channel.name}' is sampled at other times than '{channels[0].name}'; give "
                f"--step to resample (t = {first} s is of one of them only)"
            )
    return axis


def _at(channel: Channel, axis: np.ndarray) -> np.ndarray:
    if channel.held:
        index = np.searchsorted(channel.time, axis, side="right") - 1
        return channel.values[np.clip(index, 0, len(channel.values) - 1)]
    return np.interp(axis, channel.time, channel.values)
