"""Strict numerics and run-time shape checks for every test."""

import os

# As the command line has it: two workers whose matrices have two threads each wait for cores.
for _library in ("OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

import pathlib  # noqa: E402

from jaxtyping import install_import_hook  # noqa: E402

_ROOT = pathlib.Path(__file__).resolve().parents[1]


def _with_shapes() -> list[str]:
    """Names of the modules that annotate shapes."""
    packages = ("scdpr_jax", "identification", "tuning", "experiments")
    files = [path for own in packages for path in (_ROOT / own).rglob("*.py")]
    annotated = [path for path in files if "jaxtyping" in path.read_text(encoding="utf-8")]
    return [".".join(path.relative_to(_ROOT).with_suffix("").parts) for path in annotated]


# Before anything imports them: every annotated shape is checked by beartype. A check costs more
# than what many a small function does, so what has no shapes goes without.
install_import_hook(_with_shapes(), "beartype.beartype")

import hypothesis  # noqa: E402

# What one process compiles the others needn't, nor the next run.
_CACHE = _ROOT / ".pytest_cache" / "jax"
os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(_CACHE))
os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.3")

import jax  # noqa: E402

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_numpy_dtype_promotion", "strict")
jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_platforms", "cpu")

# Compilation takes the first example longer than any deadline; no example depends on luck.
hypothesis.settings.register_profile("deterministic", deadline=None, derandomize=True)
hypothesis.settings.load_profile("deterministic")
