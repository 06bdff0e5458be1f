"""The gates of `cargo xtask bench`: one function per group, each a list of judged values.

The peers are C FMUs at -O2, `benches/peers`. Like is compared with like: DctPlant as it is, with
compliant transfer shafts, against an RK4 of the same ten states at 1/16 ms, the longest stable step
that divides a millisecond (at 0.1 ms it diverges); DctPlant with `transmission.rigid` against an
RK4 of the same rigid driveline at 0.1 ms. The peers have the plant's inputs with their rates and
its outputs, friction energies included, but not jerk, filtered acceleration and energy residual.

The rigid gate at 1 ms is kept by little: 22.4. Of the 1,057 instructions of a rigid exchange some
390 are the shell's and the driver's; a gate of 22 allows 1,078.

The worst step of the compliant plant, one with events, is a time, which others on the machine
lengthen more than the ordinary step of the peer, as it needs all of the ladder in the cache: 0.87
to 1.06 with six other programs on two cores. So is p99.9 over p50, in ticks of a clock of 10 ns:
1.38 to 1.59, 70 to 80 ns for most steps and 110 ns for those below walking pace with a slipping
clutch whose actuator moves.
"""

from __future__ import annotations

import gates_loops
import numpy as np
from gate import Gate
from isolation import isolation
from loops import FMUS
from measure import Bench, small_library

FINE, COARSE = 1e-3, 1e-2
# The worst relative difference at the end of a run that still makes the RK4 peer the same plant.
SAME_PLANT = 0.02


def ratios(bench: Bench) -> list[Gate]:
    """Exchanges against those of C FMUs: instructions are judged, CPU times stand beside."""
    gates = []
    for name, limit, at_least, h, over, under in (
        ("empty model / empty C FMU", 1.25, False, FINE, "empty", "empty_c"),
        ("plant at 1 ms / empty C FMU", 12.0, False, FINE, "plant", "empty_c"),
        ("RK4 in C / plant, 1 ms", 22.0, True, FINE, "rk4", "plant"),
        ("RK4 in C / plant, 10 ms", 140.0, True, COARSE, "rk4", "plant"),
        ("the same, both rigid, 1 ms", 22.0, True, FINE, "rk4_rigid", "rigid"),
        ("the same, both rigid, 10 ms", 140.0, True, COARSE, "rk4_rigid", "rigid"),
    ):
        pair = [getattr(bench, library) for library in (over, under)]
        counts = [bench.instructions(h, library) for library in pair]
        times = bench.cpu_times(h, *pair)
        ratio, cpu = counts[0] / counts[1], np.median(times[:, 0] / times[:, 1])
        beside = "{:.0f} / {:.0f} instructions; CPU time {:.0f} / {:.0f} ns = {:.3g} x".format(
            *counts, *np.median(times, axis=0), cpu
        )
        gates.append(Gate(name, ratio, limit, at_least=at_least, beside=beside))
    return gates


def steps(bench: Bench) -> list[Gate]:
    """How even the steps are, events included."""
    plant, rk4 = bench.least_times(FINE, bench.plant, bench.rk4)
    middle, high = np.percentile(plant, [50, 99.9])
    worst, ordinary = plant.max(), np.median(rk4)
    return [
        Gate("step p99.9 / p50", high / middle, 1.6, beside=f"{high:.0f} / {middle:.0f} ns"),
        Gate("worst step / RK4's ordinary one", worst / ordinary, 1.0,
             beside=f"{worst:.0f} / {ordinary:.0f} ns"),
    ]  # fmt: skip


def starts(bench: Bench) -> list[Gate]:
    """Instantiate and initialise."""
    known, new = bench.starts / 1e3
    return [
        Gate("start, known parameters", known, 0.3, "us"),
        Gate("start, new parameters", new, 120.0, "us"),
    ]


def memory(bench: Bench) -> list[Gate]:
    """Heap and library."""
    heap = bench.heap
    one, shared = heap["kin_bytes"], heap["other_bytes"] - heap["kin_bytes"]
    spare = heap["first_bytes"] - heap["other_bytes"]
    small, usual = (path.stat().st_size / 1024 for path in (small_library(), bench.library))
    return [
        Gate("heap calls in exchanges", heap["exchanges"], 0, "calls"),
        Gate("heap calls in a first stop", heap["brake"], 0, "calls"),
        Gate("heap calls in new step sizes", heap["new_steps"], 0, "calls"),
        Gate("heap of an instance", one / 1024, 1.0, "KiB"),
        Gate("heap of a parameter set", shared / 1024, 128.0, "KiB",
             beside=f"and {spare / 1024:.0f} KiB once per library, for new step sizes"),
        Gate("library, stripped (--small)", small, 400.0, "KiB",
             beside=f"without --small {usual:.0f} KiB"),
    ]  # fmt: skip


def check_peer(bench: Bench) -> None:
    """Refuse to compare with a peer that is not the same plant.

    Raises
    ------
    SystemExit
        When a speed at the end of the run differs too much.
    """
    for plant, peer in ((bench.plant, bench.rk4), (bench.rigid, bench.rk4_rigid)):
        ours, theirs = (bench.last_outputs(library)[:4] for library in (plant, peer))
        apart = np.abs(ours - theirs) / np.abs(ours).max()
        if not apart.max() < SAME_PLANT:
            raise SystemExit(f"an RK4 peer ends at {theirs}, the plant at {ours}")


def measured(bench: Bench) -> list[Gate]:
    """Every gate, in the order of the table."""
    check_peer(bench)
    return [
        *ratios(bench),
        *steps(bench),
        *starts(bench),
        *memory(bench),
        *gates_loops.loops(bench),
        *isolation(FMUS / "DctPlant.fmu"),
    ]


def table(gates: list[Gate]) -> str:
    """The gates as a table for people."""
    lines = [f"{'gate':32} {'value':>9} {'limit':>12}"]
    for gate in gates:
        limit, verdict = "", ""
        if gate.limit is not None:
            limit = f"{'>=' if gate.at_least else '<='} {gate.limit:g} {gate.unit}"
            verdict = "pass" if gate.passed else "MISSED"
        lines.append(
            f"{gate.name:32} {gate.value:9.4g} {limit:>12}  {verdict:6}  {gate.beside}".rstrip()
        )
    return "\n".join(lines)
