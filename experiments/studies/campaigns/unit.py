"""A unit of a batch: a campaign, read, examined and identified wherever it is asked for."""

import dataclasses
import json
import pathlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from experiments.runtime.parcel import Parcel, packed, unpacked
from experiments.studies.campaigns.files import unpack_files
from experiments.studies.campaigns.identified import Question, identified
from identification.campaign import read_campaign
from identification.campaign.abbreviation import run_names
from identification.doctor.accepted import admission
from identification.result.parameters_file import parameters_text
from scdpr_jax.numerics.files.scratch import scratch_folder
from scdpr_jax.provenance import UNKNOWN, Provenance, of_no_day


class Answer(NamedTuple):
    """What became of a campaign."""

    document: str
    """Its parameters.json; empty for none."""
    reason: str
    """Why there is none, or why it isn't to be used; empty if all is well."""

    @property
    def provenance(self) -> Provenance:
        """Where its parameters.json comes from."""
        return (
            Provenance(**json.loads(self.document)["provenance"]) if self.document else UNKNOWN
        )

    @property
    def parameters(self) -> Sequence[dict[str, Any]]:
        """The rows of its parameters.json; none where there is none."""
        return json.loads(self.document)["parameters"] if self.document else ()


def answer_of(content: bytes) -> Answer:
    """A campaign's answer from a unit's result.

    Args:
        content: The result.

    Returns:
        The answer.
    """
    return Answer(**unpacked(content).facts)


def begin(parcel: Parcel) -> Callable[[int, bytes], bytes]:
    """What identifies the campaigns of a batch.

    Args:
        parcel: What is asked of each, and their names.

    Returns:
        From a campaign's number and files to its answer, packed.
    """
    facts = parcel.facts
    question = Question.of(facts["question"])

    def computed(number: int, payload: bytes) -> bytes:
        name = facts["names"][number]
        with scratch_folder() as scratch:
            try:
                unpack_files(unpacked(payload), scratch / name)
                answer = _answer(scratch / name, question, facts)
            except (ValueError, FloatingPointError) as error:
                # Where it was read is of this moment alone.
                answer = Answer("", str(error).replace(str(scratch / name), name))
        return packed(Parcel(answer._asdict()))

    return computed


def _answer(folder: pathlib.Path, question: Question, facts: dict[str, Any]) -> Answer:
    read = read_campaign(folder, skip_bad_runs=facts["skip_bad_runs"])
    admitted, refused = admission(read, facts["accept"])
    if admitted is None:
        told = "; ".join(f"{finding.severity}: {finding}" for finding in refused)
        ids = " ".join(dict.fromkeys(finding.id for finding in refused))
        return Answer("", f"{told} Put it right, or accept it: `--accept {ids}`.")
    held_out = run_names(read, question.hold_out)
    found = identified(admitted, dataclasses.replace(question, hold_out=held_out))
    made = of_no_day(admitted.name, admitted.source)
    document = parameters_text(*found, admitted.accepted, made)
    reason = "" if found.estimate.fits else "the model does not fit the runs: see `scdpr check`"
    return Answer(document, reason)
