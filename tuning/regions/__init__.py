"""Where in the workspace which shaper holds, and what it leaves there."""
