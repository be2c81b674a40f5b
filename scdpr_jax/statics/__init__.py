"""Static workspaces: the single loop's, Eq. (1), and the four-cable robot's."""
