"""Files: the one guarded way in, the one atomic way out.

`open_file` opens what a user names, and what cannot be read is told in one line; `text_chunks` reads its lines in
bounded memory, `read_json` and `read_toml` read documents, `open_archive` and `read_npy` arrays, unpickling nothing.
`atomic_write` and `write_archive` replace a file only when the new one is complete; a `growing_file` is there from its
first bytes on; `check_output` says beforehand
whether a file may be replaced at all, `only_writer` keeps a second writer away, and `spread` works in processes that
nobody has to clean up.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from varishold._lazy import lazy_names

__all__ = [
    "KINDS",
    "LARGEST_BYTES",
    "Archive",
    "GrowingFile",
    "archive_names",
    "atomic_write",
    "check_output",
    "damage_told",
    "each_once",
    "encoding_notes",
    "folder_beside",
    "growing_file",
    "head_lines",
    "input_files",
    "let_go",
    "only_writer",
    "open_archive",
    "open_file",
    "open_packed_archive",
    "parse_json",
    "possible_text",
    "read_bytes",
    "read_json",
    "read_npy",
    "read_toml",
    "spread",
    "text_chunks",
    "write_archive",
    "write_texts",
]

if TYPE_CHECKING:
    from varishold.files.archive import (
        Archive,
        archive_names,
        damage_told,
        let_go,
        open_archive,
        open_packed_archive,
        possible_text,
        read_npy,
        write_archive,
    )
    from varishold.files.crew import spread
    from varishold.files.documents import parse_json, read_json, read_toml
    from varishold.files.growing import GrowingFile, growing_file
    from varishold.files.inputs import each_once, input_files
    from varishold.files.opening import LARGEST_BYTES, encoding_notes, head_lines, open_file, read_bytes, text_chunks
    from varishold.files.outputs import KINDS, check_output
    from varishold.files.resume import only_writer
    from varishold.files.writing import atomic_write, folder_beside, write_texts
else:
    __getattr__, __dir__ = lazy_names(__name__, __all__)
