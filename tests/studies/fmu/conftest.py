import pytest

import apesim
from apesim.studies.fmu.library import find_compilers
from tests.studies.fmu.importer import Library


@pytest.fixture(scope="session")
def valve_fmus(tmp_path_factory):
    """The default machine's valve, by version of FMI."""
    if not find_compilers():
        pytest.skip("no C compiler is installed")
    folder = tmp_path_factory.mktemp("fmu")
    return {fmi: apesim.export_fmu(apesim.Machine(), "valve", folder / f"{fmi}.fmu", fmi=fmi) for fmi in (2, 3)}


@pytest.fixture(scope="session")
def library(valve_fmus, tmp_path_factory):
    return Library(valve_fmus[2].path, tmp_path_factory.mktemp("library"))
