"""Gains, impulses and the leg's shape designed together, for the worst of many models."""

from tuning.codesign.codesign_file import read_law as read_law
from tuning.codesign.codesign_file import write_codesign as write_codesign
from tuning.codesign.designed import Designed as Designed
from tuning.codesign.designed import evaluate as evaluate
from tuning.codesign.front import front as front
from tuning.codesign.front import knee as knee
from tuning.codesign.front import usual_move_times as usual_move_times
from tuning.codesign.models import Models as Models
from tuning.codesign.models import models as models
from tuning.codesign.recommendation import CoDesign as CoDesign
from tuning.codesign.recommendation import Scope as Scope
from tuning.codesign.recommendation import recommend as recommend
from tuning.codesign.search import co_design as co_design
from tuning.codesign.shaped_legs import references as references
