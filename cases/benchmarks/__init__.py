"""What things cost, beside what else does them; each is run as `python -m cases.benchmarks.NAME`."""
