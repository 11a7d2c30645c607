"""Becker & Kamlah (2021), elastoplastic ellipsoids, done again with spheroids: `python -m cases.becker_kamlah_2021`.

Figures 9 to 13 and 15, the constants of Eq. 53 for the authors' material and others, every statement judged; what is elastic, what is
loading and what is unloading in the law's errors, each apart.
"""
