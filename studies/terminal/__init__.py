"""What a terminal shows: console (what is printed, and how a command ends), tables."""
