"""Contacts in time: each touch keeps its number from its onset to its release, gathers its answer, and tells events."""
