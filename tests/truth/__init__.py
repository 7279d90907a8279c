"""Independent simulators and sealed cases: they share no line, no state variable and no solver with what they judge."""
