"""demo_planet."""
