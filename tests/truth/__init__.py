"""Independent simulators: they share no line, no state variable and no solver with what they judge."""
