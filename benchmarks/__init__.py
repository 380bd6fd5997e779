"""Speed, accuracy and validation figures of gearcase: `python -m benchmarks`, `python -m benchmarks.validation`."""
