"""Runs of many steps as machine code, printed from the step's own equations.

`run` ← `primitive` (what JAX sees; `reverse`: its reverse mode) ← `machine` (made, `kept` on
disk, made known to XLA) ← `handler`, `kernel` and `interface` (what XLA calls) ← `printers`
(LLVM IR, C99) ← `scalar` (the step as a program of single numbers) ← `traced` (its jaxpr).
`kept_jit` compiles functions with such runs in them, and keeps what was traced.
"""

from .direct import Held as Held
from .direct import Runs as Runs
from .direct import Slopes as Slopes
from .kept.programs import kept_jit as kept_jit
from .running import run as run
from .running import scan as scan
