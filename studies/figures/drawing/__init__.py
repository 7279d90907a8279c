"""What all figures share: style (how they look), panels (figures and their axes), conditions, lines, files."""
