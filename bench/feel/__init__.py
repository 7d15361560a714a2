"""The acceptance bench for haptics: scenes, hands, plain baselines, experiments. `python bench/feel/run.py --help`."""
