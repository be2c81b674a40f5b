"""Runs without any motion, for tests that only look at what a run says of itself."""

import numpy as np

from identification.campaign import CameraStream, DriveStream, Knock, Run


def bare_run(kind, pretension=350.0):
    time = np.arange(100) * 1e-2
    still = np.zeros((100, 2))
    return Run(
        name=f"0001-{kind}",
        kind=kind,
        pretension=pretension,
        pretension_label=f"{pretension:g} N",
        drive=DriveStream(time=time, voltage=still, angle=still),
        camera=CameraStream(time=time, position=np.full((100, 5), 0.5)),
        knock=Knock(start=0.3, duration=0.03) if kind == "pseudo_impulse" else None,
    )
