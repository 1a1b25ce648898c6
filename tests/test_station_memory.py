"""What the simulation and the station's server leave each other, and the device made of it."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import examples

from scara_drake.station.device import StationDevice
from scara_drake.station.helm import Helm
from scara_drake.station.mailbox import HEADER, Mailbox, make_memory, map_memory, size_of
from scara_drake.station.protocol import SETTINGS
from scara_drake.station.records import (
    FRAME,
    INPUT,
    Mailboxes,
    make_mailboxes,
    map_mailboxes,
    no_input,
)
from scara_drake.station.requests import ControlRequest, Input, Setting

NUMBERS = np.dtype([("a", "f8", (300,)), ("b", "i8")])
TAKE, RELEASE = ControlRequest("take", None), ControlRequest("release", None)
# Writes records of one number each, as fast as it can, until its input ends.
WRITER = """
import sys, threading
import numpy as np
from scara_drake.station.mailbox import Mailbox, map_memory, size_of
dtype = np.dtype([("a", "f8", (300,)), ("b", "i8")])
mailbox = Mailbox(map_memory(int(sys.argv[1]), size_of(dtype)), 0, dtype)
threading.Thread(target=lambda: (sys.stdin.read(), __import__("os")._exit(0))).start()
record, k = np.zeros((), dtype), 0
while True:
    k += 1
    record["a"], record["b"] = k, k
    mailbox.write(record)
