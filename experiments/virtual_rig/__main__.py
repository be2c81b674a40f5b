"""`python -m experiments.virtual_rig`: how often a fit finds and covers the truth."""

import argparse
import os
import pathlib
import sys


def main(arguments: list[str] | None = None) -> int:
    """Draw robots, estimate them, write a table, and count.

    Args:
        arguments: What the command line says; None for this process's.

    Returns:
        0; 1 where some have failed, 2 where nothing could begin.
    """
    given = _parser().parse_args(arguments)
    # Sums that threads share out come out otherwise on another number of cores; settled before
    # NumPy is loaded, as in `scdpr`.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("MKL_NUM_THREADS", "1")
    from experiments.runtime import set_up
    from experiments.runtime.executors.chosen import chosen, require_cluster
    from experiments.virtual_rig.monte_carlo import monte_carlo
    from scdpr_jax.numerics.progress import Progress

    seeds = range(given.first, given.first + given.campaigns)
    try:
        require_cluster(given.cluster, given.certificates, given.cores)
        set_up()
        with chosen(given.cluster, given.certificates, given.cores or 1) as executor:
            made = monte_carlo(
                seeds,
                given.out,
                executor=executor,
                distrusted=lambda each: print(f"{each.name}: {each.why}", file=sys.stderr),
                progress=Progress(lambda doing, share: print(doing, file=sys.stderr)),
            )
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    print("\n".join([*made.summary(), f"wrote {given.out}"]))
    for seed, reason in made.failed.items():
        print(f"seed {seed} failed: {reason}")
    return 1 if made.failed else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m experiments.virtual_rig", description=__doc__
    )
    add = parser.add_argument
    add("--campaigns", type=int, default=100, help="robots to draw")
    add("--first", type=int, default=0, help="seed of the first one")
    add("--out", type=pathlib.Path, required=True, help="table of how they went, .csv")
    add("--cores", type=int, help="processes of this machine; default: this one")
    add("--cluster", help="a dask cluster: tcp://HOST:PORT, tls://HOST:PORT or local:N")
    add("--certificates", type=pathlib.Path, help="folder with ca.pem, cert.pem and key.pem")
    return parser


if __name__ == "__main__":
    sys.exit(main())
