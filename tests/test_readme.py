"""The README's example runs, and the files it names exist."""

import re
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"


def test_the_example_runs(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 25
    exec(compile(example, str(README), "exec"), {"__name__": "readme"})
    assert "[" in capsys.readouterr().out


def test_files_that_it_names_exist():
    text = README.read_text()
    named = re.findall(r"\]\(([\w./]+)\)", text) + re.findall(r"solara run (\S+)", text)
    assert named
    for name in named:
        assert (README.parent / name).exists(), name
