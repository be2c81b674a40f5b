"""Logged runs to parameters with their uncertainty."""

from scdpr_jax.front_door import front_door as _front_door

__getattr__, __dir__ = _front_door(
    __name__,
    {
        "identification.axis.drive_axis": ("estimate_drive_axis",),
        "identification.axis.estimate": ("DriveAxisEstimate",),
        "identification.axis.law": (
            "AxisLaws",
            "axis_laws",
        ),
        "identification.axis.log": (
            "AxisLog",
            "read_axis_log",
        ),
        "identification.bring.campaign_import": ("import_campaign",),
        "identification.bring.drive_log": ("import_drive_stream",),
        "identification.campaign": (
            "Campaign",
            "CampaignError",
            "check_campaign",
            "read_campaign",
            "write_campaign",
        ),
        "identification.checks.leave_out": ("without_each_run",),
        "identification.checks.posterior": ("posterior",),
        "identification.checks.profile": ("profile",),
        "identification.checks.selection": ("select",),
        "identification.data.circumstances": ("Circumstances",),
        "identification.fit.comparison": (
            "Channel",
            "Comparison",
        ),
        "identification.fit.unknowns.measured": (
            "MeasuredBreakaway",
            "MeasuredFrequency",
            "MeasuredQuantity",
        ),
        "identification.fit.unknowns.measured_text": ("parse_measured",),
        "identification.fit.unknowns.options": ("FitOptions",),
        "identification.judge.identifiability": ("Identifiability",),
        "identification.judge.influence": ("Influence",),
        "identification.judge.likelihood": (
            "Posterior",
            "Profile",
        ),
        "identification.judge.uncertainty": ("ParameterEstimate",),
        "identification.knocks.frequency_map": (
            "FrequencyMap",
            "frequency_map",
            "read_frequencies",
            "write_frequencies",
        ),
        "identification.knocks.ring_down": (
            "RingDown",
            "ring_down",
        ),
        "identification.many.campaigns": ("estimate_each",),
        "identification.many.short_runs": (
            "ManyEstimates",
            "ShortRuns",
            "estimate_many",
        ),
        "identification.next_run.excitation": (
            "Excitation",
            "catalogue",
        ),
        "identification.next_run.expected_information": ("Rig",),
        "identification.next_run.next_experiment": (
            "Candidate",
            "propose",
        ),
        "identification.result.estimate": ("Estimate",),
        "identification.result.estimation": ("estimate",),
        "identification.result.fitted_robot": ("FittedRobot",),
        "identification.result.parameters_file": (
            "read_parameters",
            "write_parameters",
        ),
        "identification.vision.settings": ("read_vision",),
        "identification.vision.tracking": (
            "Tracked",
            "track",
        ),
    },
)
