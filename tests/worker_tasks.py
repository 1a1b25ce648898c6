"""What the tests let a process do."""

import os
import time


def do(task: str) -> str:
    if task == "die":
        os._exit(3)
    if task == "sleep":
        time.sleep(60.0)
    return f"{task} by {os.getpid()}"
