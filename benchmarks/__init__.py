"""How fast everything is: ``make bench``, described in docs/performance.md."""
