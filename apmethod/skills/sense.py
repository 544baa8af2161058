"""Compiled passes between agents and patches: laying a signal down and sensing it.

An agent stands between the centres of four patches.  With ``cloud`` weights it lays its
share on these four (cloud-in-cell) and ``bilinear`` reads them with the same weights, so
that the fresh signal of an agent does not push the agent itself.
"""

from __future__ import annotations

from math import ceil, floor, sqrt

from apmethod.compile import compiled, inlined

# `grid` is (south-west x, y, side of a patch, periodic along x, y) of `Patches.grid`.


@inlined
def along(place, count, periodic):
    """Number of a patch along an axis; beyond a closed side it is the last one."""
    if periodic:
        return place % count
    return min(max(place, 0), count - 1)


@inlined
def patch_at(x, y, grid, shape):
    """The patch under a point."""
    i, j = floor((x - grid[0]) / grid[2]), floor((y - grid[1]) / grid[2])
    return along(i, shape[0], grid[3]), along(j, shape[1], grid[4])


@inlined
def patches_around(x, y, grid, shape):
    """The four patches whose centres are around a point: west, east, south, north.

    Then the shares of the eastern and the northern ones in the point's value.
    """
    u, v = (x - grid[0]) / grid[2] - 0.5, (y - grid[1]) / grid[2] - 0.5
    i, j = floor(u), floor(v)
    west, east = along(i, shape[0], grid[3]), along(i + 1, shape[0], grid[3])
    south, north = along(j, shape[1], grid[4]), along(j + 1, shape[1], grid[4])
    return west, east, south, north, u - floor(u), v - floor(v)


@compiled
def lay_nearest(position, amount, grid, home, total):
    """Add each agent's amount to the patch it stands on; ``total`` is flat."""
    for k in range(position.shape[0]):
        i, j = patch_at(position[k, 0], position[k, 1], grid, home.shape)
        total[home[i, j]] += amount[k]


@compiled
def lay_cloud(position, amount, grid, home, total):
    """Add each agent's amount to the four patches around it; ``total`` is flat."""
    for k in range(position.shape[0]):
        west, east, south, north, u, v = patches_around(
            position[k, 0], position[k, 1], grid, home.shape
        )
        total[home[west, south]] += amount[k] * (1.0 - u) * (1.0 - v)
        total[home[east, south]] += amount[k] * u * (1.0 - v)
        total[home[west, north]] += amount[k] * (1.0 - u) * v
        total[home[east, north]] += amount[k] * u * v


@compiled
def slopes(first, last, signal, east, north, side, slope):
    """Central differences at the patches' centres, of shape (wide, high, 2).

    A neighbour behind a border or an obstacle counts as equal: nothing flows there.
    """
    wide, high = signal.shape
    for i in range(first, last):
        before, after = i - 1 if i else wide - 1, i + 1 if i + 1 < wide else 0
        for j in range(high):
            below, above = j - 1 if j else high - 1, j + 1 if j + 1 < high else 0
            s = signal[i, j]
            rise_x = east[i, j] * (signal[after, j] - s) - east[before, j] * (signal[before, j] - s)
            rise_y = north[i, j] * (signal[i, above] - s)
            rise_y -= north[i, below] * (signal[i, below] - s)
            slope[i, j, 0], slope[i, j, 1] = rise_x / (2.0 * side), rise_y / (2.0 * side)


@compiled
def read_nearest(first, last, position, signal, slope, grid, home, value, gradient):
    """What each agent senses of the patch it stands on."""
    for k in range(first, last):
        i, j = patch_at(position[k, 0], position[k, 1], grid, home.shape)
        i, j = home[i, j] // home.shape[1], home[i, j] % home.shape[1]
        value[k] = signal[i, j]
        gradient[k, 0], gradient[k, 1] = slope[i, j, 0], slope[i, j, 1]


