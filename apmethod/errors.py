"""What a run raises when it goes wrong; bad input raises ``ValueError`` or ``TypeError``."""


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
