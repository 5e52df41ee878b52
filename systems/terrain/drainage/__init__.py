"""Where water goes: rain, and the way from every piece of land to the sea."""
