"""Who computes units: this process, processes of this machine, a cluster."""
