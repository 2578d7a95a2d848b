"""The figures of the project, each printed by a seeded script."""
