"""PySPH's side of ``apmethod bench sums``, run by the interpreter that has PySPH.

It knows nothing of this package.  Each line that it reads is a command, each line that it
writes the answer, both JSON:

    {"positions": FILE}   take positions from an .npy file, of shape (n, 2), and search
                          once to be warm                       -> {}
    {"run": true}         search and sum once                   -> {"seconds": ...}
    {"sums": FILE}        write density and gradient to an .npz -> {}
    {"pairs": true}       count the pairs                       -> {"pairs": ...}

    pysph_worker.py CORE_RADIUS ordered|given

"given" leaves the agents in the order of the positions; "ordered" keeps them in the order
of PySPH's own cells, which it likes best.  Of its searches that give right sums, the one
that is fastest in a short trial is used.
"""

import json
import os
import sys
import time

import numpy as np

#: Searches to try: PySPH's default, the same with kept neighbours, and z-ordered cells.
CANDIDATES = (("LinkedListNNPS", False), ("LinkedListNNPS", True), ("ZOrderNNPS", False))


def equations():
    """rho_i = sum_j m_j W_ij and sum_j m_j grad_i W_ij as one PySPH equation."""
    from pysph.sph.equation import Equation, Group

    class DensityAndGradient(Equation):
        def initialize(self, d_idx, d_rho, d_grad_x, d_grad_y):
            d_rho[d_idx] = 0.0
            d_grad_x[d_idx] = 0.0
            d_grad_y[d_idx] = 0.0

        def loop(self, d_idx, s_idx, d_rho, d_grad_x, d_grad_y, s_m, WIJ, DWIJ):
            d_rho[d_idx] += s_m[s_idx] * WIJ
            d_grad_x[d_idx] += s_m[s_idx] * DWIJ[0]
            d_grad_y[d_idx] += s_m[s_idx] * DWIJ[1]

    return [Group([DensityAndGradient("agents", ["agents"])])]


class Sums:
    """Agents of equal mass, together 1, and their sums by one of PySPH's searches."""

    def __init__(self, positions, core_radius, ordered, search, cache):
        from pysph.base import nnps
        from pysph.base.kernels import CubicSpline
        from pysph.base.utils import get_particle_array
        from pysph.sph.acceleration_eval import AccelerationEval
        from pysph.sph.sph_compiler import SPHCompiler

        count = len(positions)
        kernel = CubicSpline(dim=2)
        self.agents = get_particle_array(
            name="agents", x=positions[:, 0], y=positions[:, 1], m=1.0 / count,
            h=core_radius / kernel.radius_scale, number=np.arange(float(count)),
            additional_props=["grad_x", "grad_y"],
        )  # fmt: skip
        self.evaluation = AccelerationEval([self.agents], equations(), kernel)
        SPHCompiler(self.evaluation, None).compile()
        self.search = getattr(nnps, search)(
            dim=2, particles=[self.agents], radius_scale=kernel.radius_scale, cache=cache
        )
        self.evaluation.set_nnps(self.search)
        if ordered:
            self.search.spatially_order_particles(0)
        self.run()

    def put(self, positions):
        """Put the agents elsewhere, positions in the order they were first given."""
        order = self.agents.number.astype(int)
        self.agents.x[:] = positions[order, 0]
        self.agents.y[:] = positions[order, 1]

    def run(self):
        """Search and sum once; the seconds it took."""
        began = time.perf_counter()
        self.search.update_domain()
        self.search.update()
        self.evaluation.compute(0.0, 0.1)
        return time.perf_counter() - began

    def sums(self):
        """Density and gradient in the order the agents were first given."""
        place = np.argsort(self.agents.number)
        gradient = np.column_stack([self.agents.grad_x, self.agents.grad_y])
        return self.agents.rho[place], gradient[place]

    def pairs(self):
        """Number of pairs that the search finds."""
        from cyarray.api import UIntArray

        found = UIntArray()
        count = self.agents.get_number_of_particles()
        both_ends = 0
        for agent in range(count):
            self.search.get_nearest_particles(0, 0, agent, found)
            both_ends += found.length
        return (both_ends - count) // 2


def fastest(positions, core_radius, ordered):
    """The search that takes the least time of those whose sums agree with the first's."""
    best, least, expected = None, np.inf, None
    for search, cache in CANDIDATES:
        sums = Sums(positions, core_radius, ordered, search, cache)
        density = sums.sums()[0]
        expected = density if expected is None else expected
        seconds = min(sums.run() for _ in range(3))
        if np.allclose(density, expected, rtol=1e-9) and seconds < least:
            best, least = sums, seconds
            best.name = search + (" with cache" if cache else "")
    return best


def answer(command, state, core_radius, ordered):
    """Carry out one command; the answer to send."""
    if "positions" in command:
        positions = np.load(command["positions"])
        if "sums" not in state:
            state["sums"] = fastest(positions, core_radius, ordered)
        state["sums"].put(positions)
        return {"search": state["sums"].name}
    if "run" in command:
        return {"seconds": state["sums"].run()}
    if "sums" in command:
        density, gradient = state["sums"].sums()
        np.savez(command["sums"], density=density, gradient=gradient)
        return {}
    if "pairs" in command:
        return {"pairs": state["sums"].pairs()}
    raise ValueError(f"unknown command {command}")


def main():
    """Answer commands until there are no more."""
    # PySPH and the compilers that it starts print; only answers may go to the caller.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    from compyle.config import get_config

    get_config().use_openmp = True
    state, core_radius, ordered = {}, float(sys.argv[1]), sys.argv[2] == "ordered"
    for line in sys.stdin:
        reply = answer(json.loads(line), state, core_radius, ordered)
        answers.write(json.dumps(reply) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
