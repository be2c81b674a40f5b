"""Run the Python of pages as a reader would who has typed `scdpr demo` before.

    python page_runs.py FOLDER PAGE …

The README's blocks come first: what they fit and tune becomes the files that other pages read.
Each page has one namespace. Prints, as JSON, what went wrong by page and line.
"""

import json
import os
import pathlib
import sys
import traceback

from pages import README, python_blocks

from experiments.runtime import set_up
from experiments.virtual_rig import rig
from identification import write_campaign, write_frequencies, write_parameters
from tuning import write_tuning

SEED = 1


def main(folder, pages):
    os.chdir(folder)
    demo = pathlib.Path("demo")
    demo.mkdir()
    set_up()
    made = rig.campaign(rig.draw_truth(SEED), SEED).with_runs(rig.DEMONSTRATED)
    write_campaign(made, demo / "campaign")
    wrong = {}
    for page in (README, *(own for own in pages if own != README)):
        wrong[page] = run(page, names := {})
        if page == README and not wrong[page]:
            write_parameters(demo / "parameters.json", names["estimate"])
            write_frequencies(names["frequencies"], demo / "frequencies.csv")
            write_tuning(demo / "tuning.json", names["tuned"])
    return wrong


def run(page, names):
    for block in python_blocks(page):
        try:
            # The code is this project's own.
            exec(compile("\n" * (block.line - 1) + block.text, page, "exec"), names)
        except BaseException:  # whatever a block raises is the page's fault, and told
            return traceback.format_exc()
    return ""


if __name__ == "__main__":
    told = main(sys.argv[1], sys.argv[2:])
    pathlib.Path("told.json").write_text(json.dumps(told))
