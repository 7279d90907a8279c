"""The noise of measured channels: process, hum, estimation, left_over, sampling."""
