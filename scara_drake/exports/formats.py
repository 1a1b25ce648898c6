"""The formats that recordings are exported to. Nothing heavy is imported before it is needed."""

from __future__ import annotations

from contextlib import nullcontext
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    import xarray as xr


class Format(NamedTuple):
    """A format.

    Attributes:
        suffix: of its files.
        module: has ``write(recording, path)``, which writes a file whole or not at all, and reads
            an open recording piece by piece.
        extra: what has to be installed for it, or "".
        what: it is, in few words.
    """

    suffix: str
    module: str
    extra: str
    what: str


FORMATS: Final = {
    "csv": Format(".csv", "csv_file", "", "a row a sample; units in a file beside it"),
    "parquet": Format(".parquet", "parquet_file", "export", "the same table, units in the file"),
    "mcap": Format(".mcap", "mcap_file", "export", "for Foxglove and PlotJuggler"),
    "rerun": Format(".rrd", "rerun_file", "rerun", "robot, plots and time slider for rerun"),
    "trace": Format(".csv", "trace_file", "", "the stick, which played again gives the same run"),
}


def format_of(path: str | Path, to: str = "") -> str:
    """Return the name of the format: `to`, or that of the file's suffix.

    Raises:
        ValueError: there is no such format, or the file's suffix is not its own.
    """
    suffix = Path(path).suffix
    name = to or next((name for name, each in FORMATS.items() if each.suffix == suffix), "")
    if to and to not in FORMATS:
        raise ValueError(f"to: '{to}', allowed {', '.join(FORMATS)}")
    if not name or FORMATS[name].suffix != suffix:
        endings = FORMATS[name].suffix if name else ", ".join(_suffixes())
        raise ValueError(f"output: '{path}', allowed a file that ends in {endings}")
    return name


def export(recording: xr.Dataset | str | Path, path: str | Path, to: str = "") -> Path:
    """Write a recording in a format of other programs; the folder is made if need be.

    A file of a recording is read in pieces, so that the memory does not grow with its length.

    Args:
        recording: of `simulate` or `load_recording`, or the file of a recording or a journal.
        path: of the new file.
        to: csv, parquet, mcap, rerun or trace; if "", what the suffix of the path says.

    Raises:
        ValueError: no such recording or format, a recording that has nothing for it, or a format
            whose library is not installed.
        OSError: the file cannot be written.
    """
    import xarray as xr

    from scara_drake.recordings.files import open_recording

    chosen = FORMATS[format_of(path, to)]
    try:
        module = import_module(f"scara_drake.exports.{chosen.module}")
    except ModuleNotFoundError as error:
        if not chosen.extra:
            raise
        raise ValueError(
            f"export: {error}, allowed with the extra '{chosen.extra}' installed: "
            f"pip install 'scara-drake[{chosen.extra}]'"
        ) from None
    opened = (
        nullcontext(recording) if isinstance(recording, xr.Dataset) else open_recording(recording)
    )
    with opened as data:
        if "time" not in data.dims or "time" not in data.coords:
            raise ValueError("recording: no time, allowed NetCDF written by a run")
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        module.write(data, Path(path))
    return Path(path)


def _suffixes() -> list[str]:
    return list(dict.fromkeys(each.suffix for each in FORMATS.values()))
