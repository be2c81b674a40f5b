"""What people run: the command line, the pipeline, reports and the virtual rig."""
