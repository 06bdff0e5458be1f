"""The closed loop: connect, start, step, record, in Python or by the compiled master."""
