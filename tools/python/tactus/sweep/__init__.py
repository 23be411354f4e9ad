"""Sweeps: many runs in virtual time, each a process and a result file of its own; behind `tactus sweep`."""
