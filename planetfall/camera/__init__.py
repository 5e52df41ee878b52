"""Cameras, named views and flights, in double precision; nothing here draws."""
