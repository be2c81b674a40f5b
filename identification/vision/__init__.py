"""Poses from a video of the rig, the paper's section 4.2: `camera.csv` of a run."""
