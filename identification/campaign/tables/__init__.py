"""The text and CSV files of a campaign, cell by cell."""
