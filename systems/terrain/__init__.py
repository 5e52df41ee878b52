"""The solid ground: its height function, and the system that draws it."""
