"""Which side of a line a point is on, and whether two segments meet: without rounding errors.

Walls are watertight because these questions are answered exactly: a ray between two walls
that share a corner meets one of them, however close to the corner it passes.  A floating
point determinant decides where its error bound allows; the few others are summed exactly
(Shewchuk 1997, Rump and others 2008).  That holds for coordinates that are 0 or between
1e-140 and 1e140 in size.
"""

import math

from apmethod.move.obstacles.borrowing import called, exact

#: What `meeting` gives for segments that do not meet.
MISS = 2.0

_UNIT = 2.0**-53
#: Error bound of the determinant of two differences, relative to its terms' sizes.
_BOUND = (3.0 + 16.0 * _UNIT) * _UNIT
_SPLITTER = 2.0**27 + 1.0


@exact
def _two_product(a, b):
    """a * b as the rounded product and its exact rounding error (Dekker)."""
    product = a * b
    c = _SPLITTER * a
    a_high = c - (c - a)
    a_low = a - a_high
    c = _SPLITTER * b
    b_high = c - (c - b)
    b_low = b - b_high
    error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, error


@exact
def _part(k, ax, ay, bx, by, cx, cy):
    """One of the twelve numbers whose exact sum is the orientation of a, b, c."""
    if k < 2:
        product, error = _two_product(ax, by)
    elif k < 4:
        product, error = _two_product(-ay, bx)
    elif k < 6:
        product, error = _two_product(bx, cy)
    elif k < 8:
        product, error = _two_product(-by, cx)
    elif k < 10:
        product, error = _two_product(cx, ay)
    else:
        product, error = _two_product(-cy, ax)
    return product if k % 2 == 0 else error


@called
def _exact_orientation(ax, ay, bx, by, cx, cy):
    """The same as `orientation`, summed 48 bits at a time, from the top (Rump 2008).

    (unit + x) - unit is x rounded to a multiple of unit / 2^52, and sums of twelve of them
    are exact.  What is left of twelve numbers is less than 12 unit / 2^53 together.
    """
    largest = 0.0
    for k in range(12):
        largest = max(largest, abs(_part(k, ax, ay, bx, by, cx, cy)))
    top = math.ldexp(1.0, math.frexp(largest)[1] + 5)
    total, unit = 0.0, top
    while unit > 1e-290:
        left = False
        for k in range(12):
            part = _part(k, ax, ay, bx, by, cx, cy)
            above = top
            while above > unit:  # what earlier rounds have summed
                part -= (above + part) - above
                above *= 2.0**-48
            rounded = (unit + part) - unit
            total += rounded
            left = left or part != rounded
        if not left or abs(total) > 2.0**-30 * unit:
            break
        unit *= 2.0**-48
    return total


@exact
def orientation(ax, ay, bx, by, cx, cy):
    """Twice the signed area of the triangle a, b, c; its sign is exact.

    Above 0 where c is left of the line from a to b, below 0 right of it, 0 on the line.
    """
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    area = left - right
    if abs(area) > _BOUND * (abs(left) + abs(right)):
        return area
    return _exact_orientation(ax, ay, bx, by, cx, cy)


@exact
def meeting(px, py, qx, qy, ax, ay, bx, by):
    """Where the way from p to q first meets the wall from a to b, ends included.

    Returns:
        The share of the way, 0 to 1, or `MISS`.  Whether they meet is exact, the share
        is rounded.  The way may be a single point, the wall may not.
    """
    # Seen from a: the error is in proportion to the wall then, however far away p is.
    p_side = orientation(bx, by, px, py, ax, ay)
    q_side = orientation(bx, by, qx, qy, ax, ay)
    if (p_side > 0.0 and q_side > 0.0) or (p_side < 0.0 and q_side < 0.0):
        return MISS
    a_side = orientation(px, py, qx, qy, ax, ay)
    b_side = orientation(px, py, qx, qy, bx, by)
    if (a_side > 0.0 and b_side > 0.0) or (a_side < 0.0 and b_side < 0.0):
        return MISS
    if p_side != 0.0 or q_side != 0.0:
        # Where they are nearly parallel the quotient says little, but it is beside the wall.
        if abs(qx - px) >= abs(qy - py):
            a_share, b_share = (ax - px) / (qx - px), (bx - px) / (qx - px)
        else:
            a_share, b_share = (ay - py) / (qy - py), (by - py) / (qy - py)
        low, high = max(min(a_share, b_share), 0.0), min(max(a_share, b_share), 1.0)
        return min(max(p_side / (p_side - q_side), low), high)
    # All on one line: a question of intervals, along the axis on which they are longest.
    if abs(bx - ax) + abs(qx - px) >= abs(by - ay) + abs(qy - py):
        start, end, one, other = px, qx, ax, bx
    else:
        start, end, one, other = py, qy, ay, by
    near, far = min(one, other), max(one, other)
    if near <= start and start <= far:
        return 0.0
    edge = near if start < near else far
    if (start < near and end < near) or (start > far and end > far):
        return MISS
    return (edge - start) / (end - start)