@compiled
def read_bilinear(first, last, position, signal, slope, grid, home, value, gradient):
    """What each agent senses between the four patches around it."""
    high = home.shape[1]
    for k in range(first, last):
        west, east, south, north, u, v = patches_around(
            position[k, 0], position[k, 1], grid, home.shape
        )
        a, b = home[west, south], home[east, south]
        c, d = home[west, north], home[east, north]
        w_a, w_b, w_c, w_d = (1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v
        a_i, a_j, b_i, b_j = a // high, a % high, b // high, b % high
        c_i, c_j, d_i, d_j = c // high, c % high, d // high, d % high
        value[k] = w_a * signal[a_i, a_j] + w_b * signal[b_i, b_j]
        value[k] += w_c * signal[c_i, c_j] + w_d * signal[d_i, d_j]
        for axis in range(2):
            gradient[k, axis] = w_a * slope[a_i, a_j, axis] + w_b * slope[b_i, b_j, axis]
            gradient[k, axis] += w_c * slope[c_i, c_j, axis] + w_d * slope[d_i, d_j, axis]


@inlined
def perceived_patches(radius, side):
    """A radius in patches; at least what a plane needs, the 2 x 2 patches around an agent.

    The farthest of these is sqrt(2) sides away.
    """
    return max(radius / side, 1.5)


@inlined
def in_cone(dx, dy, distance, head_x, head_y, ahead):
    """Whether (dx, dy) is at most as far off a heading as a view cone allows.

    ``ahead`` is the cosine of the cone's half angle times the heading's length.
    """
    return dx * head_x + dy * head_y >= ahead * distance


@compiled
def read_vicinity(
    first, last, position, signal, free, margin, grid, radius, heading, view, value, gradient
):
    """The plane that fits best what each agent perceives of the signal.

    Patches within the agent's radius R count with weight (1 - r^2/R^2)^2; with ``view``
    not empty only those that are at most that angle off the agent's ``heading``.  Value
    and gradient are the plane's at the agent; both are exact for a linear signal.  An
    agent that sees fewer patches than fix a plane has the mean of these and no gradient.

    ``signal`` and ``free`` have ``margin`` patches more on each side, so that the loops
    below need not ask where the domain ends.
    """
    wide, high = signal.shape
    for k in range(first, last):
        u = (position[k, 0] - grid[0]) / grid[2] - 0.5 + margin
        v = (position[k, 1] - grid[1]) / grid[2] - 0.5 + margin
        reach = perceived_patches(radius[k], grid[2])
        per_square = 1.0 / (reach * reach)
        head_x = head_y = ahead = 0.0
        if view.size:
            head_x, head_y = heading[k, 0], heading[k, 1]
            ahead = view[k] * sqrt(head_x * head_x + head_y * head_y)
        n = x = y = xx = xy = yy = s_1 = sx = sy = 0.0
        # A position that is not a number must not lead out of the arrays.
        south, north = max(ceil(v - reach), 0), min(floor(v + reach) + 1, high)
        for i in range(max(ceil(u - reach), 0), min(floor(u + reach) + 1, wide)):
            dx = i - u
            row_n = row_y = row_yy = row_s = row_sy = 0.0
            for j in range(south, north):
                dy = j - v
                r_2 = dx * dx + dy * dy
                w = max(1.0 - r_2 * per_square, 0.0)
                w *= w * free[i, j]
                if view.size:
                    w = w if in_cone(dx, dy, sqrt(r_2), head_x, head_y, ahead) else 0.0
                s = signal[i, j]
                row_n += w
                row_y += w * dy
                row_yy += w * dy * dy
                row_s += w * s
                row_sy += w * s * dy
            n, x, y = n + row_n, x + row_n * dx, y + row_y
            xx, xy, yy = xx + row_n * dx * dx, xy + row_y * dx, yy + row_yy
            s_1, sx, sy = s_1 + row_s, sx + row_s * dx, sy + row_sy
        value[k] = s_1 / n if n > 0.0 else 0.0
        gradient[k, 0] = gradient[k, 1] = 0.0
        if n > 0.0:
            x, y = x / n, y / n
            xx, xy, yy = xx / n - x * x, xy / n - x * y, yy / n - y * y
            sx, sy = sx / n - value[k] * x, sy / n - value[k] * y
            size = xx * yy - xy * xy
            if size > 1e-6 * (xx + yy) ** 2:
                g_x, g_y = (yy * sx - xy * sy) / size, (xx * sy - xy * sx) / size
                value[k] -= g_x * x + g_y * y
                gradient[k, 0], gradient[k, 1] = g_x / grid[2], g_y / grid[2]


@compiled
def steepest_turn(signal, east, north, side):
    """Bound of how fast the signal's gradient changes with the place: |s_xx| + |s_yy|."""
    wide, high = signal.shape
    most = 0.0
    for i in range(wide):
        before, after = i - 1 if i else wide - 1, i + 1 if i + 1 < wide else 0
        for j in range(high):
            below, above = j - 1 if j else high - 1, j + 1 if j + 1 < high else 0
            s = signal[i, j]
            x = east[i, j] * (signal[after, j] - s) + east[before, j] * (signal[before, j] - s)
            y = north[i, j] * (signal[i, above] - s) + north[i, below] * (signal[i, below] - s)
            most = max(most, abs(x) + abs(y))
    return most / (side * side)
