/* The interpreter of bit programs: 64 grasps a word, 64 words a block, one function for all netlists.
 *
 * Every instruction works through a block of each of its registers, so that the cost of fetching it is spread over
 * 4096 grasps, and a block of every register stays in the nearest cache.
 */
#include <string.h>

#include "inner.h"
#include "varishold.h"
#if defined(__AVX2__)
#include <immintrin.h>
#endif

enum { BLOCK_WORDS = 64, ALIGNED = 64, COLUMNS = 13, MOST_SOURCES = 9, MOST_RESULTS = 3 };

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

/* The blocks of an instruction's registers. */
struct operands {
    const lane *s[MOST_SOURCES];
    lane *d[MOST_RESULTS];
};

enum { LANES = BLOCK_WORDS * sizeof(word) / sizeof(lane) };

/* Lane j of source k of n, of which the last `inverted` are inverted. */
#define SOURCE(k, n) ((k) >= (n) - inverted ? ~o.s[k][j] : o.s[k][j])
#define EACH_LANE INDEPENDENT for (int j = 0; j < LANES; j++)

static ALWAYS_INLINE lane majority(lane x, lane y, lane z)
{
#if defined(__AVX512F__)
    return _mm512_ternarylogic_epi64(x, y, z, 0xE8);
#else
    return (x & y) | (z & (x | y));
#endif
}

static ALWAYS_INLINE void copy(const struct operands o, int inverted)
{
    EACH_LANE o.d[0][j] = SOURCE(0, 1);
}

static ALWAYS_INLINE void and2(const struct operands o, int inverted)
{
    EACH_LANE o.d[0][j] = SOURCE(0, 2) & SOURCE(1, 2);
}

static ALWAYS_INLINE void and3(const struct operands o, int inverted)
{
    EACH_LANE o.d[0][j] = SOURCE(0, 3) & SOURCE(1, 3) & SOURCE(2, 3);
}

/* c and not (a and b); c is never inverted. */
static ALWAYS_INLINE void and_nand(const struct operands o, int inverted)
{
    EACH_LANE o.d[0][j] = o.s[2][j] & ~(SOURCE(0, 2) & SOURCE(1, 2));
}

/* not c and not (a and b) is not (c or (a and b)). */
static ALWAYS_INLINE void not_and_nand(const struct operands o, int inverted)
{
    EACH_LANE o.d[0][j] = ~(o.s[2][j] | (SOURCE(0, 2) & SOURCE(1, 2)));
}

static ALWAYS_INLINE void xor2(const struct operands o)
{
    EACH_LANE o.d[0][j] = o.s[0][j] ^ o.s[1][j];
}

static ALWAYS_INLINE void xor3(const struct operands o)
{
    EACH_LANE o.d[0][j] = o.s[0][j] ^ o.s[1][j] ^ o.s[2][j];
}

static ALWAYS_INLINE void majority3(const struct operands o, int inverted)
{
    EACH_LANE o.d[0][j] = majority(SOURCE(0, 3), SOURCE(1, 3), SOURCE(2, 3));
}

static ALWAYS_INLINE void count3(const struct operands o, int inverted)
{
    EACH_LANE {
        lane x = SOURCE(0, 3), y = SOURCE(1, 3), z = SOURCE(2, 3);
        o.d[0][j] = x ^ y ^ z;
        o.d[1][j] = majority(x, y, z);
    }
}

/* Three bits that count seven. */
static ALWAYS_INLINE void count7(const struct operands o, int inverted)
{
    EACH_LANE {
        lane a = SOURCE(0, 7), b = SOURCE(1, 7), c = SOURCE(2, 7), d = SOURCE(3, 7);
        lane e = SOURCE(4, 7), f = SOURCE(5, 7), g = SOURCE(6, 7);
        lane sum = a ^ b ^ c, other = d ^ e ^ f, carry = majority(a, b, c), second = majority(d, e, f);
        lane third = majority(sum, other, g);
        o.d[0][j] = sum ^ other ^ g;
        o.d[1][j] = carry ^ second ^ third;
        o.d[2][j] = majority(carry, second, third);
    }
}

