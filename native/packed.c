/* The interpreter of bit programs: 64 grasps a word, up to 256 words a block, one function for all netlists.
 *
 * Every instruction works through a block of each of its registers, so that the cost of fetching it is spread over
 * up to 16384 grasps, and a block of every register stays near: that of the inputs, which are the most, need not be in
 * the nearest cache, as it is read in order.
 */
#include <string.h>

#include "inner.h"
#include "varishold.h"
#if defined(__AVX2__)
#include <immintrin.h>
#endif

enum { BLOCK_WORDS = 256, ALIGNED = 64, COLUMNS = 13, MOST_SOURCES = 9, MOST_RESULTS = 3, MOST_PLANES = 8 };

typedef uint64_t word;

/* What one operation works on: as wide as the processor's registers where it is said how wide they are, otherwise a
 * word, and the compiler widens it. A register of the program may be source and destination at once, but no word of a
 * block depends on another. */
#if defined(__AVX512F__)
typedef __m512i_u lane;
#define INDEPENDENT
#else
typedef uint64_t lane;
#if defined(__clang__)
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define INDEPENDENT _Pragma("GCC ivdep")
#else
#define INDEPENDENT
#endif
#endif
#if defined(__GNUC__)
#define ALWAYS_INLINE inline __attribute__((always_inline))
#else
#define ALWAYS_INLINE inline
#endif

/* The blocks of an instruction's registers, and how many of their lanes are worked on. */
struct operands {
    const lane *s[MOST_SOURCES];
    lane *d[MOST_RESULTS];
    int lanes;
};

/* Lane j of source k, loaded once: gcc would rather load it again than copy it. */
static ALWAYS_INLINE lane loaded(const lane *source, int j)
{
    lane x = source[j];
#if defined(__AVX512F__) && defined(__GNUC__) && !defined(__clang__)
    __asm__("" : "+v"(x));
#endif
    return x;
}

#define SOURCE(k) loaded(o.s[k], j)
#define EACH_LANE INDEPENDENT for (int j = 0; j < o.lanes; j++)

/* Three lanes of which the last n are inverted, joined bit by bit by a table: where registers are 512 bits wide that is
 * one operation, whatever n is, and n is constant where these are called. */
#if defined(__AVX512F__)
#define JOINED(x, y, z, n, none, last, two, all)                                                                       \
    switch (n) {                                                                                                       \
    case 0: return _mm512_ternarylogic_epi64(x, y, z, none);                                                           \
    case 1: return _mm512_ternarylogic_epi64(x, y, z, last);                                                           \
    case 2: return _mm512_ternarylogic_epi64(x, y, z, two);                                                            \
    default: return _mm512_ternarylogic_epi64(x, y, z, all);                                                           \
    }
#endif

/* What most of the three are. */
static ALWAYS_INLINE lane majority(lane x, lane y, lane z, int n)
{
#if defined(__AVX512F__)
    JOINED(x, y, z, n, 0xE8, 0xD4, 0x71, 0x17)
#else
    x = n > 2 ? ~x : x, y = n > 1 ? ~y : y, z = n > 0 ? ~z : z;
    return (x & y) | (z & (x | y));
#endif
}

/* The lowest bit of their sum. */
static ALWAYS_INLINE lane odd(lane x, lane y, lane z, int n)
{
#if defined(__AVX512F__)
    JOINED(x, y, z, n, 0x96, 0x69, 0x96, 0x69)
#else
    return n & 1 ? ~(x ^ y ^ z) : x ^ y ^ z;
#endif
}

static ALWAYS_INLINE lane all_three(lane x, lane y, lane z, int n)
{
#if defined(__AVX512F__)
    JOINED(x, y, z, n, 0x80, 0x40, 0x10, 0x01)
#else
    return (n > 2 ? ~x : x) & (n > 1 ? ~y : y) & (n > 0 ? ~z : z);
#endif
}

static ALWAYS_INLINE lane any_three(lane x, lane y, lane z, int n)
{
#if defined(__AVX512F__)
    JOINED(x, y, z, n, 0xFE, 0xFD, 0xF7, 0x7F)
#else
    return (n > 2 ? ~x : x) | (n > 1 ? ~y : y) | (n > 0 ? ~z : z);
#endif
}

/* How many of three operands are inverted, of which `after` more come after them. */
static ALWAYS_INLINE int of_three(int inverted, int after)
{
    return inverted > after + 3 ? 3 : inverted > after ? inverted - after : 0;
}

static ALWAYS_INLINE void copy(const struct operands o, int inverted)
{
    EACH_LANE o.d[0][j] = inverted ? ~SOURCE(0) : SOURCE(0);
}

