"""Names from outside, made safe for source code: identifiers, string literals, comments."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

__all__ = ["c_string", "comment", "comments", "identifier", "taken_by"]

# Of C99, C++ and Verilog-2005, lower case; a module may be included from any of them.
_KEYWORDS: Final = frozenset(
    """
    alignas alignof always and and_eq asm assign auto automatic begin bitand bitor bool break buf bufif0
    bufif1 case casex casez catch cell char class cmos compl concept config const constexpr continue
    deassign decltype default defparam delete design disable do double edge else end endcase endconfig
    endfunction endgenerate endmodule endprimitive endspecify endtable endtask enum event explicit export
    extern false float for force forever fork friend function generate genvar goto highz0 highz1 if ifnone
    incdir include initial inline inout input instance int integer join large liblist library localparam
    long macromodule main medium module mutable namespace nand negedge new nmos noexcept nor
    noshowcancelled not not_eq notif0 notif1 nullptr operator or or_eq output parameter pmos posedge
    primitive private protected public pull0 pull1 pulldown pullup pulsestyle_onevent
    pulsestyle_ondetect rcmos real realtime reg register release repeat requires restrict return rnmos
    rpmos rtran rtranif0 rtranif1 scalared short showcancelled signed sizeof small specify specparam
    static static_assert strong0 strong1 struct supply0 supply1 switch table task template this
    thread_local throw time tran tranif0 tranif1 tri tri0 tri1 triand trior trireg true try typedef
    typeid typename union unsigned use uwire using vectored virtual void volatile wait wand wchar_t weak0
    weak1 while wire wor xnor xor xor_eq
    """.split()  # noqa: SIM905
)
# Headers of C99 and C11, and those of a system that they include, or that are found as these are: a file of such a name
# would be included in their place.
_HEADERS: Final = frozenset(
    """
    aio alloca assert byteswap complex cpio ctype dirent dlfcn elf endian err errno error execinfo fcntl features fenv
    float fmtmsg fnmatch ftw getopt glob grp iconv ifaddrs inttypes iso646 langinfo libgen libintl limits link locale
    malloc math memory monetary mqueue ndbm netdb newlib nl_types paths poll pthread pwd reent regex resolv sched search
    semaphore setjmp signal spawn stab stdalign stdarg stdatomic stdbit stdbool stdc_predef stdckdint stddef stdint
    stdio stdlib stdnoreturn string strings stropts syscall syslog tar termios tgmath threads time trace uchar ucontext
    ulimit unistd utime utmpx wait wchar wctype wordexp
    """.split()  # noqa: SIM905
)
_LONGEST: Final = 48
_PLAIN: Final = frozenset("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789 _-.,:+=<>()[]")


def identifier(name: str, *, header: bool = False) -> str:
    """Return a name as an identifier of C and Verilog: letters, digits and underscores, no keyword.

    Parameters
    ----------
    name : str
    header : bool
        Whether a header of C is called so too, which must be none of a system's.

    Examples
    --------
    >>> identifier("2nd hand; rm"), identifier("module"), identifier("手")
    ('m_2nd_hand_rm', 'm_module', 'm')
    >>> identifier("stdint"), identifier("stdint", header=True)
    ('stdint', 'm_stdint')
    """
    text = _plain(name)
    if not text or not text[0].isalpha() or taken_by(name, header=header):
        text = f"m_{text}".rstrip("_")
    return text


def taken_by(name: str, *, header: bool = False) -> str:
    """Return in words what else a name stands for, so that its `identifier` is another; empty where for nothing.

    Examples
    --------
    >>> taken_by("Int"), taken_by("math", header=True), taken_by("math"), taken_by("cup")
    ('a word of C, C++ or Verilog', 'a header of C', '', '')
    """
    text = _plain(name)
    if text in _KEYWORDS:
        return "a word of C, C++ or Verilog"
    return "a header of C" if header and text in _HEADERS else ""


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")[:_LONGEST].strip("_")


def c_string(text: str) -> str:
    r"""Return a text as a string literal of C, in UTF-8; what is not plain is written in octal.

    Examples
    --------
    >>> print(c_string('a"b\n'))
    "a\042b\012"
    """
    out = []
    for byte in text.encode():
        character = chr(byte)
        # Three octal digits end an escape whatever follows, and a question mark cannot begin a trigraph.
        out.append(character if character in _PLAIN else f"\\{byte:03o}")
    return f'"{"".join(out)}"'


def comment(text: str) -> str:
    """Return a text that can end no comment and no line.

    Examples
    --------
    >>> comment("tip */ int x;")
    'tip __ int x_'
    """
    return "".join(character if character in _PLAIN else "_" for character in text)


def comments(names: Sequence[str]) -> list[str]:
    """Return different names as texts that can end no comment and no line, and differ as well.

    Where some would be alike, what is not plain is told by its code in all of them.

    Examples
    --------
    >>> comments(["a/b", "c"]), comments(["a/b", "a_b"])
    (['a_b', 'c'], ['a<U+2F>b', 'a_b'])
    """
    told = [comment(name) for name in names]
    if len(set(told)) == len(told):
        return told
    return ["".join(c if c in _PLAIN and c != "<" else f"<U+{ord(c):X}>" for c in name) for name in names]
