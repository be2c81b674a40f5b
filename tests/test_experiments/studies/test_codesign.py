"""A co-design's searches are units: whoever computes, and whenever, designs are the same."""

import jax
import numpy as np
import pytest
from codesign_samples import designed

from experiments.runtime.executors.chosen import chosen
from experiments.runtime.executors.here import ThisProcess
from experiments.runtime.parcel import packed, unpacked
from experiments.studies.codesign import unit
from experiments.studies.codesign.kept import kept_designs
from scdpr_jax.numerics.progress import SILENT, Progress
from scdpr_jax.robot.prototype import consistent
from tuning.codesign import models
from tuning.codesign.search import Search, Start, in_turn
from tuning.loop.admissible import any_bounds

ROBOT = consistent()
SEEN = models([ROBOT], begin=0.3, ends=(1.1, 1.9), heights=(0.3, 0.85))
SEARCH = Search(SEEN, any_bounds(ROBOT), 2.3)
STARTS = [Start(0.1 * number + np.arange(12.0) / 20, 2.3) for number in range(3)]


@pytest.fixture
def quick(monkeypatch):
    """Searches that end where they start, as what is in question isn't their end."""

    def design(self, begin, *, progress=SILENT):
        assert len(self.models) == len(SEEN)
        found = designed([begin.move_time * 1e-3, float(begin.point[0])])
        return found.__class__(
            found.law, begin.move_time, found.costs, found.measures, begin.point
        )

    monkeypatch.setattr(Search, "design", design)


def bits(design):
    leaves = jax.tree.leaves((design.law, design.measures, design.costs, design.point))
    return [np.asarray(leaf).tobytes() for leaf in leaves] + [design.move_time]


def kept(out, executor, progress=SILENT):
    with kept_designs(out, executor) as designer:
        found = designer(SEARCH, STARTS, progress)
        assert [path.name for path in out.iterdir()] == [".codesign-1.unfinished"]
    return [bits(each) for each in found]


def test_what_is_sought_arrives_whole():
    seen, within = unit.tree_of("sought", unpacked(packed(unit.parcel(SEARCH))).arrays,
                                unit._sought())  # fmt: skip
    sent, arrived = map(jax.tree.leaves, ((SEEN, SEARCH.within), (seen, within)))
    for before, after in zip(sent, arrived, strict=True):
        np.testing.assert_array_equal(before, after)
        assert before.dtype == after.dtype


def test_a_co_design_that_was_stopped_goes_on_to_the_same_bits(quick, tmp_path):
    expected = [bits(each) for each in in_turn(SEARCH, STARTS, SILENT)]

    def tell(doing, share):
        if share >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        kept(tmp_path, ThisProcess(), Progress(tell))
    told = []
    found = kept(tmp_path, ThisProcess(), Progress(lambda doing, share: told.append(doing)))
    assert found == expected
    assert told.count("co-design: 3 of 3 searches") == 1
    assert not list(tmp_path.iterdir())


def test_a_search_that_fails_is_told_and_the_others_are_kept(quick, tmp_path, monkeypatch):
    quick_design = Search.design

    def design(self, begin, *, progress=SILENT):
        if begin.point is not STARTS[1].point and begin.point[0] == STARTS[1].point[0]:
            raise FloatingPointError("not finite")
        return quick_design(self, begin)

    monkeypatch.setattr(Search, "design", design)
    with pytest.raises(FloatingPointError, match=r"1 of 3 searches .* number 2: .*not finite"):
        kept(tmp_path, ThisProcess())
    (folder,) = tmp_path.iterdir()
    assert len(list(folder.glob("*.unit"))) == 2


@pytest.mark.slow
@pytest.mark.parametrize("cluster", [None, "local:2"])
def test_processes_and_a_cluster_give_the_bits_of_this_process(tmp_path, cluster, monkeypatch):
    if cluster:
        pytest.importorskip("distributed")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    alone = [bits(each) for each in in_turn(SEARCH, STARTS, SILENT)]
    with chosen(cluster, None, 2) as executor:
        assert kept(tmp_path, executor) == alone
