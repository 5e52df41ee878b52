"""The demo: fly over a planet, or, without a display, render a flight to its ground. On the public API only."""
