"""Studies: cases, samples, workers here or on a cluster, and the store of their rows."""
