"""Vector instructions as wide as the processor's.

LLVM compiles for vectors of four numbers on processors that have eight, as the first of
those had to clock down for them.  Sums over pairs are nothing but vector instructions: with
eight, those of a Gaussian kernel take 0.7 of the time.

This holds for all that numba compiles in the process, and it has to be said before numba
compiles for the first time; said later, passes run on narrower vectors.
"""

from numba.core import codegen, config

#: Processors from this instruction set on run wide vectors at full pace.
_AT_FULL_PACE = "+avx512vbmi2"
_WIDE = "-prefer-256-bit"

if config.CPU_FEATURES is None:  # ``$NUMBA_CPU_FEATURES`` comes first
    _features = codegen.get_host_cpu_features()
    if _AT_FULL_PACE in _features.split(","):
        config.CPU_FEATURES = f"{_features},{_WIDE}"

#: Numbers in the widest vectors there may be.
LANES = 8
