"""The noise of measured channels: process, hum, estimation, first_order, sampling."""
