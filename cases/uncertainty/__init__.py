"""What the errors of a fitted law and the chance of a packing do to the stress of a scene: bands, and the share of each."""
