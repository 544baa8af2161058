"""What a run raises or warns of when it goes wrong.

Bad input raises ``ValueError`` or ``TypeError`` before anything runs.
"""


class StepFailed(RuntimeError):
    """A step could not be completed; the error's note says where the agents stand.

    Attributes:
        step: number of the failed step, counted from 1.
        time: physical time at which it began.
    """

    def __init__(self, message: str, step: int, time: float):
        super().__init__(f"step {step} (from time {time:g}): {message}")
        self.step = step
        self.time = time


class Unstable(RuntimeWarning):
    """A run shows signs of being unstable; see `apmethod.watch`.  It goes on."""
