"""What the commands do, one module for each group of them; imported when a command is called."""
