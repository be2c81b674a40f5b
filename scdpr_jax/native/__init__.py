"""Runs of many steps as machine code, printed from the step's own equations.

`run` ← `primitive` (what JAX sees; `reverse`: its reverse mode) ← `machine` (made, kept in
`store`, made known to XLA) ← `handler`, `kernel` and `interface` (what XLA calls) ← `llvm_ir`,
`c99` (printers) ← `scalar` (the step as a program of single numbers) ← `traced` (its jaxpr).
"""

from .running import run as run
from .running import scan as scan
