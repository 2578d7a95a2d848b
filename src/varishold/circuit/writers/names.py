"""Names from outside, made safe for source code: identifiers, string literals, comments."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

__all__ = ["c_string", "comment", "comments", "identifier", "taken_by"]

# Of C99, C++ and SystemVerilog, lower case: a module may be included from any of them, and Verilog be read as the last.
_KEYWORDS: Final = frozenset(
    """
    accept_on alias alignas alignof always always_comb always_ff always_latch and and_eq asm assert assign
    assume auto automatic before begin bind bins binsof bit bitand bitor bool break buf bufif0 bufif1 byte case
    casex casez catch cell chandle char char16_t char32_t char8_t checker class clocking cmos co_await co_return
    co_yield compl concept config const const_cast consteval constexpr constinit constraint context continue
    cover covergroup coverpoint cross deassign decltype default defparam delete design disable dist do double
    dynamic_cast edge else end endcase endchecker endclass endclocking endconfig endfunction endgenerate
    endgroup endinterface endmodule endpackage endprimitive endprogram endproperty endsequence endspecify
    endtable endtask enum event eventually expect explicit export extends extern false final first_match float
    for force foreach forever fork forkjoin friend function generate genvar global goto highz0 highz1 if iff
    ifnone ignore_bins illegal_bins implements implies import incdir include initial inline inout input inside
    instance int integer interconnect interface intersect join join_any join_none large let liblist library
    local localparam logic long longint macromodule main matches medium modport module mutable namespace nand
    negedge nettype new nexttime nmos noexcept nor noshowcancelled not not_eq notif0 notif1 null nullptr
    operator or or_eq output package packed parameter pmos posedge primitive priority private program property
    protected public pull0 pull1 pulldown pullup pulsestyle_ondetect pulsestyle_onevent pure rand randc randcase
    randsequence rcmos real realtime ref reg register reinterpret_cast reject_on release repeat requires
    restrict return rnmos rpmos rtran rtranif0 rtranif1 s_always s_eventually s_nexttime s_until s_until_with
    scalared sequence short shortint shortreal showcancelled signed sizeof small soft solve specify specparam
    static static_assert static_cast std string strong strong0 strong1 struct super supply0 supply1 switch
    sync_accept_on sync_reject_on table tagged task template this thread_local throughout throw time
    timeprecision timeunit tran tranif0 tranif1 tri tri0 tri1 triand trior trireg true try type typedef typeid
    typename union unique unique0 unsigned until until_with untyped use using uwire var vectored virtual void
    volatile wait wait_order wand wchar_t weak weak0 weak1 while wildcard wire with within wor xnor xor xor_eq
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
# How the names end that a circuit's own test, bench and second module have beside it.
_BESIDE: Final = ("_test", "_tb", "_registered")
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
    >>> taken_by("Int"), taken_by("math", header=True), taken_by("math"), taken_by("cup_test")
    ('a word of C, C++ or Verilog', 'a header of C', '', 'the test of another circuit')
    """
    text = _plain(name)
    if text in _KEYWORDS:
        return "a word of C, C++ or Verilog"
    if text.endswith(_BESIDE):
        return "the test of another circuit"
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
