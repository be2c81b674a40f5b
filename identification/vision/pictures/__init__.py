"""Pictures of a video, read by a process of their own."""
