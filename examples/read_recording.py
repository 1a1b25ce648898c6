"""Read a recording without scara_drake: with xarray, or anything else that knows NetCDF.

The first part makes a recording, as `scara-drake run` does. The second one only needs the file.

    python examples/read_recording.py [FOLDER]

The files go to FOLDER, to look at them, or to a temporary folder that is removed at the end.
"""

import json
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no window
import matplotlib.pyplot as plt
import xarray as xr


def make(path: Path) -> None:
    """Simulate 3 s and save every signal."""
    import scara_drake as sd

    sd.save_recording(sd.simulate(sd.load_scenario("joint_sine"), duration=3.0), path)


def read(path: Path, picture: Path) -> None:
    """Print and plot what is in the file."""
    with xr.open_dataset(path, engine="netcdf4") as file:
        data = file.load()

    # Every variable has its unit; the joints, axes and surfaces have names.
    print(f"scenario   {data.attrs['scenario_name']}, seed {data.attrs['seed']}")
    print(f"made with  drake {json.loads(data.attrs['versions'])['drake']}")
    print(f"samples    {data.sizes['time']}, up to {data.time.values[-1]} s")
    units = data[data.q_measured.attrs["units_in"]].values
    print(f"variables  {len(data.data_vars)}; q_measured [{', '.join(units)}]")

    # The plant steps by q(k+1) = q(k) + h v(k+1), so each rate is the slope that leads to it.
    theta2 = data.sel(joint="theta2")
    slope = theta2.q_measured.diff("time") / data.time.diff("time")
    off = float(abs(slope - theta2.v_measured).max())
    print(f"largest |slope - rate|  {off:.1e} rad/s")

    # The error of tracking after the start, as `scara_drake.metrics` has it.
    error = (theta2.q_desired - theta2.q_measured).sel(time=slice(1.0, None))
    print(f"theta2, rms error       {float((error**2).mean() ** 0.5):.6e} rad")

    figure, (above, below) = plt.subplots(2, sharex=True)
    theta2.q_desired.plot(ax=above, linestyle="--", label="desired")
    theta2.q_measured.plot(ax=above, label="measured")
    above.legend()
    theta2.tau_applied.plot(ax=below)
    figure.savefig(picture)
    print(f"picture    {picture.name}, {picture.stat().st_size} bytes")


def main(folder: Path) -> None:
    """Make a recording in a folder and read it."""
    make(folder / "sine.nc")
    read(folder / "sine.nc", folder / "sine.png")


if len(sys.argv) > 1:
    main(Path(sys.argv[1]))
else:
    with tempfile.TemporaryDirectory() as temporary:
        main(Path(temporary))
