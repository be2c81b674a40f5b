"""What `scdpr tune` and `scdpr calibrate` write of a tuning."""

import jax.numpy as jnp
import pytest

from experiments.reports.tuning.files import write_tuned
from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from tuning.loop.margins import Margins
from tuning.result.regional_shaper import Region, RegionalShaper, ResidualVibration
from tuning.result.tuning import FittedSetting, Tuning

SHAPER = RegionalShaper(
    Region((0.0, 2.2), (0.0, 1.1), (350.0, 350.0)),
    0.55,
    Shaper([0.0, 0.157], [0.51, 0.49]),
    3.2,
    (3.1, 3.3),
    0.01,
    True,
    ResidualVibration(0.012, 0.057),
)


@pytest.mark.slow
def test_every_file_of_a_tuning_is_named_tuning_json_first(tmp_path):
    margins = Margins(*(jnp.asarray(number) for number in (40.0, 1.0, 0.02, 700.0, 30.0, 1.3)))
    robots = (FittedSetting(350.0, exact(consistent())),)
    written = write_tuned(tmp_path, Tuning(published_pd(), margins, (SHAPER,), (), robots))
    assert written.tuning == tmp_path / "tuning.json"
    assert written.paths[0] == written.tuning
    assert set(written.paths) == {path for path in tmp_path.rglob("*") if path.is_file()}
    assert {path.parent.name for path in written.exports} == {"export", "onboard"}
