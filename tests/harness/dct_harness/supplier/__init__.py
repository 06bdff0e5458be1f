"""A supplier's plant under our names: mapping files, and how well it keeps the contract."""