static ALWAYS_INLINE void and2(const struct operands o, int inverted)
{
    EACH_LANE {
        lane x = SOURCE(0), y = SOURCE(1);
        o.d[0][j] = (inverted > 1 ? ~x : x) & (inverted > 0 ? ~y : y);
    }
}

static ALWAYS_INLINE void and3(const struct operands o, int inverted)
{
    EACH_LANE o.d[0][j] = all_three(SOURCE(0), SOURCE(1), SOURCE(2), inverted);
}

static ALWAYS_INLINE void and5(const struct operands o, int inverted)
{
    EACH_LANE {
        const lane some = all_three(SOURCE(0), SOURCE(1), SOURCE(2), of_three(inverted, 2));
        o.d[0][j] = all_three(some, SOURCE(3), SOURCE(4), inverted > 2 ? 2 : inverted);
    }
}

static ALWAYS_INLINE void or5(const struct operands o, int inverted)
{
    EACH_LANE {
        const lane some = any_three(SOURCE(0), SOURCE(1), SOURCE(2), of_three(inverted, 2));
        o.d[0][j] = any_three(some, SOURCE(3), SOURCE(4), inverted > 2 ? 2 : inverted);
    }
}

/* c and not (a and b); c is never inverted. */
static ALWAYS_INLINE void and_nand(const struct operands o, int inverted)
{
    EACH_LANE {
        lane a = SOURCE(0), b = SOURCE(1), c = SOURCE(2);
        o.d[0][j] = c & ~((inverted > 1 ? ~a : a) & (inverted > 0 ? ~b : b));
    }
}

/* not c and not (a and b) is not (c or (a and b)). */
static ALWAYS_INLINE void not_and_nand(const struct operands o, int inverted)
{
    EACH_LANE {
        lane a = SOURCE(0), b = SOURCE(1), c = SOURCE(2);
        o.d[0][j] = ~(c | ((inverted > 1 ? ~a : a) & (inverted > 0 ? ~b : b)));
    }
}

static ALWAYS_INLINE void xor2(const struct operands o)
{
    EACH_LANE o.d[0][j] = SOURCE(0) ^ SOURCE(1);
}

static ALWAYS_INLINE void xor3(const struct operands o)
{
    EACH_LANE o.d[0][j] = odd(SOURCE(0), SOURCE(1), SOURCE(2), 0);
}

static ALWAYS_INLINE void majority3(const struct operands o, int inverted)
{
    EACH_LANE o.d[0][j] = majority(SOURCE(0), SOURCE(1), SOURCE(2), inverted);
}

static ALWAYS_INLINE void count3(const struct operands o, int inverted)
{
    EACH_LANE {
        lane x = SOURCE(0), y = SOURCE(1), z = SOURCE(2);
        o.d[0][j] = odd(x, y, z, inverted);
        o.d[1][j] = majority(x, y, z, inverted);
    }
}

/* Three bits that count seven. */
static ALWAYS_INLINE void count7(const struct operands o, int inverted)
{
    const int middle = of_three(inverted, 1), final = of_three(inverted, 0) > 0;
    EACH_LANE {
        lane a = SOURCE(0), b = SOURCE(1), c = SOURCE(2), d = SOURCE(3), e = SOURCE(4), f = SOURCE(5), g = SOURCE(6);
        lane sum = odd(a, b, c, 0), other = odd(d, e, f, middle);
        lane carry = majority(a, b, c, 0), second = majority(d, e, f, middle), third = majority(sum, other, g, final);
        o.d[0][j] = odd(sum, other, g, final);
        o.d[1][j] = odd(carry, second, third, 0);
        o.d[2][j] = majority(carry, second, third, 0);
    }
}

/* More than two of 2 carry + sum + d + e: one of the three with the carry, all three without. */
static ALWAYS_INLINE void vote5(const struct operands o, int inverted)
{
    EACH_LANE {
        lane a = SOURCE(0), b = SOURCE(1), c = SOURCE(2), d = SOURCE(3), e = SOURCE(4);
        lane sum = odd(a, b, c, 0), carry = majority(a, b, c, 0);
        lane any = sum | (inverted > 1 ? ~d : d) | (inverted > 0 ? ~e : e);
        o.d[0][j] = majority(carry, any, all_three(sum, d, e, inverted), 0);
    }
}

