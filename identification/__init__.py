"""Logged runs to parameters with their uncertainty."""

import types as _types

from identification.axis.drive_axis import DriveAxisEstimate as DriveAxisEstimate
from identification.axis.drive_axis import estimate_drive_axis as estimate_drive_axis
from identification.axis.log import AxisLog as AxisLog
from identification.axis.log import read_axis_log as read_axis_log
from identification.bring.importers import import_drive_stream as import_drive_stream
from identification.campaign import Campaign as Campaign
from identification.campaign import CampaignError as CampaignError
from identification.campaign import check_campaign as check_campaign
from identification.campaign import read_campaign as read_campaign
from identification.campaign import write_campaign as write_campaign
from identification.checks.leave_out import without_each_run as without_each_run
from identification.checks.posterior import posterior as posterior
from identification.checks.profile import profile as profile
from identification.checks.selection import select as select
from identification.data.circumstances import Circumstances as Circumstances
from identification.fit.comparison import Channel as Channel
from identification.fit.comparison import Comparison as Comparison
from identification.fit.unknowns.measured import MeasuredBreakaway as MeasuredBreakaway
from identification.fit.unknowns.measured import MeasuredFrequency as MeasuredFrequency
from identification.fit.unknowns.measured import MeasuredQuantity as MeasuredQuantity
from identification.fit.unknowns.measured_text import parse_measured as parse_measured
from identification.fit.unknowns.options import FitOptions as FitOptions
from identification.judge.identifiability import Identifiability as Identifiability
from identification.judge.influence import Influence as Influence
from identification.judge.likelihood import Posterior as Posterior
from identification.judge.likelihood import Profile as Profile
from identification.judge.uncertainty import ParameterEstimate as ParameterEstimate
from identification.knocks.frequency_map import FrequencyMap as FrequencyMap
from identification.knocks.frequency_map import frequency_map as frequency_map
from identification.knocks.frequency_map import read_frequencies as read_frequencies
from identification.knocks.frequency_map import write_frequencies as write_frequencies
from identification.knocks.ring_down import RingDown as RingDown
from identification.knocks.ring_down import ring_down as ring_down
from identification.many.campaigns import estimate_each as estimate_each
from identification.many.short_runs import ManyEstimates as ManyEstimates
from identification.many.short_runs import ShortRuns as ShortRuns
from identification.many.short_runs import estimate_many as estimate_many
from identification.next_run.excitation import Excitation as Excitation
from identification.next_run.excitation import catalogue as catalogue
from identification.next_run.expected_information import Rig as Rig
from identification.next_run.next_experiment import Candidate as Candidate
from identification.next_run.next_experiment import propose as propose
from identification.result.estimate import Estimate as Estimate
from identification.result.estimation import estimate as estimate
from identification.result.fitted_robot import FittedRobot as FittedRobot
from identification.result.parameters_file import read_parameters as read_parameters
from identification.result.parameters_file import write_parameters as write_parameters


def __dir__() -> list[str]:
    """What a user calls; the wings stay importable, and out of the way."""
    return [
        name
        for name, value in globals().items()
        if not name.startswith("_") and not isinstance(value, _types.ModuleType)
    ]
