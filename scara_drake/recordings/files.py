"""Recordings on disk: NetCDF 4 with checksums, and the journals of runs that were cut off."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import netCDF4
import numpy as np
import xarray as xr

from scara_drake.common.files import whole_file
from scara_drake.recordings.dataset import to_dataset
from scara_drake.recordings.journal import (
    AT_ONCE,
    Contents,
    is_journal,
    read_journal,
    survey,
)
from scara_drake.recordings.seal import is_broken, seal

ENGINE: Final = "netcdf4"
CHUNK_CACHE: Final = 1 << 19  # [B] of a variable: two chunks of six columns
# What xarray and the libraries below it raise for a file that is damaged or no recording.
UNREADABLE: Final = (
    OSError, ValueError, LookupError, RuntimeError, TypeError, AttributeError, MemoryError,
    OverflowError,
)  # fmt: skip


def save_recording(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a recording as NetCDF, whole or not at all; its folder is made if need be.

    Raises:
        OSError: the file cannot be written, or there is no space for it.
    """
    with _recording_file(path) as partial:
        _create(dataset, partial)
        _append(partial, iter(()), dataset.attrs)


def save_journal(
    journal: str | Path,
    path: str | Path,
    judge: Callable[[xr.Dataset], dict[str, str | int | float]] | None = None,
) -> Contents:
    """Make a recording of a journal, piece by piece, whole or not at all; keep the journal.

    Args:
        journal: the file.
        path: of the recording.
        judge: gets the recording, lazily opened, and returns further attributes of it.

    Returns:
        What the journal holds.

    Raises:
        ValueError: not a journal, or its head is damaged.
        OSError: the file cannot be written, or there is no space for it.
    """
    contents = survey(journal)
    pieces = (_label(contents, *samples) for samples in contents.read(AT_ONCE))
    first = next(pieces, None)
    if first is None:
        raise ValueError(f"journal: '{journal}', allowed one with samples")
    with _recording_file(path) as partial:
        _create(first, partial)
        _append(partial, pieces, first.attrs)
        if judge is not None:
            with xr.open_dataset(partial, engine=ENGINE) as recording:
                found = {name: _portable(value) for name, value in judge(recording).items()}
            with netCDF4.Dataset(partial, "a") as file:
                file.setncatts(found)
    return contents


def load_recording(path: str | Path) -> xr.Dataset:
    """Read a recording: NetCDF, or the journal of a run that was cut off.

    Of a damaged journal the samples before the damage are read, and a warning says so.

    Raises:
        ValueError: no such file, not a recording, or one that is damaged.
    """
    with open_recording(path) as dataset:
        try:
            return dataset.load()
        except UNREADABLE:
            raise _refusal(Path(path)) from None


@contextmanager
def open_recording(path: str | Path) -> Iterator[xr.Dataset]:
    """Open a recording whose variables are read from the file when they are asked for.

    Raises:
        ValueError: no such file, not a recording, or one that is damaged.
    """
    source = Path(path)
    if not source.is_file():
        raise ValueError(f"recording: '{source}', allowed a file that exists")
    if source.suffix == ".journal" or is_journal(source):
        contents, times, values = read_journal(source)
        if contents.lost:
            warnings.warn(loss(contents), stacklevel=4)
        yield _label(contents, times, values)
        return
    if is_broken(source):
        raise ValueError(f"recording: '{source}' is damaged, allowed one with its own checksum")
    try:
        dataset = _opened(source)
        if isinstance(seed := dataset.attrs.get("seed"), (str, np.integer)):
            dataset.attrs["seed"] = int(seed)
    except UNREADABLE:
        raise _refusal(source) from None
    with dataset:
        yield dataset


def _opened(source: Path) -> xr.Dataset:
    """Open a file whose variables keep two chunks each in memory, not the library's 64 MB."""
    before = netCDF4.get_chunk_cache()
    netCDF4.set_chunk_cache(CHUNK_CACHE, *before[1:])
    try:
        return xr.open_dataset(source, engine=ENGINE)
    finally:
        netCDF4.set_chunk_cache(*before)


def loss(contents: Contents) -> str:
    """Say what a damaged journal has lost."""
    return f"{contents.path}: damaged after {contents.samples} samples; {contents.lost} bytes lost"


def _refusal(path: Path) -> ValueError:
    return ValueError(f"recording: '{path}', allowed NetCDF written by a run")


def _label(contents: Contents, times: Any, values: Any) -> xr.Dataset:
    by = f"damage: {contents.lost} bytes lost" if contents.lost else contents.ended_by
    return to_dataset(contents.description, times, values, by, contents.ended_at)


@contextmanager
def _recording_file(path: str | Path) -> Iterator[Path]:
    """Yield where to write a recording that becomes `path`, sealed."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as partial:
        try:
            yield partial
        except RuntimeError as error:  # of the NetCDF library, which does not say why
            raise OSError(f"recording: '{path}' cannot be written ({error}): no space?") from None
        seal(partial)


def _create(dataset: xr.Dataset, partial: Path) -> None:
    """Write a dataset such that it can grow in time."""
    attributes = {name: _portable(value) for name, value in dataset.attrs.items()}
    dataset.assign_attrs(attributes).to_netcdf(
        partial,
        engine=ENGINE,
        encoding={name: _encoding(name, values) for name, values in dataset.variables.items()},
        unlimited_dims=["time"] if "time" in dataset.dims else [],
    )


def _encoding(name: Hashable, variable: xr.Variable) -> dict[str, Any]:
    """Samples are compressed, with a checksum for each chunk; texts have a fixed length."""
    if variable.dtype.kind in "OUST":
        return {"dtype": "S1"}
    encoding: dict[str, Any] = {}
    if variable.dims[:1] == ("time",):
        encoding = {"zlib": True, "complevel": 1, "shuffle": True, "fletcher32": True}
        encoding["chunksizes"] = (AT_ONCE, *variable.shape[1:])
    if name == "time":
        encoding["_FillValue"] = None  # none is missing
    return encoding


def _append(partial: Path, pieces: Iterator[xr.Dataset], attributes: dict[Any, Any]) -> None:
    with netCDF4.Dataset(partial, "a") as file:
        for variable in file.variables.values():
            if (chunks := variable.chunking()) != "contiguous":  # else 16 MB for each
                variable.set_var_chunk_cache(size=2 * math.prod(chunks) * variable.dtype.itemsize)
        for name, value in attributes.items():
            if isinstance(value, str) and not value.isascii():
                file.setncattr(name, value.encode())  # as characters, which all programs read
        start = len(file.dimensions["time"]) if "time" in file.dimensions else 0
        for piece in pieces:
            end = start + piece.sizes["time"]
            for name, values in piece.variables.items():
                if values.dims[:1] == ("time",):
                    file[str(name)][start:end] = values.values
            start = end


def _portable(value: Any) -> Any:
    """Integers of 8 bytes become 4, or texts: many programs have no other."""
    if isinstance(value, (int, np.integer)) and not isinstance(value, (bool, np.bool_)):
        return np.int32(value) if abs(int(value)) < 2**31 else str(value)
    return value
