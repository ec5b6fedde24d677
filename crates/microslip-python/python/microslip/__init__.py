"""Frequency and damping of bolted joints against amplitude."""
