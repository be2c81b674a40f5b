"""Campaigns that can't be read, as units that compute nothing."""

from experiments.runtime.job import Job
from experiments.runtime.parcel import Parcel
from experiments.studies.campaigns.files import packed_files

NAMES = [f"rig-{number}" for number in range(12)]
FACTS = {"names": NAMES, "question": {}, "accept": [], "skip_bad_runs": False}


def job_of(folder):
    """A job of them by an installation, each refused for a reason of its own."""
    for name in NAMES:
        (folder / name).mkdir()
        (folder / name / "campaign.toml").write_text(f"{name} = 1")
    return lambda installed: Job(
        "identify",
        Parcel(FACTS),
        len(NAMES),
        installed,
        lambda number: packed_files(folder / NAMES[number]),
    )
