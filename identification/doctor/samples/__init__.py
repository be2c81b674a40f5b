"""What a run's samples tell by themselves, before one sensor is held against another."""

from identification.doctor.samples.clocks import clocks as clocks
from identification.doctor.samples.duplicates import duplicates as duplicates
from identification.doctor.samples.encoders import encoders as encoders
from identification.doctor.samples.encoders import slow_jumps as slow_jumps
from identification.doctor.samples.excitation import excitation as excitation
from identification.doctor.samples.frames import frames as frames
from identification.doctor.samples.kinds import kinds as kinds
from identification.doctor.samples.knocks import knocks as knocks
from identification.doctor.samples.starts import starts as starts
from identification.doctor.samples.starts import swings as swings
from identification.doctor.samples.stuck import stuck as stuck
