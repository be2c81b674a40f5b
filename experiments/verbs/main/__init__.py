"""The verbs of the main job: demo, check and calibrate."""
