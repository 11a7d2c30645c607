"""The study of Edmans & Sinka 2020 (Unloading of elastoplastic spheres from large deformations), done again and judged.

`fe2dem run cases/edmans_sinka_2020/study.toml` computes the curves; `python -m cases.edmans_sinka_2020 FOLDER` makes of them the tables,
the figures and a page that says of every statement of the paper whether it holds.
"""
