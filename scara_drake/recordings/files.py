"""Recordings on disk: NetCDF, and the journal of a run that was cut off."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from scara_drake.common.files import whole_file
from scara_drake.recordings.dataset import to_dataset
from scara_drake.recordings.journal import read_journal


def save_recording(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a recording as NetCDF, whole or not at all; its folder is made if need be.

    Raises:
        OSError: the folder cannot be written.
    """
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    encoding = {name: {"zlib": True, "complevel": 1} for name in dataset.data_vars}
    with whole_file(path) as partial:
        dataset.to_netcdf(partial, engine="h5netcdf", encoding=encoding)


def load_recording(path: str | Path) -> xr.Dataset:
    """Read a recording: NetCDF, or the journal of a run that was cut off.

    Raises:
        ValueError: no such file, or not a recording.
    """
    source = Path(path)
    if not source.is_file():
        raise ValueError(f"recording: '{source}', allowed a file that exists")
    if source.suffix == ".journal":
        return to_dataset(*read_journal(source))
    try:
        with xr.open_dataset(source, engine="h5netcdf") as dataset:
            return dataset.load()
    except (OSError, ValueError):
        raise ValueError(f"recording: '{source}', allowed NetCDF written by a run") from None
