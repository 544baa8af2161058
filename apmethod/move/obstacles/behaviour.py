"""What an agent does at a wall (paper 2.5.3).

A behaviour is a function of what is left of the displacement, seen from the wall, and of
the wall's unit normal on the agent's side; it gives the displacement to go on with.  Agents
that keep a velocity have it changed by the same function, where it leads into the wall.

==========  ==========================================================================
repulse     back the way it came
bounce      mirrored, as light is (specular)
slide       along the wall
stick       the agent stays where it has touched the wall, and goes where the wall goes,
            until the obstacle is taken away
absorb      the agent disappears, and is counted; walls may take mass besides (`Obstacles`)
==========  ==========================================================================
"""

from collections.abc import Callable
from functools import cache

from apmethod.move.obstacles.borrowing import exact

REPULSE, BOUNCE, SLIDE, STICK, ABSORB, OWN_FUNCTION = range(6)
#: The behaviours that go by a name.
BEHAVIOURS = {
    "repulse": REPULSE,
    "bounce": BOUNCE,
    "slide": SLIDE,
    "stick": STICK,
    "absorb": ABSORB,
}


@exact
def known_answer(code, dx, dy, nx, ny):
    """The displacement after a wall of one of the named behaviours."""
    into = dx * nx + dy * ny
    if code == REPULSE:
        return -dx, -dy
    if code == BOUNCE:
        return dx - 2.0 * into * nx, dy - 2.0 * into * ny
    if code == SLIDE:
        return dx - into * nx, dy - into * ny
    return 0.0, 0.0


@cache
def answer_of(functions: tuple[Callable, ...]) -> Callable:
    """``answer(code, dx, dy, nx, ny)`` for the named behaviours and users' own functions.

    The k-th function has the code ``OWN_FUNCTION + k``.
    """
    answer = known_answer
    for k, function in enumerate(functions):
        answer = _or_own(OWN_FUNCTION + k, exact(function), answer)
    return answer


def _or_own(own: int, function: Callable, otherwise: Callable) -> Callable:
    @exact
    def answer(code, dx, dy, nx, ny):
        if code == own:
            return function(dx, dy, nx, ny)
        return otherwise(code, dx, dy, nx, ny)

    return answer


def checked_behaviour(name: str, behaviour: str | Callable) -> str | Callable:
    """``behaviour`` of the obstacle ``name``, if it is one.

    Raises:
        ValueError: for an unknown name, or a function that does not give two numbers.
    """
    wanted = f"it must be one of {', '.join(BEHAVIOURS)}, or f(dx, dy, nx, ny) giving (dx, dy)"
    if isinstance(behaviour, str):
        if behaviour not in BEHAVIOURS:
            raise ValueError(f"behaviour of {name} is {behaviour!r}; {wanted}")
        return behaviour
    try:
        dx, dy = behaviour(0.3, -0.4, 0.0, 1.0)
        float(dx), float(dy)
    except (TypeError, ValueError) as error:
        raise ValueError(f"behaviour of {name} is {behaviour!r}; {wanted}: {error}") from None
    return behaviour
