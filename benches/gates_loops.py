"""Gates of the closed loops: the compiled master beside other masters and beside itself.

Each ratio is of medians of one run. A loop on fmpy that is quick works against the first one: what
it is to a plain loop on fmpy stands below it, and what the compiled master is to that one, beside.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from exchanges import exchanges
from gate import Gate
from loops import SWEPT, Loops
from measure import Bench

FINE = 1e-3  # s


def loops(bench: Bench) -> list[Gate]:
    """Judge all of them."""
    made = Loops(bench.stop, bench.rounds)
    empty = Path(bench.empty_c.partition(";")[0])
    return [
        *fmpy(made), *others(made), *threads(made), *exchanges(made, empty), around(made, bench),
    ]  # fmt: skip


def fmpy(made: Loops) -> list[Gate]:
    """Our loop on fmpy, the compiled one, and a plain one on fmpy."""
    ours, native, plain = np.median(made.engines, axis=0) / made.steps * 1e6
    return [
        Gate("loop on fmpy / compiled master", ours / native, 70.0, at_least=True,
             beside=f"{ours:.3g} / {native:.3g} us per step of three FMUs; a plain FMU2Slave "
                    f"loop is {plain / native:.3g} x"),
        Gate("loop on fmpy / plain FMU2Slave", ours / plain, 0.6,
             beside=f"{ours:.3g} / {plain:.3g} us per step"),
    ]  # fmt: skip


def others(made: Loops) -> list[Gate]:
    """ecos, dask, and the compiled master from Python."""
    ecos, ours = np.median(made.in_ecos, axis=0) / made.steps * 1e6
    dask, run = made.sweeps
    python, alone = np.median(made.bulk, axis=0) / made.steps * 1e6
    return [
        Gate("ecos / compiled master", ecos / ours, 9.0, at_least=True,
             beside=f"{ecos:.3g} / {ours:.3g} us per step of three FMUs, none kept"),
        Gate("dask and fmpy / compiled master", dask / run, 90.0, at_least=True,
             beside=f"CPU time {dask:.3g} / {run:.3g} s per run, {SWEPT} runs on dask"),
        Gate("compiled, from Python / without", python / alone, 1.25,
             beside=f"{python:.3g} / {alone:.3g} us per step"),
    ]  # fmt: skip


def threads(made: Loops) -> list[Gate]:
    """Many runs at a time."""
    one, two = np.median(made.threads, axis=0)
    return [
        Gate("run on 2 threads / on 1", two / one, 1.1,
             beside=f"CPU time {two * 1e3:.3g} / {one * 1e3:.3g} ms per run"),
    ]  # fmt: skip


def around(made: Loops, bench: Bench) -> Gate:
    """What the master costs beside the FMUs."""
    spent = made.nothing(Path(bench.empty_c.partition(";")[0])) * 1e9
    alone = 2 * np.median(bench.cpu_times(FINE, bench.empty_c))
    return Gate("master around two empty FMUs", spent - alone, 40.0, "ns",
                beside=f"{spent:.0f} ns per step, {alone:.0f} of them in the FMUs")  # fmt: skip
