"""What a system file says: components, scenario, connections, limits, and where each stands."""
