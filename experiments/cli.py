"""The command line: `scdpr VERB …`.

Nothing heavy is imported before a verb is chosen, and here only what Python has loaded already:
an import that Ctrl-C comes into ends with a traceback, unless `main` has begun.
"""

import errno
import gc
import io
import os
import sys

from experiments.verbs.exit_status import BAD_INPUT, DONE, FELL_SHORT, STOPPED, UNHEARD

VERBS: dict[str, dict[str, str]] = {
    "main": {
        "demo": "the main job on a campaign that it generates itself: truth beside estimate",
        "calibrate": "the main job: check, identify, frequencies, tune, report",
        "check": "the log doctor: every fault with file, row, cause and remedy",
    },
    "identification": {
        "identify": "the robot's parameters with their uncertainty: parameters.json",
        "identify-drive": "one motor-driven axis: inertia, friction, offset from a log",
        "import": "logs of any make as runs of format 1, as a mapping says; or its proposal",
        "track": "poses from a video of the rig: camera.csv",
        "frequencies": "natural frequency and damping of every knock: frequencies.csv",
        "design": "which experiment next: the run that narrows an interval the most a second",
    },
    "tuning": {
        "tune": "gains and input shapers from parameters and frequencies: tuning.json, export/",
        "plan": "references and feed-forward of one leg that arrives without vibration",
        "refine": "the tuned robot, corrected by legs that were logged",
        "shape": "the input shaper for a measured spectrum: shaper.json",
        "codesign": "gains, shaper and leg together, over poses, settings and what is unknown",
    },
    "study": {
        "show": "results on this machine's own address: report, robot moving, legs to try",
        "simulate": "one manoeuvre of a fitted robot",
        "sweep": "frequency, workspace or closed loop over poses and parameters: netCDF",
        "benchmark": "error beside speed, for this engine and its peers",
        "reproduce": "the paper's tables and figures, beside what is printed, and judged",
    },
}
"""Every verb and what it does, by the wing of `experiments.verbs` that it stands in."""


def main(arguments: list[str] | None = None) -> int:
    """Run a verb.

    Args:
        arguments: What follows the command's name; default: the process's arguments.

    Returns:
        0 done, 1 fell short, 2 bad input, 130 stopped, 143 terminated.
    """
    if arguments is not None:
        return _run(arguments)
    try:
        return _alone(sys.argv[1:])
    except KeyboardInterrupt:  # while what hears Ctrl-C was still loading
        os.write(2, b"scdpr: stopped. No file is half written.\n")
        os._exit(STOPPED)


def _alone(arguments: list[str]) -> int:
    """Run a verb in a process that is this command's alone."""
    # Ctrl-C waits until there is somebody who heeds it: an import may swallow it, as Python
    # clears its locks in callbacks whose exceptions go nowhere. `signal` itself has imports.
    if sys.platform != "win32":
        import _signal

        _signal.pthread_sigmask(_signal.SIG_BLOCK, [_signal.SIGINT])
    from experiments.verbs.ending import end_on_signals, leave

    end_on_signals(next(iter(arguments), ""))
    if sys.platform != "win32":
        _signal.pthread_sigmask(_signal.SIG_UNBLOCK, [_signal.SIGINT])
    for stream in (sys.stdout, sys.stderr):
        # A name that the terminal's encoding hasn't is written out, as in `ls`.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        status = _run(arguments)
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else DONE
    except OSError as error:  # of the help itself
        status = _told("", _unusable(error), BAD_INPUT)
    return leave(status)


def _run(arguments: list[str]) -> int:
    """Run a verb, and say what was wrong."""
    if not arguments or arguments[0] in ("-h", "--help"):
        print(_help())
        return DONE if arguments else BAD_INPUT
    _prepare_process()
    verb, *rest = arguments
    wings = {name: wing for wing, verbs in VERBS.items() for name in verbs}
    if verb == "--version":
        from importlib.metadata import version

        print(f"scdpr-jax {version('scdpr-jax')}")
        return DONE
    if verb not in wings:
        import difflib

        near = difflib.get_close_matches(verb, wings, n=1)
        hint = f" Did you mean `scdpr {near[0]}`?" if near else ""
        print(
            f"scdpr: unknown verb, got {verb!r}, expected one of: {', '.join(wings)}.{hint} "
            "See `scdpr --help`.",
            file=sys.stderr,
        )
        return BAD_INPUT
    import contextlib
    import importlib
    import keyword

    import tyro

    name = verb.replace("-", "_") + "_" * keyword.iskeyword(verb)
    chosen = getattr(importlib.import_module(f"experiments.verbs.{wings[verb]}.{name}"), name)
    from experiments.verbs.help_text import check_options, described, fitted_help

    try:
        check_options(chosen, rest)
        asked = not {"-h", "--help"}.isdisjoint(rest)
        with fitted_help(_columns()) if asked else contextlib.nullcontext():
            return tyro.cli(described(chosen), args=rest, prog=f"scdpr {verb}")
    except ValueError as error:
        return _told(verb, error, BAD_INPUT)
    except BrokenPipeError:
        # Nobody reads on: `scdpr check … | head`.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return UNHEARD
    except OSError as error:
        return _told(verb, _unusable(error), BAD_INPUT)
    except FloatingPointError as error:
        return _told(verb, error, FELL_SHORT)
    except MemoryError:
        return _told(verb, "the memory isn't enough. Give it less at once.", FELL_SHORT)
    except KeyboardInterrupt:
        return _told(verb, "stopped. No file is half written.", STOPPED)


def _told(verb: str, what: object, status: int) -> int:
    """The status, once it is said why."""
    from experiments.verbs.console import complain
    from scdpr_jax.numerics.files.harmless import message

    complain(message(f"{f'scdpr {verb}'.strip()}: {what}"))
    return status


def _unusable(error: OSError) -> str:
    """Why a file or a folder can't be used, and what to do."""
    remedy = "Name another place."
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        remedy = "Make room there, or name another place."
    elif error.errno == errno.ENOENT:
        remedy = "Check its name."
    where, reason = error.filename or "a file", error.strerror or str(error)
    expected = "one that can be read and written"
    return f"{where}: can't be used, got {reason}, expected {expected}. {remedy}"


def _prepare_process() -> None:
    """What has to be settled before NumPy is loaded, and before much is made."""
    for library in ("OPENBLAS", "MKL"):
        # Sums that threads share out come out otherwise on another number of cores; NumPy's
        # matrices are small here, and XLA has the cores.
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    # Libraries and figures make objects by the million that stay: looking for cycles among
    # them takes a sixth of the time.
    gc.set_threshold(100_000, 20, 20)


def _help() -> str:
    from experiments.page.wrapping import wrapped

    verbs = {name: does for wing in VERBS.values() for name, does in wing.items()}
    room = max(map(len, verbs)) + 4
    text = (
        ("usage: scdpr VERB …", ""),
        ("", ""),
        ("From a planar cable robot's logged runs to its parameters, gains and shapers.", ""),
        ("", ""),
        *((f"  {name}".ljust(room) + does, room * " ") for name, does in verbs.items()),
        ("", ""),
        ("`scdpr VERB --help` tells a verb's arguments.", ""),
        ("Exit status: 0 done, 1 fell short, 2 bad input, 130 stopped, 143 terminated.", ""),
    )
    return "\n".join(
        line for words, hanging in text for line in wrapped(words, _columns(), hanging=hanging)
    )


def _columns() -> int:
    """Columns of the terminal; a file or a pipe has no width."""
    import shutil

    return shutil.get_terminal_size((100_000, 24)).columns


if __name__ == "__main__":
    sys.exit(main())
