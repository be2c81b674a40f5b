"""A scalar program as text: LLVM IR for the process itself, C99 for a controller."""
