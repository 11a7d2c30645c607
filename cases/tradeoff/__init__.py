"""What accuracy costs: the continuum solver and the laws, each error beside its price."""