"""


@pytest.fixture
def mailboxes() -> Mailboxes:
    file, places = make_mailboxes()
    file.close()  # the memory stays
    return places


def said(*axes: float, engage: bool = False) -> Input:
    return Input(axes or (0.0,) * 5, (0.0,) * 3, (float(engage), 0, 0, 0, 0, 0), "pad")


def test_the_newest_record_is_read(mailboxes: Mailboxes) -> None:
    assert mailboxes.input.read() is None
    for hand in (1, 2):
        record = no_input()
        record["hand"] = hand
        mailboxes.input.write(record)
    assert mailboxes.input.read() == record
    assert mailboxes.frame.read() is None


def test_a_record_that_is_half_written_is_not_read() -> None:
    with make_memory(size_of(INPUT)) as file:
        memory = map_memory(file.fileno(), size_of(INPUT))
    mailbox = Mailbox(memory, 0, INPUT)
    mailbox.write(no_input())
    memory[HEADER.itemsize + 20] = 77  # as a writer that is stopped leaves it
    assert mailbox.read() is None
    mailbox.write(no_input())
    assert mailbox.read() == no_input()


def test_a_reader_beside_a_busy_writer_reads_whole_records_only() -> None:
    with make_memory(size_of(NUMBERS)) as file:
        mailbox = Mailbox(map_memory(file.fileno(), size_of(NUMBERS)), 0, NUMBERS)
        command = [sys.executable, "-c", WRITER, str(file.fileno())]
        pipe = subprocess.PIPE
        writer = subprocess.Popen(command, stdin=pipe, pass_fds=[file.fileno()])
        try:
            seen: list[int] = []
            while len(set(seen)) < 200:
                record = mailbox.read()
                if record is not None:
                    assert (record["a"] == record["b"]).all()
                    seen.append(int(record["b"]))
        finally:
            writer.communicate()
    assert seen == sorted(seen)


def test_shared_memory_has_no_name() -> None:
    folder = Path("/dev/shm")
    before = set(os.listdir(folder)) if folder.is_dir() else set()
    file, places = make_mailboxes()
    with file:
        again = map_mailboxes(file.fileno())
    again.input.write(no_input())
    assert places.input.read() == no_input()
    mine = {name for name in set(os.listdir(folder)) - before if name.startswith("tmp")}
    assert not mine


def test_a_page_is_a_device_while_it_holds_control(mailboxes: Mailboxes) -> None:
    helm, device = Helm(mailboxes.input), StationDevice(mailboxes)
    assert not device.sample().connected
    assert helm.ask(1, TAKE, [1]) == ""
    assert not device.sample().connected  # it has said nothing yet
    helm.input(1, said(0.1, 0.2, 0.3, 0.4, 0.5, engage=True), 7.0)
    sample = device.sample()
    assert sample.connected
    assert sample.stamp == 7.0
    assert sample.axes.tolist() == [0.1, 0.2, 0.3, 0.4, 0.5]
    assert sample.buttons[0] == 1.0
    helm.leave(1)
    lost = device.sample()
    assert not lost.connected
    assert lost.axes.tolist() == sample.axes.tolist()  # what it said last


def test_another_hand_is_lost_for_one_sample(mailboxes: Mailboxes) -> None:
    helm, device = Helm(mailboxes.input), StationDevice(mailboxes)
    helm.ask(1, TAKE, [1, 2])
    helm.input(1, said(engage=True), 1.0)
    device.sample()
    assert device.sample().connected
    helm.ask(1, ControlRequest("give", 2), [1, 2])
    helm.input(2, said(engage=True), 2.0)  # before the device is sampled again
    assert [device.sample().connected for _ in range(3)] == [False, True, True]


def test_a_server_that_is_gone_is_a_device_that_is_lost(
    mailboxes: Mailboxes, caplog: pytest.LogCaptureFixture
) -> None:
    there = SimpleNamespace(answer=True)
    helm, device = Helm(mailboxes.input), StationDevice(mailboxes, lambda: there.answer)
    helm.ask(1, TAKE, [1])
    helm.input(1, said(), 1.0)
    assert [device.sample().connected for _ in range(2)] == [False, True]
    there.answer = False
    assert [device.sample().connected for _ in range(2)] == [False, False]
    assert len(caplog.records) == 1


def test_settings_stay_when_control_changes_hands(mailboxes: Mailboxes) -> None:
    helm, device = Helm(mailboxes.input), StationDevice(mailboxes)
    assert helm.set(1, Setting("force_scale", 0.5)) != ""
    helm.ask(1, TAKE, [1])
    assert helm.set(1, Setting("force_scale", 0.5)) == ""
    helm.ask(1, RELEASE, [1])
    assert device.sample().settings.tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]


def test_rumble_reaches_the_server_with_its_end(mailboxes: Mailboxes) -> None:
    device, before = StationDevice(mailboxes), time.monotonic()
    device.rumble(0.25, 0.75, 100)
    record: Any = mailboxes.rumble.read()
    assert (record["low"], record["high"]) == (0.25, 0.75)
    assert before + 0.1 <= record["until"] <= time.monotonic() + 0.1
    device.close()
    record = mailboxes.rumble.read()
    assert record["low"] == record["high"] == record["until"] == 0.0


clients = st.integers(1, 3)
steps = st.lists(
    st.tuples(clients, st.sampled_from(["take", "release", "give", "leave", "input"]), clients),
    max_size=30,
)


@examples(100)
@given(steps)
def test_only_who_holds_control_is_heard(asked: list[tuple[int, str, int]]) -> None:
    file, places = make_mailboxes()
    file.close()
    helm, holder = Helm(places.input), None
    before = no_input()
    for client, action, to in asked:
        if action == "leave":
            helm.leave(client)
            expected = None if holder == client else holder
        elif action == "input":
            refused = helm.input(client, said(client / 10, 0, 0, 0, 0), 1.0)
            assert bool(refused) == (holder != client)
            expected = holder
        else:
            request = ControlRequest(action, to if action == "give" else None)
            refused = helm.ask(client, request, [1, 2, 3])
            allowed = holder == client or (action == "take" and holder is None)
            assert bool(refused) != allowed
            after = {"take": client, "release": None, "give": to}[action]
            expected = after if allowed else holder
        assert helm.holder == expected
        record: Any = places.input.read()
        record = before if record is None else record
        assert (record["hand"] != before["hand"]) == (expected != holder)
        if expected != holder:
            assert not record["connected"]
        if record["connected"]:
            assert record["axes"][0] == expected / 10  # type: ignore[operator]  # somebody
        holder, before = expected, record


def test_control_is_not_given_to_who_is_not_there(mailboxes: Mailboxes) -> None:
    helm = Helm(mailboxes.input)
    helm.ask(1, TAKE, [1])
    assert "3" in helm.ask(1, ControlRequest("give", 3), [1, 2])
    assert helm.holder == 1


def test_every_setting_has_a_place() -> None:
    assert len(SETTINGS) == INPUT["settings"].shape[0] == FRAME["live_settings"].shape[0]
