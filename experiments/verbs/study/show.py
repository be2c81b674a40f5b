"""`scdpr show`: a folder of results as pages on this machine's own address."""

from experiments.runtime import set_up
from experiments.verbs.console import OUT, Folder


def show(folder: Folder, /, port: int = 0) -> int:
    """Show results on this machine's own address, 127.0.0.1, until Ctrl-C.

    The report, the robot moving in a run to choose, legs to try with sliders for start, end and
    time, and every file to download. Nothing is written.

    Args:
        folder: Folder of results of `scdpr calibrate`, `demo`, `identify` or `tune`.
        port: Port; default: any that is free.
    """
    set_up()
    from experiments.reports.show.results import open_results
    from experiments.reports.show.server import ADDRESS, server

    serving, shown = server(open_results(folder), port=port)
    number = serving.server_address[1]
    OUT.print(f"{folder} is shown at http://{ADDRESS}:{number}/ until Ctrl-C", soft_wrap=True)
    try:
        serving.serve_forever()
    finally:
        serving.server_close()
        if shown.planning is not None:
            shown.planning.close()
