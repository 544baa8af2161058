"""The same seed gives the same bits: again, on more threads, and in another process."""

import hashlib
import subprocess
import sys

import pytest

from apmethod import Periodic, set_threads
from apmethod.compile import threads
from samples import Curious, build

SCRIPT = """
import sys
sys.path.insert(0, {path!r})
from test_reproducible import digest
print(digest())
"""


def digest():
    """A digest of all columns after some steps of a scene large enough for two threads."""
    model = build(
        6000, agent_class=Curious, core_radius=0.06, domain=Periodic((0, 0), (1, 1)),
        integrator="strang", dt=1e-3,
    )  # fmt: skip
    for _ in range(3):
        model.step()
    table = model.particles
    return hashlib.sha256(b"".join(getattr(table, n).tobytes() for n in table.names)).hexdigest()


@pytest.fixture
def restored_threads():
    before = threads()
    yield
    set_threads(before)


@pytest.mark.usefixtures("restored_threads")
def test_any_number_of_threads_gives_the_same_bits():
    found = set()
    for count in (1, 2, 3):
        set_threads(count)
        found.add(digest())
    assert len(found) == 1


def test_another_process_gives_the_same_bits(request):
    script = SCRIPT.format(path=str(request.path.parent))
    found = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True,
        cwd=request.path.parent,
    )  # fmt: skip
    assert found.stdout.strip() == digest()


def test_the_seed_matters():
    from apmethod.scenes.rotating_hill import RotatingHill

    places = [RotatingHill(500, rng=seed).particles.position.tobytes() for seed in (1, 1, 2)]
    assert places[0] == places[1] != places[2]


@pytest.mark.parametrize("count", [0, -1, 1.5, "two"])
def test_a_bad_number_of_threads_is_refused(count):
    with pytest.raises(ValueError, match=r"threads is .*; it must be a whole number, 1 or more"):
        set_threads(count)
