"""The topic `workspaces`."""