/* More than three of the seven: two carries, or one with two of the sums and the seventh. */
static ALWAYS_INLINE void vote7(const struct operands o, int inverted)
{
    const int middle = of_three(inverted, 1), final = of_three(inverted, 0) > 0;
    EACH_LANE {
        lane a = SOURCE(0), b = SOURCE(1), c = SOURCE(2), d = SOURCE(3), e = SOURCE(4), f = SOURCE(5), g = SOURCE(6);
        lane rest = majority(odd(a, b, c, 0), odd(d, e, f, middle), g, final);
        o.d[0][j] = majority(majority(a, b, c, 0), majority(d, e, f, middle), rest, 0);
    }
}

/* More than four of 2 (carries) + 2 carry + total: three of four carries, or two with the total. */
static ALWAYS_INLINE void vote9(const struct operands o, int inverted)
{
    const int middle = of_three(inverted, 3), last = of_three(inverted, 0);
    EACH_LANE {
        lane a = SOURCE(0), b = SOURCE(1), c = SOURCE(2), d = SOURCE(3), e = SOURCE(4);
        lane f = SOURCE(5), g = SOURCE(6), h = SOURCE(7), i = SOURCE(8);
        lane p = odd(a, b, c, 0), q = odd(d, e, f, middle), r = odd(g, h, i, last);
        lane x = majority(a, b, c, 0), y = majority(d, e, f, middle), z = majority(g, h, i, last);
        lane carry = majority(p, q, r, 0), total = odd(p, q, r, 0), low = odd(x, y, z, 0);
        o.d[0][j] = majority(majority(x, y, z, 0), low | carry | total, low & carry & total, 0);
    }
}

static void zero(const struct operands o)
{
    memset(o.d[0], 0, (size_t)o.lanes * sizeof(lane));
}

/* The blocks of so many sources and results of an instruction: no more is looked up than it works on. */
static ALWAYS_INLINE struct operands taken(const int32_t *fields, word *const *table, int lanes, int n_sources, int n_results)
{
    struct operands o;
    o.lanes = lanes;
    for (int k = 0; k < n_results; k++)
        o.d[k] = (lane *)table[fields[1 + k]];
    for (int k = 0; k < n_sources; k++)
        o.s[k] = (const lane *)table[fields[1 + MOST_RESULTS + k]];
    return o;
}

#define TAKEN(n_sources, n_results) taken(fields, table, lanes, n_sources, n_results)

/* Executes one instruction; the codes stand in varishold.circuit.packed.program.OPERATIONS, in this order. */
static void execute(const int32_t *fields, word *const *table, int lanes)
{
    switch (fields[0]) {
    case 0: zero(TAKEN(0, 1)); break;
    case 1: copy(TAKEN(1, 1), 0); break;
    case 2: copy(TAKEN(1, 1), 1); break;
    case 3: and2(TAKEN(2, 1), 0); break;
    case 4: and2(TAKEN(2, 1), 1); break;
    case 5: and2(TAKEN(2, 1), 2); break;
    case 6: and3(TAKEN(3, 1), 0); break;
    case 7: and3(TAKEN(3, 1), 1); break;
    case 8: and3(TAKEN(3, 1), 2); break;
    case 9: and3(TAKEN(3, 1), 3); break;
    case 10: and_nand(TAKEN(3, 1), 0); break;
    case 11: and_nand(TAKEN(3, 1), 1); break;
    case 12: and_nand(TAKEN(3, 1), 2); break;
    case 13: not_and_nand(TAKEN(3, 1), 0); break;
    case 14: not_and_nand(TAKEN(3, 1), 1); break;
    case 15: not_and_nand(TAKEN(3, 1), 2); break;
    case 16: xor2(TAKEN(2, 1)); break;
    case 17: xor3(TAKEN(3, 1)); break;
    case 18: majority3(TAKEN(3, 1), 0); break;
    case 19: majority3(TAKEN(3, 1), 1); break;
    case 20: count3(TAKEN(3, 2), 0); break;
    case 21: count3(TAKEN(3, 2), 1); break;
    case 22: count7(TAKEN(7, 3), 0); break;
    case 23: count7(TAKEN(7, 3), 1); break;
    case 24: count7(TAKEN(7, 3), 2); break;
    case 25: count7(TAKEN(7, 3), 3); break;
    case 26: vote5(TAKEN(5, 1), 0); break;
    case 27: vote5(TAKEN(5, 1), 1); break;
    case 28: vote5(TAKEN(5, 1), 2); break;
    case 29: vote7(TAKEN(7, 1), 0); break;
    case 30: vote7(TAKEN(7, 1), 1); break;
    case 31: vote7(TAKEN(7, 1), 2); break;
    case 32: vote7(TAKEN(7, 1), 3); break;
    case 33: vote9(TAKEN(9, 1), 0); break;
    case 34: vote9(TAKEN(9, 1), 1); break;
    case 35: vote9(TAKEN(9, 1), 2); break;
    case 36: vote9(TAKEN(9, 1), 3); break;
    case 37: vote9(TAKEN(9, 1), 4); break;
    case 38: and5(TAKEN(5, 1), 0); break;
    case 39: and5(TAKEN(5, 1), 1); break;
    case 40: and5(TAKEN(5, 1), 2); break;
    case 41: and5(TAKEN(5, 1), 3); break;
    case 42: and5(TAKEN(5, 1), 4); break;
    case 43: and5(TAKEN(5, 1), 5); break;
    case 44: or5(TAKEN(5, 1), 0); break;
    case 45: or5(TAKEN(5, 1), 1); break;
    case 46: or5(TAKEN(5, 1), 2); break;
    case 47: or5(TAKEN(5, 1), 3); break;
    case 48: or5(TAKEN(5, 1), 4); break;
    case 49: or5(TAKEN(5, 1), 5); break;
    default: break;
    }
}

