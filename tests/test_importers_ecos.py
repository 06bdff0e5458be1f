"""ecos loads and runs each FMU alone and all three coupled, and gets fmpy's bits."""

from __future__ import annotations

import pytest
from importer_cases import LOOP_STEPS, MODELS, differences, expected, of_states_only, ran_in

PROGRAM = "run_in_ecos.py"


@pytest.mark.parametrize("model", MODELS)
def test_each_fmu_alone_gives_what_fmpy_gives(model: str) -> None:
    assert differences(ran_in(PROGRAM, "alone")[model], expected(model)) == {}


@pytest.mark.parametrize("step", LOOP_STEPS)
@pytest.mark.parametrize("model", MODELS)
def test_all_three_coupled_give_what_a_jacobi_master_gives(model: str, step: float) -> None:
    """Compared are functions of states: ecos samples the others after it has set new inputs."""
    found = ran_in(PROGRAM, "loop", step)[model]
    assert differences(found, of_states_only(model, step)) == {}
