"""Checks of arguments that many constructors share; each names what would be right."""

from __future__ import annotations

import math
from typing import Any


def finite_number(name: str, value: Any, *, above: float | None = None,
                  least: float | None = None) -> float:  # fmt: skip
    """``value`` as a float, if it is a finite number above, or not below, a bound.

    Raises:
        ValueError: naming the argument, the value and what would be right.
    """
    wanted = "a finite number"
    if above is not None:
        wanted += f" above {above:g}"
    if least is not None:
        wanted += f", {least:g} or more"
    try:
        number = math.nan if isinstance(value, str | bool) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    too_small = (above is not None and number <= above) or (least is not None and number < least)
    if not math.isfinite(number) or too_small:
        raise ValueError(f"{name} is {value!r}; it must be {wanted}")
    return number


def whole_number(name: str, value: Any, *, least: int) -> int:
    """``value`` as an int, if it is a whole number that is not below ``least``.

    Raises:
        ValueError: naming the argument, the value and what would be right.
    """
    try:
        number = int(value) if not isinstance(value, str | bool) and value == int(value) else None
    except (TypeError, ValueError, OverflowError):
        number = None
    if number is None or number < least:
        raise ValueError(f"{name} is {value!r}; it must be a whole number, {least} or more")
    return number


def seed_checked(rng: Any) -> Any:
    """``rng`` as it is, unless it is a number that cannot be a seed.

    Raises:
        ValueError: for a negative or broken number.
    """
    if isinstance(rng, int | float | str):
        return whole_number("rng (the seed)", rng, least=0)
    return rng
