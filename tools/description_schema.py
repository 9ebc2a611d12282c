#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Writes what motors, tips, sections and strain bases declare into the schema of descriptions."""

from __future__ import annotations

import json
from pathlib import Path

from cpr_core.description.description_schema import description_schema

SCHEMA = Path(__file__).parents[1] / "cpr_core/description/description.schema.json"

if __name__ == "__main__":
    SCHEMA.write_text(json.dumps(description_schema(), indent=2) + "\n", encoding="utf-8")
