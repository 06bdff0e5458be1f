"""One FMU: its archive, its description, its library, here or in a process of its own."""
