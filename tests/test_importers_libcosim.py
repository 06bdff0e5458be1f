"""libcosim loads and runs each FMU alone and all three coupled, and gets fmpy's bits."""

from __future__ import annotations

import pytest
from importer_cases import MODELS, differences, expected, of_states_only, ran_in

PROGRAM = "run_in_libcosim.py"


@pytest.mark.parametrize("model", MODELS)
def test_each_fmu_alone_gives_what_fmpy_gives(model: str) -> None:
    assert differences(ran_in(PROGRAM, "alone")[model], expected(model)) == {}


@pytest.mark.parametrize("model", MODELS)
def test_all_three_coupled_give_what_a_jacobi_master_gives(model: str) -> None:
    """Compared are functions of states: all that couples FMUs is one."""
    assert differences(ran_in(PROGRAM, "loop")[model], of_states_only(model)) == {}
