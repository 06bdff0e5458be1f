"""ecos and libcosim load and run each FMU alone and all three coupled, and get fmpy's bits."""

from __future__ import annotations

import pytest
from importer_cases import LOOP_STEPS, MODELS, differences, expected, of_states_only, ran_in

IMPORTERS = pytest.mark.parametrize("importer", ["ecos", "libcosim"])


@IMPORTERS
@pytest.mark.parametrize("model", MODELS)
def test_each_fmu_alone_gives_what_fmpy_gives(importer: str, model: str) -> None:
    assert differences(ran_in(importer, "alone")[model], expected(model)) == {}


@IMPORTERS
@pytest.mark.parametrize("step", LOOP_STEPS)
@pytest.mark.parametrize("model", MODELS)
def test_all_three_coupled_give_what_a_jacobi_master_gives(
    importer: str, model: str, step: float
) -> None:
    """Compared are functions of states: ecos samples the others after it has set new inputs."""
    found = ran_in(importer, "loop", step)[model]
    assert differences(found, of_states_only(model, step)) == {}
