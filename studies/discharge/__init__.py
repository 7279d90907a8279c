"""The effective area of a solenoid valve from discharge tests: Eqs. 9 and 10 of doi 10.1631/jzus.A0820373.

A vessel empties through the valve to atmosphere. A test tells nothing below a small multiple of the ambient pressure,
and nothing once half the band is too wide a share of the area at full opening; both cut-offs are stated.

In the order in which they build on one another: vessel (the law), records (the tests), area (the fit and its band),
wall (the heat that it gives), opening (the curve), collapse (of the curves of several tests), evaluation, summary
(table and JSON), effective_area (the result), figures.
"""

from apesim.studies.discharge.area import fit_area
from apesim.studies.discharge.evaluation import Discharge, discharge, figure_arrays
from apesim.studies.discharge.records import Record, read_test, read_tests
from apesim.studies.discharge.vessel import Vessel

__all__ = ["Discharge", "Record", "Vessel", "discharge", "figure_arrays", "fit_area", "read_test", "read_tests"]
