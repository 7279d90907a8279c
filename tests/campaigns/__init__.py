"""Campaigns: thousands of seeded trials that look for a promise that is broken.

``python -m tests.campaigns inputs --trials 10000 --out DIR --jobs 2`` runs one. Each trial follows from its number
alone, every outcome is a line of ``DIR/inputs.jsonl``, and a campaign that was interrupted goes on where it ended.
``--first N --trials 1`` repeats a single trial, and ``--save`` adds a round to the record in ``rounds``.
"""
