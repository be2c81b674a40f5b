"""Logged runs to parameters with their uncertainty."""

from identification.axis.drive_axis import DriveAxisEstimate as DriveAxisEstimate
from identification.axis.drive_axis import estimate_drive_axis as estimate_drive_axis
from identification.axis.log import AxisLog as AxisLog
from identification.axis.log import read_axis_log as read_axis_log
from identification.campaign import Campaign as Campaign
from identification.campaign import CampaignError as CampaignError
from identification.campaign import check_campaign as check_campaign
from identification.campaign import read_campaign as read_campaign
from identification.campaign import write_campaign as write_campaign
from identification.checks.selection import select as select
from identification.fit.comparison import Channel as Channel
from identification.fit.comparison import Comparison as Comparison
from identification.fit.unknowns.measured import MeasuredBreakaway as MeasuredBreakaway
from identification.fit.unknowns.measured import MeasuredFrequency as MeasuredFrequency
from identification.fit.unknowns.measured import MeasuredQuantity as MeasuredQuantity
from identification.fit.unknowns.measured_text import parse_measured as parse_measured
from identification.judge.identifiability import Identifiability as Identifiability
from identification.judge.uncertainty import ParameterEstimate as ParameterEstimate
from identification.knocks.frequency_map import FrequencyMap as FrequencyMap
from identification.knocks.frequency_map import frequency_map as frequency_map
from identification.knocks.frequency_map import read_frequencies as read_frequencies
from identification.knocks.frequency_map import write_frequencies as write_frequencies
from identification.knocks.ring_down import RingDown as RingDown
from identification.knocks.ring_down import ring_down as ring_down
from identification.result.estimate import Estimate as Estimate
from identification.result.estimate import estimate as estimate
