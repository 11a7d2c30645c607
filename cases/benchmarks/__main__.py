"""All benchmarks, one after the other."""

from __future__ import annotations

from cases.benchmarks import dem_speed, fe_speed

if __name__ == "__main__":
    fe_speed.main([])
    dem_speed.main()