/* More than two of 2 carry + sum + d + e: one of the three with the carry, all three without. */
static ALWAYS_INLINE void vote5(const struct operands o, int inverted)
{
    EACH_LANE {
        lane a = SOURCE(0, 5), b = SOURCE(1, 5), c = SOURCE(2, 5), d = SOURCE(3, 5), e = SOURCE(4, 5);
        lane sum = a ^ b ^ c, carry = majority(a, b, c);
        o.d[0][j] = majority(carry, sum | d | e, sum & d & e);
    }
}

/* More than three of the seven: two carries, or one with two of the sums and the seventh. */
static ALWAYS_INLINE void vote7(const struct operands o, int inverted)
{
    EACH_LANE {
        lane a = SOURCE(0, 7), b = SOURCE(1, 7), c = SOURCE(2, 7), d = SOURCE(3, 7);
        lane e = SOURCE(4, 7), f = SOURCE(5, 7), g = SOURCE(6, 7);
        o.d[0][j] = majority(majority(a, b, c), majority(d, e, f), majority(a ^ b ^ c, d ^ e ^ f, g));
    }
}

/* More than four of 2 (carries) + 2 carry + total: three of four carries, or two with the total. */
static ALWAYS_INLINE void vote9(const struct operands o, int inverted)
{
    EACH_LANE {
        lane a = SOURCE(0, 9), b = SOURCE(1, 9), c = SOURCE(2, 9), d = SOURCE(3, 9), e = SOURCE(4, 9);
        lane f = SOURCE(5, 9), g = SOURCE(6, 9), h = SOURCE(7, 9), i = SOURCE(8, 9);
        lane p = a ^ b ^ c, q = d ^ e ^ f, r = g ^ h ^ i, carry = majority(p, q, r), total = p ^ q ^ r;
        lane x = majority(a, b, c), y = majority(d, e, f), z = majority(g, h, i), low = x ^ y ^ z;
        o.d[0][j] = majority(majority(x, y, z), low | carry | total, low & carry & total);
    }
}

static void zero(struct operands o)
{
    memset(o.d[0], 0, BLOCK_WORDS * sizeof(word));
}

