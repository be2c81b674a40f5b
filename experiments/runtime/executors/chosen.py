"""The executor that a call asks for: `--cores` and `--cluster`."""

import contextlib
import logging
import pathlib
import warnings
from collections.abc import Iterator

from experiments.runtime.executors.executor import Executor
from experiments.runtime.executors.here import ThisProcess
from experiments.runtime.executors.processes import Processes

CERTIFICATES = ("ca.pem", "cert.pem", "key.pem")
"""Files of `--certificates`: who signs, the own certificate, its key."""
_LOCAL = {
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.tick.cycle": "10s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.system-monitor.disk": False,
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.scheduler.work-stealing": False,
}
"""A local cluster looks at itself once a second: as dask does it by default, its processes take
6 % of a core while they wait, and so 1 %."""
ANSWERS_WITHIN = 15.0
"""How long a scheduler may take to answer [s]."""


def require_cluster(
    cluster: str | None, certificates: pathlib.Path | None, cores: int | None
) -> None:
    """Refuse what can't be a cluster, before anything is computed.

    Args:
        cluster: `--cluster`.
        certificates: `--certificates`.
        cores: `--cores`.

    Raises:
        ValueError: If it is no address, certificates are missing, or dask is.
    """
    if cores is not None and (cores < 1 or cluster is not None):
        raise ValueError(
            f"`--cores`: got {cores}{' beside `--cluster`' if cluster else ''}, expected a "
            "number of processes, 1 or more, and no cluster. Leave it out for what suits most."
        )
    if cluster is None:
        if certificates is not None:
            raise ValueError("`--certificates` belong to `--cluster tls://…`, got none of it.")
        return
    _number(cluster)
    if cluster.startswith("tls://") != (certificates is not None):
        raise ValueError(
            f"`--certificates`: got {certificates or 'none'} for {cluster}, expected a folder "
            f"with {', '.join(CERTIFICATES)} for tls:// and for nothing else."
        )
    missing = [
        name for name in CERTIFICATES if certificates and not (certificates / name).is_file()
    ]
    if missing:
        raise ValueError(
            f"`--certificates`: {certificates} has no {', '.join(missing)}, expected who signs "
            "the certificates, the own one, and its key. Ask who runs the cluster."
        )
    try:
        import distributed as distributed
    except ImportError:
        raise ValueError(
            "`--cluster` needs dask, got no `distributed`. Install it: pip install "
            "'scdpr-jax[cluster]'."
        ) from None


@contextlib.contextmanager
def chosen(
    cluster: str | None, certificates: pathlib.Path | None, cores: int
) -> Iterator[Executor]:
    """Who computes what a call asks for.

    Args:
        cluster: `--cluster`: "tcp://HOST:PORT", "tls://HOST:PORT" or "local:N"; None for none.
        certificates: `--certificates`, a folder with the files of `CERTIFICATES`.
        cores: How many processes of this machine; 1 for this one.

    Yields:
        The executor.

    Raises:
        ValueError: If a cluster can't be reached.
    """
    require_cluster(cluster, certificates, None)
    if cluster is None:
        yield Processes(cores) if cores > 1 else ThisProcess()
        return
    import dask
    from distributed import Client, LocalCluster
    from distributed.security import Security

    from experiments.runtime.executors.cluster import Cluster

    number = _number(cluster)
    with contextlib.ExitStack() as stack:
        stack.enter_context(_quiet())
        if number:
            stack.enter_context(dask.config.set(_LOCAL))
            # With certificates of its own: other users of this machine are kept out.
            security = Security.temporary()
            local = stack.enter_context(
                LocalCluster(
                    n_workers=number,
                    threads_per_worker=1,
                    dashboard_address="127.0.0.1:0",
                    security=security,
                )
            )
            address = local.scheduler_address
        else:
            address, security = cluster, _security(certificates)
        executor = Cluster(
            lambda: Client(address, security=security, timeout=ANSWERS_WITHIN), cluster
        )
        stack.callback(executor.close)
        yield executor


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Nothing of what dask says of itself: what is lost is asked for anew, or is an error."""
    names = [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    loggers = [logging.getLogger(name) for name in names]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            # A campaign of 10 MB is large to it.
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _security(certificates: pathlib.Path | None) -> "Security | None":  # noqa: F821
    """What proves to a cluster who asks it, and that it is the one that was meant."""
    if certificates is None:
        return None
    from distributed.security import Security

    authority, own, key = (str(certificates / name) for name in CERTIFICATES)
    return Security(
        tls_ca_file=authority, tls_client_cert=own, tls_client_key=key, require_encryption=True
    )


def _number(cluster: str) -> int:
    """Workers of `local:N`; 0 for an address."""
    kind, _, rest = cluster.partition(":")
    if kind == "local" and rest.isascii() and rest.isdecimal() and 1 <= int(rest) <= 1024:
        return int(rest)
    if kind in ("tcp", "tls") and rest.startswith("//") and ":" in rest:
        return 0
    raise ValueError(
        f"`--cluster`: got {cluster!r}, expected tcp://HOST:PORT or tls://HOST:PORT of a dask "
        "scheduler, or local:N for one of N workers on this machine."
    )
