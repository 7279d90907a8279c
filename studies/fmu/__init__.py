"""FMU: the march as a library of its own, without Python, behind the functions of the standard FMI.

In the order in which they build on one another: flat (parameters as a row of numbers), native (compiled into an object
file), model (what an FMU computes), valve_model, engine_model; platforms, step_object (compiled elsewhere, and kept),
parameters (keys of the machine that an importer may change), header (the machine, for the C sources in the folder c),
library (linked of all that), description (the XML), page (for readers), export (the FMU).
"""
