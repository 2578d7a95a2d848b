"""Files: the one guarded way in, the one atomic way out.

`open_file` opens what a user names, and what cannot be read is told in one line; `text_chunks` reads its lines in
bounded memory. `open_archive` and `read_npy` read arrays, unpickling nothing. `atomic_write` and `write_archive`
replace a file only when the new one is complete.
"""

from varishold.files.archive import LARGEST_BYTES, Archive, archive_names, open_archive, read_npy, write_archive
from varishold.files.opening import open_file, text_chunks
from varishold.files.writing import atomic_write

__all__ = [
    "LARGEST_BYTES",
    "Archive",
    "archive_names",
    "atomic_write",
    "open_archive",
    "open_file",
    "read_npy",
    "text_chunks",
    "write_archive",
]
