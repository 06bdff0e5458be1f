"""Systems as SSP archives, and parameter sets (.ssv)."""
