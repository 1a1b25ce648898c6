import os
import signal
import threading
import time

import pytest

from scara_drake.simulation.interrupt import DeferredInterrupt


def interrupt():
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.05)


def test_the_first_interrupt_is_noted_and_the_second_raises():
    before = signal.getsignal(signal.SIGINT)
    with DeferredInterrupt() as deferred:
        assert not deferred.pressed
        interrupt()
        assert deferred.pressed
        with pytest.raises(KeyboardInterrupt):
            interrupt()
    assert signal.getsignal(signal.SIGINT) is before


def test_another_thread_leaves_the_signals_alone():
    before = signal.getsignal(signal.SIGINT)
    seen = []

    def work():
        with DeferredInterrupt() as deferred:
            seen.append((deferred.pressed, signal.getsignal(signal.SIGINT)))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [(False, before)]