/* Where the pieces of the work space begin; sizes alone where there is none. */
struct space {
    word *scratch, *tail;
    word **table;
    size_t bytes;
};

static struct space laid_out(const struct vh_program *program, void *work)
{
    struct space s;
    size_t used = work ? (size_t)(-(uintptr_t)work & (ALIGNED - 1)) : ALIGNED;

    s.scratch = vh_take(work, &used, (size_t)(program->registers - program->inputs) * BLOCK_WORDS, sizeof(word));
    s.tail = vh_take(work, &used, (size_t)program->inputs * BLOCK_WORDS, sizeof(word));
    s.table = vh_take(work, &used, (size_t)program->registers, sizeof(word *));
    s.bytes = used;
    return s;
}

size_t vh_run_program_work(const struct vh_program *program)
{
    return laid_out(program, NULL).bytes;
}

/* The least number of lanes that hold so many words. */
static int lanes_of(size_t words)
{
    const size_t each = sizeof(lane) / sizeof(word);
    return (int)((words + each - 1) / each);
}

static struct space made_ready(const struct vh_program *program, void *work)
{
    struct space s = laid_out(program, work);

    for (int k = program->inputs; k < program->registers; k++)
        s.table[k] = s.scratch + (size_t)(k - program->inputs) * BLOCK_WORDS;
    return s;
}

/* Runs a program over `length` words of a block; its outputs stand in their registers then. */
static void run_block(const struct vh_program *program, const uint64_t *words, size_t stride, size_t length,
                      struct space s)
{
    for (int k = 0; k < program->inputs; k++) {
        /* Inputs are only read. A last block that ends within a lane is read from a copy. */
        s.table[k] = (word *)words + (size_t)k * stride;
        if (length % (sizeof(lane) / sizeof(word)))
            s.table[k] = memcpy(s.tail + (size_t)k * BLOCK_WORDS, s.table[k], length * sizeof(word));
    }
    for (int row = 0; row < program->instructions; row++)
        execute(program->code + row * COLUMNS, s.table, lanes_of(length));
}

/* How many words a block has where there are so many: all have as many, in whole lines of the cache, but for the last. */
static size_t block_words(size_t n_words)
{
    const size_t line = ALIGNED / sizeof(word), n_blocks = (n_words + BLOCK_WORDS - 1) / BLOCK_WORDS;
    return n_blocks ? ((n_words + n_blocks - 1) / n_blocks + line - 1) / line * line : line;
}

void vh_run_program(const struct vh_program *program, const uint64_t *words, size_t stride, size_t n_words,
                    uint64_t *planes, void *work)
{
    const size_t block = block_words(n_words);
    struct space s = made_ready(program, work);

    for (size_t start = 0; start < n_words; start += block) {
        size_t length = n_words - start < block ? n_words - start : block;
        run_block(program, words + start, stride, length, s);
        for (int k = 0; k < program->n_outputs; k++)
            memcpy(planes + (size_t)k * n_words + start, s.table[program->outputs[k]], length * sizeof(word));
    }
}

/* Eight bytes, which need not be aligned, as one number whose lowest byte is the first. */
static ALWAYS_INLINE word eight_bytes(const uint8_t *p)
{
    word w;
    memcpy(&w, p, sizeof w);
    return w;
}

