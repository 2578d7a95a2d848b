"""Ten questions to a corpus: a few recordings are drawn, answered into one table, and asked by DuckDB and Polars.

    python examples/ten_questions.py [TABLE]

Needs `pip install '.[files]' duckdb polars`. With a TABLE of `varishold touch -o` nothing is drawn: that is asked.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

try:
    import duckdb
    import polars as pl
except ModuleNotFoundError as error:
    sys.exit(f"{error.name} is not installed: pip install duckdb polars")

from varishold.corpus import AskTouch, run_corpus
from varishold.recording import Pad, Recording, write
from varishold.solids import Cone, Cylinder, Pyramid, Sphere, ideal_frame

# Each asks the table names.
QUESTIONS = {
    "1. How often was what felt?": "select name, count(*) as contacts from names group by name order by contacts desc",
    "2. How sure are the names?": """
        select name, round(avg(probability), 2) as probability, round(avg((probability >= 0.9)::int), 2) as sure
        from names group by name order by sure
    """,
    "3. Which contacts should a person look at?": """
        select file, frame, contact, name, probability, answer_set from names order by probability limit 5
    """,
    "4. How large are the cylinders?": """
        select count(*) as contacts, round(1000 * quantile_cont(size_long_m, 0.05), 1) as low_mm,
               round(1000 * median(size_long_m), 1) as middle_mm,
               round(1000 * quantile_cont(size_long_m, 0.95), 1) as high_mm
        from names where name = 'cylinder' and probability > 0.9
    """,
    "5. Where on the pad is it touched?": """
        select 2 * round(500 * position_x_m) as x_mm, 2 * round(500 * position_y_m) as y_mm, count(*) as contacts
        from names group by all order by contacts desc, x_mm, y_mm limit 5
    """,
    "6. How hard is it pressed?": """
        select name, round(max(force_n), 1) as most_n, round(median(force_n), 1) as usual_n
        from names group by name order by most_n desc
    """,
    "7. Which presses are there, and how long do they last?": """
        with marked as (
            select *, frame - row_number() over (partition by file, pad order by frame) as press
            from names where contact = 0
        )
        select file, min(time_s) as begins_s, round(max(time_s) - min(time_s), 2) as lasts_s, mode(name) as name
        from marked group by file, pad, press having count(*) > 2 order by file, begins_s limit 5
    """,
    "8. What is confused with what?": """
        select name, other.name as other, round(sum(other.probability), 1) as weight
        from (select name, unnest(alternatives) as other from names) group by all order by weight desc limit 5
    """,
    "9. Which recordings are odd?": """
        select file, count(*) as contacts, round(avg((name = 'unknown')::int), 2) as unknown,
               round(avg((len(cut) > 0)::int), 2) as cut
        from names group by file order by unknown desc, cut desc
    """,
}


def drawn_corpus(folder: Path, n_recordings: int = 4) -> list[str]:
    """Write recordings of a skin of 16 x 16 taxels, 2 mm apart, that is pressed by four bodies in turn."""
    rng = np.random.default_rng(0)
    files = []
    for k in range(n_recordings):
        frames = rng.normal(0, 30.0, (320, 16, 16))
        for press, begun in enumerate(range(20, 320, 75)):
            breadth = rng.uniform(7, 11)
            bodies = Cylinder(breadth, 4.0), Cone(breadth, 4.0), Sphere(breadth), Pyramid(breadth, 4.0)
            form = ideal_frame(bodies[(press + k) % 4], (16, 16), 1.0)
            form = np.roll(form, tuple(rng.integers(-2, 3, 2)), (0, 1))
            course = 5000 * np.sin(np.linspace(0.2, np.pi - 0.2, 40))
            frames[begun : begun + 40] += course[:, None, None] * form / form.max()
        pad = Pad(frames, pitch_m=(0.002, 0.002))
        files.append(str(folder / f"run-{k}.npz"))
        write(Recording({"pad": pad}, time_s=np.arange(320) / 100, unit="Pa"), files[-1])
    return files


def main() -> None:
    """Ask, and print the answers."""
    with tempfile.TemporaryDirectory() as name:
        if len(sys.argv) > 1:
            table = sys.argv[1]
        else:
            table = str(Path(name, "names.parquet"))
            found = run_corpus(drawn_corpus(Path(name)), AskTouch(), table)
            print(f"{found.n_rows} contacts in {found.n_frames} frames of {len(found.health)} recordings")
        connection = duckdb.connect()
        names = connection.read_parquet(table)
        for question, sql in QUESTIONS.items():
            print(f"\n{question}")
            print(names.query("names", sql))
        print("\n10. How does an answer change with the force, in quarters of a recording's most? (Polars)")
        print(
            pl.scan_parquet(table)
            .filter(pl.col("contact") == 0)
            .with_columns(quarter=(4 * pl.col("force_n") / pl.col("force_n").max().over("file")).ceil())
            .group_by("quarter")
            .agg(
                pl.len().alias("contacts"), pl.col("probability").mean().round(2), pl.col("size_long_m").mean().round(4)
            )
            .sort("quarter")
            .collect()
        )


if __name__ == "__main__":
    main()
