"""Tables in place of a law, where nothing in the library will do: balance, tabulate, latent, suggest."""