int vh_pack_rows(const uint8_t *rows, size_t n, size_t r, uint8_t *bytes_of_words, size_t stride)
{
    word seen = 0;

    for (size_t group = 0; group < (n + 7) / 8; group++) {
        size_t height = n - 8 * group < 8 ? n - 8 * group : 8;
        for (size_t chunk = 0; chunk < (r + 7) / 8; chunk++) {
            /* The last chunk overlaps the one before it and so never reads beyond the row. */
            size_t first = 8 * chunk < r - 8 ? 8 * chunk : r - 8;
            const uint8_t *place = rows + 8 * group * r + first;
            word gathered = 0;
            for (size_t i = 0; i < height; i++) {
                word row = eight_bytes(place + i * r);
                seen |= row;
                gathered |= row << i;
            }
            /* Byte c of `gathered` now holds eight grasps of column first + c. */
            for (size_t c = 0; c < 8; c++)
                bytes_of_words[(first + c) * stride + group] = (uint8_t)(gathered >> 8 * c);
        }
    }
    return (seen & 0xFEFEFEFEFEFEFEFEu) == 0;
}

/* Writes 64 bytes: byte j has bit j of word `at` of plane k as its bit k. */
static ALWAYS_INLINE void spread_bits(const word *const *planes, int n_planes, size_t at, uint8_t *out)
{
#if defined(__AVX512BW__)
    __m512i total = _mm512_maskz_set1_epi8(planes[0][at], 1);
    for (int k = 1; k < n_planes; k++)
        total = _mm512_or_si512(total, _mm512_maskz_set1_epi8(planes[k][at], (char)(1 << k)));
    _mm512_storeu_si512(out, total);
#elif defined(__AVX2__)
    /* Every byte of a half gets the byte of the word that holds its bit, and keeps that bit alone. */
    const __m256i own = _mm256_set1_epi64x((long long)0x8040201008040201u);
    const __m256i from = _mm256_setr_epi64x(0, 0x0101010101010101, 0x0202020202020202, 0x0303030303030303);
    for (int half = 0; half < 2; half++) {
        __m256i total = _mm256_setzero_si256();
        for (int k = 0; k < n_planes; k++) {
            __m256i w = _mm256_set1_epi32((int)(planes[k][at] >> 32 * half));
            __m256i bits = _mm256_and_si256(_mm256_shuffle_epi8(w, from), own);
            __m256i set = _mm256_cmpeq_epi8(bits, own);
            total = _mm256_or_si256(total, _mm256_and_si256(set, _mm256_set1_epi8((char)(1 << k))));
        }
        _mm256_storeu_si256((__m256i *)(out + 32 * half), total);
    }
#else
    for (int group = 0; group < 8; group++) {
        word bytes = 0;
        for (int k = 0; k < n_planes; k++) {
            word eight = planes[k][at] >> 8 * group & 0xFF;
            /* Seven bits and one apart, as a product of all eight would carry: bit j of the eight comes to byte j. */
            word low = (eight & 0x7F) * 0x0002040810204081u & 0x0001010101010101u;
            bytes |= (low | (eight >> 7) << 56) << k;
        }
        memcpy(out + 8 * group, &bytes, sizeof bytes);
    }
#endif
}

/* Joins words of at most MOST_PLANES planes into a byte a grasp, of n grasps. */
static void unpack(const word *const *planes, int n_planes, size_t n, uint8_t *out)
{
    uint8_t last[64];

    for (size_t at = 0; at < n / 64; at++)
        spread_bits(planes, n_planes, at, out + 64 * at);
    if (n % 64) {
        spread_bits(planes, n_planes, n / 64, last);
        memcpy(out + n / 64 * 64, last, n % 64);
    }
}

void vh_unpack_planes(const uint64_t *planes, int n_planes, size_t n, uint8_t *out)
{
    const word *each[MOST_PLANES];

    for (int k = 0; k < n_planes; k++)
        each[k] = planes + (size_t)k * ((n + 63) / 64);
    unpack(each, n_planes, n, out);
}

void vh_run_and_unpack(const struct vh_program *program, const uint64_t *words, size_t stride, size_t n, uint8_t *out,
                       void *work)
{
    const size_t block = block_words((n + 63) / 64);
    struct space s = made_ready(program, work);
    const word *planes[MOST_PLANES];

    for (size_t start = 0; 64 * start < n; start += block) {
        size_t grasps = n - 64 * start < 64 * block ? n - 64 * start : 64 * block;
        run_block(program, words + start, stride, (grasps + 63) / 64, s);
        for (int k = 0; k < program->n_outputs; k++)
            planes[k] = s.table[program->outputs[k]];
        unpack(planes, program->n_outputs, grasps, out + 64 * start);
    }
}
