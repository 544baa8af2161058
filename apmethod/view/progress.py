"""A progress bar on the error stream, so that tables and JSON stay clean."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn


@contextmanager
def progress_bar(title: str) -> Iterator[Callable[[float, int], None]]:
    """Show a bar with time left; yields ``report(share, steps)``."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} % · step {task.fields[steps]}"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    progress = Progress(*columns, console=Console(stderr=True))
    task = progress.add_task(title, total=1.0, steps=0)

    def report(share: float, steps: int) -> None:
        progress.start()  # at the first step, so that refused input shows no bar
        progress.update(task, completed=share, steps=steps)

    try:
        yield report
    finally:
        progress.stop()
