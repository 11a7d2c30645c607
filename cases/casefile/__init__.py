"""What may stand in a case file, with units and bounds."""
