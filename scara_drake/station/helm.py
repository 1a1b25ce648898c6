"""Who holds control, and what the simulation hears of it."""

from __future__ import annotations

from collections.abc import Container

from scara_drake.station.mailbox import Mailbox
from scara_drake.station.protocol import SETTINGS
from scara_drake.station.records import no_input
from scara_drake.station.requests import ControlRequest, Input, Setting

WATCHING = "you are watching: who holds control commands"


class Helm:
    """Lets one client command; the others are refused, in words.

    A client counts as a device from its first input on. Whenever control changes hands the input
    begins anew, at rest and under another number.

    Args:
        mailbox: where the input is left for the simulation.

    Attributes:
        holder: the number of the client that holds control, or None.
        settings: by their names.
    """

    def __init__(self, mailbox: Mailbox) -> None:
        self.holder: int | None = None
        self.settings = {name: bounds.neutral for name, bounds in SETTINGS.items()}
        self._mailbox, self._record = mailbox, no_input()

    def ask(self, client: int, request: ControlRequest, present: Container[int]) -> str:
        """Do what a client asks about control; return why not, or "".

        Args:
            client: its number.
            request: what it asks.
            present: the numbers of all clients.
        """
        if request.action == "take":
            if self.holder not in (None, client):
                return f"client {self.holder} holds control: it has to release or to give it"
            if self.holder is None:
                self._pass_to(client)
            return ""
        if self.holder != client:
            return "you do not hold control"
        if request.action == "give" and request.to not in present:
            return f"client {request.to} is not there"
        if request.to != client:
            self._pass_to(request.to)
        return ""

    def there_are(self, clients: int) -> None:
        """Say how many clients there are."""
        self._record["clients"] = clients
        self._mailbox.write(self._record)

    def leave(self, client: int) -> None:
        """A client is gone; if it held control, nobody does."""
        if self.holder == client:
            self._pass_to(None)

    def input(self, client: int, said: Input, now: float) -> str:
        """Take what a client's device says at `now` [s] of the monotonic clock; return why not."""
        if self.holder != client:
            return WATCHING
        record = self._record
        record["connected"], record["stamp"] = True, now
        for name in ("axes", "orientation", "buttons"):
            record[name] = getattr(said, name)
        self._mailbox.write(record)
        return ""

    def set(self, client: int, setting: Setting) -> str:
        """Take a setting of a client; return why not, or ""."""
        if self.holder != client:
            return WATCHING
        self.settings[setting.name] = setting.value
        self._record["settings"] = [self.settings[name] for name in SETTINGS]
        self._mailbox.write(self._record)
        return ""

    def _pass_to(self, client: int | None) -> None:
        before, self._record = self._record, no_input()
        self.holder, self._record["hand"] = client, before["hand"] + 1
        for kept in ("clients", "settings"):
            self._record[kept] = before[kept]
        self._mailbox.write(self._record)
