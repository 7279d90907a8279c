"""The noise of measured channels: process, hum, estimation, sampling."""
