"""Gates of the closed loops: the compiled master beside other masters and beside itself.

Each ratio is of medians of one run. The first one cannot be reached while our loop on fmpy is as
quick as it is: the FMUs alone, which both loops call, cost more than the step that the limit
leaves. What they cost, and the limit as a step, stand beside; a plain loop on fmpy, which the limit
was meant for, is told below.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from exchanges import exchanges
from gate import Gate
from loops import SWEPT, Loops
from measure import Bench

FINE = 1e-3  # s
MEANT = 70.0  # times that a loop on fmpy was meant to cost, when ours was as slow as a plain one
FMUS, EMPTY = 3, 2  # FMUs of the loop, and of that which measures what the master costs itself


def loops(bench: Bench) -> list[Gate]:
    """Judge all of them."""
    made = Loops(bench.stop, bench.rounds)
    empty, master = Path(bench.empty_c.partition(";")[0]), around(made, bench)
    own = master.value * 1e-9
    return [
        *fmpy(made, own), *others(made), *threads(made), *exchanges(made, empty), master,
    ]  # fmt: skip


def fmpy(made: Loops, own: float) -> list[Gate]:
    """Our loop on fmpy, the compiled one, and a plain one on fmpy; `own`: the master's cost [s]."""
    ours, native, plain, bare = np.median(made.engines, axis=0) / made.steps * 1e6
    alone = bare - own * 1e6 * FMUS / EMPTY
    return [
        Gate("loop on fmpy / compiled master", ours / native, MEANT, at_least=True,
             beside=f"{ours:.3g} / {native:.3g} us per step of three FMUs; the limit is "
                    f"{ours / MEANT:.2g} us, the FMUs alone take {alone:.2g}"),
        Gate("plain FMU2Slave / compiled master", plain / native, None,
             beside=f"{plain:.3g} / {native:.3g} us per step; {plain / bare:.3g} x where no "
                    "signal is kept"),
        Gate("loop on fmpy / plain FMU2Slave", ours / plain, 0.6,
             beside=f"{ours:.3g} / {plain:.3g} us per step"),
    ]  # fmt: skip


def others(made: Loops) -> list[Gate]:
    """ecos, dask, and the compiled master from Python."""
    ecos, ours = np.median(made.in_ecos, axis=0) / made.steps * 1e6
    (dask, run), (dask_all, run_all) = made.sweeps
    row, loop = np.median(made.rows_of_a_sweep, axis=0) * 1e3
    python, alone = np.median(made.bulk, axis=0) / made.steps * 1e6
    return [
        Gate("ecos / compiled master", ecos / ours, 9.0, at_least=True,
             beside=f"{ecos:.3g} / {ours:.3g} us per step of three FMUs, none kept"),
        Gate("dask and fmpy / compiled master", dask_all / run_all, 90.0, at_least=True,
             beside=f"CPU time {dask_all:.3g} / {run_all:.3g} s per run, {SWEPT} runs on dask"),
        Gate("the same with the signals of KPIs", dask / run, None,
             beside=f"CPU time {dask:.3g} / {run:.3g} s per run, which a sweep records"),
        Gate("run of a sweep / its compiled loop", row / loop, 1.5,
             beside=f"CPU time {row:.3g} / {loop:.3g} ms; the rest is the plan, KPIs and the row"),
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
