# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Paths of the paper with solutions of continuous rods, found by another method (test/data)."""

import csv
from pathlib import Path

import numpy as np

DATA = Path(__file__).parents[1] / "data"


def read(name):
    lines = [line for line in (DATA / name).read_text().splitlines() if not line.startswith("#")]
    return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]


def numbers(row, *keys):
    return np.array([row[key] for key in keys])


def straight_path(rows, keys):
    first, last = numbers(rows[0], *keys), numbers(rows[-1], *keys)
    return [first + (last - first) * t / 50 for t in range(51)]
