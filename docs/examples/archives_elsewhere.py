"""
Archives without apesim
=======================

An archive is an HDF5 file that is also netCDF-4. This example writes one with apesim and then reads it with h5py,
xarray and pandas alone: axes, units, meanings of flags, provenance and digest.
"""

import json
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import xarray as xr

import apesim

out = Path("out")
out.mkdir(exist_ok=True)
path = out / "elsewhere.h5"
apesim.sweep(apesim.Machine(), "600:1500:300 rpm", intake=["epv", "cam"], timing="fixed", out=path, overwrite=True)

# %%
# From here on apesim is not used.
#
# h5py: what is in the file
# -------------------------
# Each quantity is a dataset over the runs; traces have the crank angle as a second axis. The attribute ``units`` says
# the unit, ``long_name`` what it is. The name ends in the SI unit, too.

with h5py.File(path) as file:
    for name in ("speed_rpm", "brake_torque_Nm", "lift", "cylinder_pressure"):
        data = file[name]
        unit, axes = data.attrs["units"].decode(), data.attrs["axes"].decode()
        print(f"/{name:18} {data.shape!s:10} over {axes:16} [{unit}]  {data.attrs['long_name'].decode()}")
    actuation = file["actuation"]
    meanings = dict(zip(actuation.attrs["flag_values"], actuation.attrs["flag_meanings"].decode().split(), strict=True))
    words = [meanings[code] for code in actuation[:]]
    provenance = json.loads(file["about/provenance"][0].decode())
    digest = file.attrs["content_sha256"].decode()
print("flags of actuation:", {int(code): word for code, word in meanings.items()})
print("made by:", provenance["command"])
print("with apesim", provenance["apesim"], "and numba", provenance["numba"], "on", provenance["processor"])
print("digest:", digest)

# %%
# The digest is a SHA-256 over all that was stored. Note it, and you know later that nothing has changed. The machine
# file stands in ``/about/machine``.
#
# xarray: one operating point
# ---------------------------
# ``engine="h5netcdf"`` reads the file as netCDF-4, with coordinates and units of the CF conventions.

with xr.open_dataset(path, engine="h5netcdf") as runs:
    runs.load()
runs = runs.assign_coords(word=("run", words))
point = runs.isel(run=int(np.flatnonzero((runs["word"] == "epv") & (runs["speed_rpm"] == 900.0))[0]))
figure, axis = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
axis.plot(point["crank_angle"], 1e3 * point["lift"])
axis.set(xlabel=f"{point['crank_angle'].long_name} [{point['crank_angle'].units}]", ylabel="lift [mm]")
axis.set_title(f"{point['word'].item()}, {point['speed_rpm'].item():.0f} r/min")

# %%
# pandas: a table of all runs
# ---------------------------

scalars = [name for name, variable in runs.data_vars.items() if variable.dims == ("run",)]
table = pd.DataFrame({name: runs[name].values for name in ["speed_rpm", *scalars]}, index=runs["word"].values)
print(table[["speed_rpm", "brake_torque_Nm", "specific_air_kg_per_kWh", "warnings"]].round(2).to_string())

figure, axis = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
for word, group in table.groupby(level=0):
    axis.plot(group["speed_rpm"], group["brake_torque_Nm"], "o-", label=word)
axis.set(xlabel="speed [r/min]", ylabel="brake torque [N m]", title="read without apesim")
axis.legend()

plt.show()

# %%
# MATLAB reads the same file: ``h5read('elsewhere.h5', '/brake_torque_Nm')`` or ``ncread('elsewhere.h5',
# 'brake_torque_Nm')``; the unit is ``h5readatt('elsewhere.h5', '/brake_torque_Nm', 'units')``. MATLAB shows the axes in
# reverse order, so that a trace over runs and crank angles is 721 x runs there.
#
# The figure does not show whether a point is to be trusted. ``warnings`` counts a run's warnings, and each kind has a
# flag, such as ``warning_opens_partly``. :doc:`/guide/archives` describes the format.
