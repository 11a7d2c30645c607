"""Slow comparisons of what this project computes with analysis and with other codes; each is run as `python -m cases.verification.NAME`."""
