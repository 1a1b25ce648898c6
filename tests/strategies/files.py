"""Files as they come back from a bad disk, a bad copy or a process that was killed."""

from __future__ import annotations

from typing import NamedTuple

from hypothesis import strategies as st


class Flip(NamedTuple):
    """One byte is another: the one at a share of the length."""

    share: float
    change: int

    def of(self, whole: bytes, other: bytes) -> bytes:
        at = int(self.share * len(whole))
        return whole[:at] + bytes([whole[at] ^ self.change]) + whole[at + 1 :]


class Cut(NamedTuple):
    """The end is missing, from a share of the length on."""

    share: float

    def of(self, whole: bytes, other: bytes) -> bytes:
        return whole[: int(self.share * len(whole))]


class Splice(NamedTuple):
    """It begins as one file and goes on as another, at shares of their lengths."""

    share: float
    other_share: float

    def of(self, whole: bytes, other: bytes) -> bytes:
        return whole[: int(self.share * len(whole))] + other[int(self.other_share * len(other)) :]


SHARES = st.floats(0.0, 1.0, exclude_max=True)
FLIPS = st.builds(Flip, SHARES, st.integers(1, 255))
DAMAGES = FLIPS | st.builds(Cut, SHARES) | st.builds(Splice, SHARES, SHARES)
