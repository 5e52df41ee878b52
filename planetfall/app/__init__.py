"""The interactive program: window, keys, panels, journeys."""
