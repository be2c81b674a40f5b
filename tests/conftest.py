"""Strict numerics and run-time shape checks for every test."""

from jaxtyping import install_import_hook

# Before anything imports the packages: every annotated shape is checked by beartype.
install_import_hook(
    ["scdpr_jax", "identification", "tuning", "experiments"], "beartype.beartype"
)

import hypothesis  # noqa: E402
import jax  # noqa: E402

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_numpy_dtype_promotion", "strict")
jax.config.update("jax_numpy_rank_promotion", "raise")
jax.config.update("jax_platforms", "cpu")

# Compilation takes the first example longer than any deadline; no example depends on luck.
hypothesis.settings.register_profile("deterministic", deadline=None, derandomize=True)
hypothesis.settings.load_profile("deterministic")
