"""How far computations are: a clock, how they usually go, and how they went here."""

from experiments.page.pace.clock import EVEN as EVEN
from experiments.page.pace.clock import Clock as Clock
from experiments.page.pace.clock import Detour as Detour
from experiments.page.pace.clock import Pace as Pace
from experiments.page.pace.clock import Standing as Standing
from experiments.page.pace.kept import expected as expected
from experiments.page.pace.kept import keep as keep
from experiments.page.pace.usual import USUAL as USUAL
