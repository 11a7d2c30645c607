"""Two viscoelastic spheres of Wahn, Gan & Kamlah 2022 (doi:10.1142/S2424913022410053), done again with numbers.

`python -m cases.wahn_gan_kamlah_2022 [--out DIR]` computes the continuum, follows old and new laws beside it, and writes tables, the
figures 9, 10 and 12, what the paper's 5.4 % are made of, and what terms and Ting's retreat cost. With `--packings` the same is done with
section 5: figures 13 to 16 as bands over packings, every statement judged, and jamming.
"""
