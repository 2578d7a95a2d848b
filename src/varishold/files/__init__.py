"""Files: the one guarded way in, the one atomic way out.

`open_file` opens what a user names, and what cannot be read is told in one line; `text_chunks` reads its lines in
bounded memory, `read_json` and `read_toml` read documents, `open_archive` and `read_npy` arrays, unpickling nothing.
`atomic_write` and `write_archive` replace a file only when the new one is complete.
"""

from varishold.files.archive import Archive, archive_names, open_archive, read_npy, write_archive
from varishold.files.documents import parse_json, read_json, read_toml
from varishold.files.opening import LARGEST_BYTES, open_file, read_bytes, text_chunks
from varishold.files.writing import atomic_write

__all__ = [
    "LARGEST_BYTES",
    "Archive",
    "archive_names",
    "atomic_write",
    "open_archive",
    "open_file",
    "parse_json",
    "read_bytes",
    "read_json",
    "read_npy",
    "read_toml",
    "text_chunks",
    "write_archive",
]
