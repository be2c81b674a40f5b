"""Parts of the calibration's report."""