/* Executes one instruction; the codes stand in varishold.circuit.packed.program.OPERATIONS, in this order. */
static void execute(int code, const struct operands *o)
{
    switch (code) {
    case 0: zero(*o); break;
    case 1: copy(*o, 0); break;
    case 2: copy(*o, 1); break;
    case 3: and2(*o, 0); break;
    case 4: and2(*o, 1); break;
    case 5: and2(*o, 2); break;
    case 6: and3(*o, 0); break;
    case 7: and3(*o, 1); break;
    case 8: and3(*o, 2); break;
    case 9: and3(*o, 3); break;
    case 10: and_nand(*o, 0); break;
    case 11: and_nand(*o, 1); break;
    case 12: and_nand(*o, 2); break;
    case 13: not_and_nand(*o, 0); break;
    case 14: not_and_nand(*o, 1); break;
    case 15: not_and_nand(*o, 2); break;
    case 16: xor2(*o); break;
    case 17: xor3(*o); break;
    case 18: majority3(*o, 0); break;
    case 19: majority3(*o, 1); break;
    case 20: count3(*o, 0); break;
    case 21: count3(*o, 1); break;
    case 22: count7(*o, 0); break;
    case 23: count7(*o, 1); break;
    case 24: count7(*o, 2); break;
    case 25: count7(*o, 3); break;
    case 26: vote5(*o, 0); break;
    case 27: vote5(*o, 1); break;
    case 28: vote5(*o, 2); break;
    case 29: vote7(*o, 0); break;
    case 30: vote7(*o, 1); break;
    case 31: vote7(*o, 2); break;
    case 32: vote7(*o, 3); break;
    case 33: vote9(*o, 0); break;
    case 34: vote9(*o, 1); break;
    case 35: vote9(*o, 2); break;
    case 36: vote9(*o, 3); break;
    case 37: vote9(*o, 4); break;
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

static void run_block(const struct vh_program *program, word *const *table)
{
    for (int row = 0; row < program->instructions; row++) {
        const int32_t *fields = program->code + row * COLUMNS;
        struct operands o;
        for (int k = 0; k < MOST_RESULTS; k++)
            o.d[k] = (lane *)table[fields[1 + k]];
        for (int k = 0; k < MOST_SOURCES; k++)
            o.s[k] = (const lane *)table[fields[1 + MOST_RESULTS + k]];
        execute(fields[0], &o);
    }
}

void vh_run_program(const struct vh_program *program, const uint64_t *words, size_t stride, size_t n_words,
                    uint64_t *planes, void *work)
{
    struct space s = laid_out(program, work);

    for (int k = program->inputs; k < program->registers; k++)
        s.table[k] = s.scratch + (k - program->inputs) * BLOCK_WORDS;
    for (size_t start = 0; start < n_words; start += BLOCK_WORDS) {
        size_t length = n_words - start < BLOCK_WORDS ? n_words - start : BLOCK_WORDS;
        for (int k = 0; k < program->inputs; k++) {
            /* Inputs are only read. A last block that is not whole is read from a copy. */
            s.table[k] = (word *)words + (size_t)k * stride + start;
            if (length < BLOCK_WORDS)
                s.table[k] = memcpy(s.tail + k * BLOCK_WORDS, s.table[k], length * sizeof(word));
        }
        run_block(program, s.table);
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

/* Writes 64 bytes: byte j has bit j of the word of plane k as its bit k. */
static void spread_bits(const uint64_t *planes, int n_planes, size_t n_words, uint8_t *out)
{
#if defined(__AVX512BW__)
    __m512i total = _mm512_setzero_si512();
    for (int k = 0; k < n_planes; k++)
        total = _mm512_or_si512(total, _mm512_maskz_set1_epi8(planes[(size_t)k * n_words], (char)(1 << k)));
    _mm512_storeu_si512(out, total);
#elif defined(__AVX2__)
    /* Every byte of a half gets the byte of the word that holds its bit, and keeps that bit alone. */
    const __m256i own = _mm256_set1_epi64x((long long)0x8040201008040201u);
    const __m256i from = _mm256_setr_epi64x(0, 0x0101010101010101, 0x0202020202020202, 0x0303030303030303);
    for (int half = 0; half < 2; half++) {
        __m256i total = _mm256_setzero_si256();
        for (int k = 0; k < n_planes; k++) {
            __m256i w = _mm256_set1_epi32((int)(planes[(size_t)k * n_words] >> 32 * half));
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
            word eight = planes[(size_t)k * n_words] >> 8 * group & 0xFF;
            /* Seven bits and one apart, as a product of all eight would carry: bit j of the eight comes to byte j. */
            word low = (eight & 0x7F) * 0x0002040810204081u & 0x0001010101010101u;
            bytes |= (low | (eight >> 7) << 56) << k;
        }
        memcpy(out + 8 * group, &bytes, sizeof bytes);
    }
#endif
}

void vh_unpack_planes(const uint64_t *planes, int n_planes, size_t n, uint8_t *out)
{
    size_t n_words = (n + 63) / 64;
    uint8_t last[64];

    for (size_t word_at = 0; word_at < n_words; word_at++) {
        int whole = 64 * word_at + 64 <= n;
        spread_bits(planes + word_at, n_planes, n_words, whole ? out + 64 * word_at : last);
        if (!whole)
            memcpy(out + 64 * word_at, last, n - 64 * word_at);
    }
}

void vh_run_and_unpack(const struct vh_program *program, const uint64_t *words, size_t stride, size_t n,
                       uint64_t *planes, uint8_t *out, void *work)
{
    vh_run_program(program, words, stride, (n + 63) / 64, planes, work);
    vh_unpack_planes(planes, program->n_outputs, n, out);
}
