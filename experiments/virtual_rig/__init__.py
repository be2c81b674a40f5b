"""A virtual rig: campaigns whose truth is known."""
