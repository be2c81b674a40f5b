"""The command line: `scdpr VERB …`. Nothing heavy is imported before a verb is chosen."""

import contextlib
import errno
import gc
import os
import shutil
import sys

from experiments.page.wrapping import wrapped
from experiments.verbs.exit_status import BAD_INPUT, DONE, FELL_SHORT, STOPPED

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
        "shape": "the input shaper for a measured spectrum: shaper.json",
        "codesign": "gains, shaper and leg together, over poses, settings and what is unknown",
    },
    "study": {
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
        0 done, 1 fell short, 2 bad input, 130 stopped.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
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
    import importlib
    import keyword

    import tyro

    name = verb.replace("-", "_") + "_" * keyword.iskeyword(verb)
    chosen = getattr(importlib.import_module(f"experiments.verbs.{wings[verb]}.{name}"), name)
    from experiments.verbs.console import complain
    from experiments.verbs.help_text import check_options, described, fitted_help

    try:
        check_options(chosen, rest)
        asked = not {"-h", "--help"}.isdisjoint(rest)
        with fitted_help(_columns()) if asked else contextlib.nullcontext():
            return tyro.cli(described(chosen), args=rest, prog=f"scdpr {verb}")
    except ValueError as error:
        complain(f"scdpr {verb}: {error}")
        return BAD_INPUT
    except BrokenPipeError:
        # Whoever read it has gone, `head` for one: what is left in the buffer has no reader.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        remedy = "Make room there, or name" if full else "Name"
        complain(
            f"scdpr {verb}: {error.filename or 'a file'}: can't be used, got "
            f"{error.strerror}, expected one that can be read and written. {remedy} another "
            "place."
        )
        return BAD_INPUT
    except FloatingPointError as error:
        complain(f"scdpr {verb}: {error}")
        return FELL_SHORT
    except KeyboardInterrupt:
        print(f"scdpr {verb}: stopped. No file is half written.", file=sys.stderr)
        return STOPPED


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
        ("Exit status: 0 done, 1 fell short, 2 bad input, 130 stopped.", ""),
    )
    return "\n".join(
        line for words, hanging in text for line in wrapped(words, _columns(), hanging=hanging)
    )


def _columns() -> int:
    """Columns of the terminal; a file or a pipe has no width."""
    return shutil.get_terminal_size((100_000, 24)).columns


if __name__ == "__main__":
    sys.exit(main())
