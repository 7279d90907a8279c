"""The missing effect: what the library holds."""
