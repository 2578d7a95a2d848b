/*
 * varishold.h: the arithmetic of touch in plain C99.
 *
 * A pressure frame is cut by a falling threshold, and what its sections are like tells what is touched. These are the
 * functions that the Python package calls, and a microcontroller can.
 *
 * Rules that hold everywhere:
 *  - No heap, no globals but constant tables, nothing but libm. What a function needs beside its arguments it takes
 *    from `work`, of at least as many bytes as the function of the same name with `_work` says; `work` is aligned as a
 *    double is, and no two calls at one time may share it.
 *  - Frames are row by row, one vh_real a taxel. Masks are bytes, 0 or 1.
 *  - Units are the caller's: lengths in those of the pitch, values in those of the frame.
 */
#ifndef VARISHOLD_H
#define VARISHOLD_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32) && defined(VH_SHARED)
#define VH_API __declspec(dllexport)
#elif defined(VH_SHARED)
#define VH_API __attribute__((visibility("default")))
#else
#define VH_API
#endif

/* A number of a frame or of what is measured: on a controller without double precision, of single precision. */
#ifdef VH_SINGLE
typedef float vh_real;
typedef int32_t vh_int;
#else
typedef double vh_real;
typedef int64_t vh_int;
#endif

/* Whether this processor has AVX2, or AVX-512; a library that was compiled for it must not be called where it has not. */
VH_API int vh_cpu_has_avx2(void);
VH_API int vh_cpu_has_avx512(void);

/*
 * The standard deviation of one frame's noise, from the frame alone; 0 where it is too small to tell.
 *
 * frame   rows x cols values; what is not finite leaves itself out.
 * usable  rows x cols; 0 where there is no taxel or a broken one.
 */
VH_API vh_real vh_noise_sigma(const vh_real *frame, const uint8_t *usable, int rows, int cols, void *work);
VH_API size_t vh_noise_sigma_work(int rows, int cols);

/*
 * Fills a frame in place where `field` and not `usable`, so that each such taxel is the mean of its neighbours; returns
 * how many there are. What is not usable is not read, nor what is outside the field.
 */
VH_API int vh_fill(vh_real *frame, const uint8_t *usable, const uint8_t *field, int rows, int cols, void *work);
VH_API size_t vh_fill_work(int rows, int cols);

/*
 * Marks in `dead` the taxels that read the rest while everything around them is pressed; returns how many there are. The
 * frame is finite where usable; sigma is the standard deviation of its noise.
 */
VH_API int vh_find_dead(
    const vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real sigma, uint8_t *dead, void *work);
VH_API size_t vh_find_dead_work(int rows, int cols);

/*
 * Marks in `hot` the taxels that stick high among pressed neighbours; returns how many there are, and writes nothing that
 * counts where that is 0. The frame's rest is zero, it is finite where usable; sigma is that of its noise.
 */
VH_API int vh_find_hot(const vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real sigma, uint8_t *hot);

/*
 * Takes the rest off a frame in place: the plane that the taxels lie in which nothing presses. Returns whether there is
 * one; rest[0..2] is its value at the first taxel, its rise by column and by row.
 */
VH_API int vh_level(
    vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real sigma, vh_real rest[3], void *work);
VH_API size_t vh_level_work(int rows, int cols);

/*
 * The same of a large frame whose rest curves: takes off a surface of second degree; rest[0..2] is the plane that is nearest
 * to it.
 */
VH_API int vh_unbend(
    vh_real *frame, const uint8_t *usable, int rows, int cols, vh_real sigma, vh_real rest[3], void *work);
VH_API size_t vh_unbend_work(int rows, int cols);

/*
 * The standard plane, of a single frame's noise and peak, or where sigma was measured in time; and how high the noise of
 * so many taxels reaches.
 */
VH_API vh_real vh_default_floor(vh_real sigma, vh_real peak);
VH_API vh_real vh_timed_floor(vh_real sigma, vh_real peak);
VH_API vh_real vh_noise_reach(vh_real sigma, int n_taxels);

/* Two peaks are two contacts only if the saddle between them lies below this share of the lower peak. */
#define VH_SPLIT_RATIO 0.5

/* Why a frame cannot be measured. */
enum vh_fault {
    VH_FINE,
    VH_INFINITE,   /* a working taxel is infinite, or beyond 1e100 in double precision */
    VH_ALL_BROKEN, /* there are taxels, and none works */
    VH_UNORDERED   /* thresholds neither fall nor rise, or are not finite */
};

/*
 * Of a contact's places in the padded frame: its highest taxel; its first and last row and column; its number of taxels;
 * the borders that they reach (bits: left, right, top, bottom); the number of thresholds not below its end.
 */
enum vh_place {
    VH_PEAK_ROW,
    VH_PEAK_COL,
    VH_TOP,
    VH_BOTTOM,
    VH_LEFT,
    VH_RIGHT,
    VH_N_TAXELS,
    VH_BORDERS,
    VH_N_MEASURED,
    VH_N_PLACES
};

/* Directions in which widths are taken, from +x toward +y. */
#define VH_N_DIRECTIONS 16

/*
 * A contact's measures: each one's columns one after the other, each column (threshold, area, perimeter) or row (x and y
 * of the centroid; xx, xy, yx, yy of the covariance; 16 widths) of n_levels, in one piece of VH_N_COLUMNS * n_levels.
 */
#define VH_THRESHOLD 0
#define VH_AREA 1
#define VH_PERIMETER 2
#define VH_CENTROID 3
#define VH_COVARIANCE 5
#define VH_EXTENT 9
#define VH_N_COLUMNS 25

/* What contacts of a frame are asked for, where they go, and what is found. */
struct vh_frame {
    /* The frame: rows x cols; NaN is no taxel. Masks may be NULL: where there are taxels, and where they work. */
    const vh_real *frame;
    const uint8_t *field, *valid;
    /* Thresholds, falling or rising, the same for every contact; NULL for n_levels of each contact's own. */
    const vh_real *thresholds;
    /* Spacing of rows and of columns; the standard plane, or -1 to choose it; sigma measured in time, or -1. */
    vh_real row_pitch, col_pitch, floor, timed_sigma;
    int32_t rows, cols, n_levels, reserved;

    /* Room for vh_find_contacts: (rows + 2) x (cols + 2), the same, rows x cols; and its work space, kept until after
       vh_measure_contacts. */
    vh_real *padded;
    int32_t *label;
    uint8_t *dead;
    void *work;
    /* Room for vh_measure_contacts, n_contacts times: VH_N_PLACES; peak and end; VH_N_COLUMNS * n_levels; parts and holes
       at each level; one. */
    vh_int *places;
    vh_real *values, *measures;
    vh_int *counts;
    int32_t *order;

    /* Found: the noise and how high it reaches (NaN and 0 where a floor was given), the rest that was taken off. */
    vh_real sigma, reach, rest[3];
    int32_t n_contacts, n_ordered, n_events, has_gaps;
};

/*
 * Makes a frame fit to be measured and finds its contacts: fills broken taxels; where no floor is given, takes off what a
 * broken sensor adds; writes `padded`, `label` (the number of each taxel's contact, -1 for none), `dead`, `n_contacts`.
 */
VH_API enum vh_fault vh_find_contacts(struct vh_frame *task);

/*
 * Measures all sections of the contacts that vh_find_contacts has found. `order` is by falling area of the lowest section,
 * then by falling number of taxels, and leaves out what noise alone makes: n_ordered of n_contacts. Measures are NaN below
 * a contact's end.
 */
VH_API void vh_measure_contacts(struct vh_frame *task);
VH_API size_t vh_contacts_work(int rows, int cols, int n_levels);

/*
 * Both in one, where there is room for so many contacts at least as are found; where there is not, only the first. What
 * is written into `numbers`, which is of whole numbers, one after the other: padded; label and dead, filled up; values,
 * measures, counts and places of so many contacts as there is room for. Of the task what is asked is read but for the
 * frame and its thresholds, and `order`.
 */
VH_API enum vh_fault vh_contacts(
    struct vh_frame *task, const vh_real *frame, const vh_real *thresholds, vh_real *numbers, int room, void *work);

/* Between the two, where each contact has thresholds of its own: leaves out what noise alone makes, and keeps so many
 * contacts only, the first in their order, so that there is room for their measures. */
VH_API void vh_keep_largest(struct vh_frame *frame, int most);

/*
 * Measures the section {V > level} of a whole frame, whatever its parts: `thresholds` holds one level, `floor` is not read.
 * Room is that of one contact, n_levels 1.
 */
VH_API void vh_measure_whole(struct vh_frame *task);

/*
 * Many frames of one pad.
 *
 * task      what is asked of each frame, and room; places, values, measures and counts are room for so many contacts as
 *           `room` says, `order` for those of any one frame. Its frame is not read.
 * frames    n_frames frames, one after the other.
 * thresholds  n_frames x n_levels: of each frame its own, falling or rising; or NULL where the task says them.
 * n_found   of each frame, the number of its contacts, which stand in their order, without what noise alone makes.
 * sigma     of each frame, its noise.
 */
struct vh_batch {
    const struct vh_frame *task;
    const vh_real *frames, *thresholds;
    int64_t n_frames, room;
    int32_t *n_found;
    vh_real *sigma;
    /* Found: why no more frames were measured, and how many contacts the last one looked at has. */
    enum vh_fault fault;
    int32_t n_wanted;
};

/* Measures the contacts of frame after frame; returns how many were done: fewer than all where one cannot be measured, or
 * there is no room for its contacts. */
VH_API int64_t vh_measure_frames(struct vh_batch *batch);

/* Sections of a frame whose outlines are asked for. */
struct vh_cut {
    /* rows x cols values, rows `stride` apart; NaN or -infinity is no taxel. Taxels may be in it whose label is `index`;
       label may be NULL. */
    const vh_real *values;
    const int32_t *label;
    int rows, cols, stride, index;
    /* Whether outlines are closed along the border and around gaps of the field. */
    int closed;
    int n_levels;
    const vh_real *levels;
    vh_real row_pitch, col_pitch;
};

/*
 * Writes the outlines of sections: points (x, y) from the pad's centre, with the section on the left when x is to the
 * right and y up; stops[i] is the number of points up to the end of the i-th outline, n_lines[k] how many the k-th level
 * has. Open ones come first; a closed one ends at its first point, which is left out where all are closed. Returns how
 * many points there are: where that is more than `room`, nothing of it is to be read. `stops` holds half of `room`.
 */
VH_API int64_t vh_outlines(const struct vh_cut *cut, vh_real *points, int32_t *stops, int32_t *n_lines, int64_t room,
                           void *work);
VH_API size_t vh_outlines_work(const struct vh_cut *cut);

/*
 * A contact of a frame that was measured.
 *
 * padded, label   height x width: the frame with its rim, and the index of each taxel's contact.
 * place           the contact's row of places.
 * measures        25 x levels numbers: the contact's sections; counts 2 x levels: their parts and their holes.
 * peak, floor     where its profile begins and ends; sigma the noise of the frame.
 */
struct vh_contact {
    const vh_real *padded;
    const int32_t *label;
    const vh_int *place;
    const vh_real *measures;
    const vh_int *counts;
    int height, width, index, levels;
    vh_real row_pitch, col_pitch, peak, floor, sigma;
};

/* One layer of a network: out = bias + x weight. Weights are inputs x outputs, either floats, or whole numbers of which
 * one is worth scale[j] in column j; what is not there is NULL. */
struct vh_layer {
    int inputs, outputs;
    const float *weight;
    const int8_t *coarse;
    const float *scale;
    const float *bias;
};

/*
 * A learned decision.
 *
 * shift, scale, clip  an input x enters as (x - shift) scale, at most clip away from 0.
 * layers              hidden layers give max(x, 0), or tanh(x) where it is smooth.
 * whiten, means       the last hidden layer by whiten has n_means kinds' means; what lies farther than `farthest` from
 *                     all is the more a stranger (a kind's index). Without means nothing is added.
 * name_of             of each kind, the index of its name.
 * plane, bar, square  the kinds of these names, -1 where there are none.
 */
struct vh_parameters {
    int inputs, kinds, names, n_layers, n_means, stranger, plane, bar, square, smooth;
    vh_real clip;
    float farthest;
    const vh_real *shift, *scale;
    const struct vh_layer *layers;
    struct vh_layer whiten;
    const float *means;
    const uint8_t *name_of;
};

/* How many numbers a contact's signature has. */
#define VH_SIGNATURE 173

/* Writes the VH_SIGNATURE numbers of a contact: how its sections nest and grow, how its taxels lie, the sensor's state. */
VH_API void vh_signature(const struct vh_contact *contact, vh_real *out);

/* Writes a signature's whitened inputs; both may be the same array. */
VH_API void vh_whiten(const struct vh_parameters *parameters, const vh_real *numbers, vh_real *inputs);

/* Writes the log-odds (up to a constant) of every kind for whitened inputs. */
VH_API void vh_kind_logits(const struct vh_parameters *parameters, const vh_real *inputs, vh_real *logits, void *work);
VH_API size_t vh_kind_logits_work(const struct vh_parameters *parameters);

/*
 * Writes how much each group of inputs speaks for a kind against its rival: what the log-odds lose when the group's
 * inputs are replaced by the rival's usual ones.
 *
 * usual     the rival's mean inputs.
 * group_of  each input's group, from 0 to groups - 1.
 * logits    overwritten.
 *
 * The layers' weights are fine ones.
 */
VH_API void vh_evidence(const struct vh_parameters *parameters, const vh_real *inputs, const vh_real *usual,
                        const uint8_t *group_of, int groups, int kind, int rival, vh_real *logits, vh_real *nats,
                        void *work);
VH_API size_t vh_evidence_work(const struct vh_parameters *parameters);

/* What is known of a contact beside its measures. */
struct vh_hints {
    vh_real rest[3];        /* the plane that was taken off its frame: at the first taxel, its rise by column and by row */
    const uint8_t *allowed; /* kinds that can occur, or NULL for all */
    int early;              /* its floor is only how far the threshold has fallen so far */
};

/* The likeliest name, the likeliest kind of that name, and the probability of the name. */
struct vh_answer {
    int name, kind;
    vh_real probability;
};

/* Turns the log-odds of a contact's kinds into their probabilities, and says what is likeliest. */
VH_API void vh_decide(const struct vh_contact *contact, const struct vh_parameters *parameters,
                      const struct vh_hints *hints, vh_real *logits, struct vh_answer *answer);

/* Whether so few taxels touch that they cannot exclude what has no name, beside a name of this probability: on fewer than
 * 48 a name with more than .85 is made less sure by it, and has no less than that. */
VH_API int vh_may_be_strange(const struct vh_contact *contact, vh_real probability);

/* Whether a contact that fills the field is a plane with a hollow within, as a bump is where readings fall under
 * pressure: it is not surely called a plane. */
VH_API int vh_has_hollow(const struct vh_contact *contact);

/* Whether a contact that fills the field is a plane with a hill on it, as a bump is on a rest that nobody took off: it is
 * not surely called a plane either. */
VH_API int vh_has_hill(const struct vh_contact *contact);

/* Whether a contact fills a field that shows nothing of its form: of fewer than nine taxels, or most of them at exactly
 * the same highest value, as where a sensor ends. It is called a plane with p = .85 at most, of
 * fewer than nine taxels with .55. */
VH_API int vh_hides_form(const struct vh_contact *contact);

/* Whether a contact is one as names were learned from: of at most 48 taxels along its sides, its floor not below 5 % of
 * its peak. Another should be averaged down, or measured again above a higher floor. */
VH_API int vh_is_as_learned(const struct vh_contact *contact);

/*
 * Says what a contact is, by its name, and the probability of every kind; its whitened inputs are written too.
 *
 * Returns 0, and writes nothing, where the contact is not as those that were learned from and `early` is not said.
 * Work space as of vh_kind_logits.
 */
VH_API int vh_recognize(const struct vh_contact *contact, const struct vh_parameters *parameters,
                        const struct vh_hints *hints, vh_real *inputs, vh_real *probability, struct vh_answer *answer,
                        void *work);

/* The apex exponent k of A ~ (theta_1 - theta)^k, theta_1 free a little above the highest taxel; NaN where fewer than
 * four of the n sections are usable. */
VH_API vh_real vh_apex_exponent(const vh_real *threshold, const vh_real *area, int n, vh_real peak, vh_real floor,
                                vh_real taxel_area);

/* How a sensor's readings follow the stress: y = x, y = x^c, y = log(1 + c x) / log(1 + c), or lines between points. */
enum vh_response { VH_LINEAR, VH_POWER, VH_LOGARITHMIC, VH_TABLE };

/*
 * What is known of a sensor. A reading's share is (reading - rest) over_span, at most `saturation`; its stress what the
 * response makes of it, by the taxel's gain and `scale`.
 *
 * rest      rows x cols, or NULL where it is rest_of_all everywhere.
 * gains     rows x cols, below .02 where a taxel is broken; or NULL.
 * field     rows x cols, 0 where there is no taxel; or NULL.
 * inverse   rows x cols: what each pattern of crosstalk and blur is multiplied by, NULL where there is none; `down`
 *           (rows x rows) and `across` (cols x cols) hold the patterns of a line, one a row.
 */
struct vh_sensor {
    const vh_real *rest;
    vh_real rest_of_all, over_span, saturation, scale, constant;
    enum vh_response response;
    int n_points;
    const vh_real *points_reading, *points_stress, *gains;
    const uint8_t *field;
    const vh_real *down, *across, *inverse;
};

/* Writes the frame that readings stand for, and which taxels work: none from which NaN is read. */
VH_API void vh_undo(const struct vh_sensor *sensor, const vh_real *readings, int rows, int cols, vh_real *frame,
                    uint8_t *valid, void *work);
VH_API size_t vh_undo_work(int rows, int cols);

/* A pad and what is asked of it: so many thresholds a contact, at most so many contacts; spacing of rows and columns;
 * its sensor, or NULL where readings are stresses; the learned decision. */
struct vh_pad {
    int rows, cols, levels, contacts;
    vh_real row_pitch, col_pitch;
    const struct vh_sensor *sensor;
    const struct vh_parameters *parameters;
};

/* What touches: its name (-1 where it is larger than all that was learned from), the centre (x, y) from the pad's middle
 * and the area of its lowest section, and its highest stress. */
struct vh_touch {
    struct vh_answer answer;
    vh_real x, y, area, peak;
};

/* Says what touches a pad, the largest contact first; returns how many there are, or -1 where a reading is infinite or
 * beyond 1e18, or no taxel works. NaN is read from a broken taxel, which is filled from its neighbours. `touches` has room
 * for pad->contacts. */
VH_API int vh_feel(const struct vh_pad *pad, const vh_real *readings, struct vh_touch *touches, void *work);
VH_API size_t vh_feel_work(const struct vh_pad *pad);

/* After vh_feel, by the same work space: the probability of every kind of the largest contact; all 0 where it has no name.
 * What several pads feel of one thing is multiplied, kind by kind. */
VH_API const vh_real *vh_kind_probability(const struct vh_pad *pad, void *work);

/* A program of bitwise operations on registers of words: instructions of 13 numbers (operation code, three destinations,
 * nine sources), the registers that hold the outputs at the end. The first registers are the inputs. */
struct vh_program {
    int instructions, inputs, registers, n_outputs;
    const int32_t *code;
    const int32_t *outputs;
};

/* Runs a program over n_words words of each input, which begin `stride` words apart; writes n_words words of each output.
 * No output may be an input register. */
VH_API void vh_run_program(const struct vh_program *program, const uint64_t *words, size_t stride, size_t n_words,
                           uint64_t *planes, void *work);
VH_API size_t vh_run_program_work(const struct vh_program *program);

/* Packs n rows of r >= 8 bytes 0 or 1: bit g of word w of column c is rows[64 w + g][c]. The words are seen as bytes,
 * lowest first, `stride` bytes a column, and must be zeros. Returns whether every byte was 0 or 1. */
VH_API int vh_pack_rows(const uint8_t *rows, size_t n, size_t r, uint8_t *bytes_of_words, size_t stride);

/* Joins bit planes of (n + 63) / 64 words, at least one and at most eight, into one byte a grasp. */
VH_API void vh_unpack_planes(const uint64_t *planes, int n_planes, size_t n, uint8_t *out);

/* Both, for n grasps and at most eight outputs, by the work space of vh_run_program. */
VH_API void vh_run_and_unpack(const struct vh_program *program, const uint64_t *words, size_t stride, size_t n, uint8_t *out,
                              void *work);

/* Writes the influence of n cells on each other, below and on the diagonal of n x n: kernel[|row_i - row_j|][|col_i -
 * col_j|], of so many columns. */
VH_API void vh_toeplitz(const float *kernel, int width, const int64_t *row, const int64_t *col, int n, float *out);

/*
 * Parts of a hand about an object: capsules, in the palm's frame. Lengths in metres.
 *
 * start, end  n x 3: the ends of their axes; radius n.
 * touch       of each: 2 for a part that must be just so far off, 1 for one that may be, 0 for one that must be at
 *             least so far off.
 * sigma       standard deviation of one part's distance.
 */
struct vh_parts {
    int n;
    const double *start, *end, *radius;
    const int64_t *touch;
    double sigma;
};

/* A section of size 1 that is fitted: a polygon about its middle (a point where it is round), with a radius around it;
 * whether it may grow along the palm's axis. */
struct vh_section {
    int n_corners;
    const double *corners;
    double rounding;
    int grows;
};

/*
 * Fits middle, size, turn and growth of a section, beginning at every turn (radians).
 *
 * found     n_turns x 5: middle x and y, size, turn, growth.
 * off       n_turns x n: each part's distance less what it should be.
 * cost      n_turns.
 * variance  n_turns: of the size.
 */
VH_API void vh_fit_turns(const struct vh_parts *parts, const struct vh_section *section, const double *turns,
                         int n_turns, double *found, double *off, double *cost, double *variance, void *work);
VH_API size_t vh_fit_turns_work(const struct vh_parts *parts, const struct vh_section *section);

/* Fits a ball at any height: writes its middle x, y, z and its diameter, and returns the cost. */
VH_API double vh_fit_ball(const struct vh_parts *parts, double *found);

/* Tells which parts meet a part of another digit, so that what they touch may be that. Of parts only start, end and
 * radius are looked at. */
VH_API void vh_meeting(const struct vh_parts *parts, const double *half_height, const int64_t *digit, uint8_t *out);

/*
 * The mean absolute (power 1) or squared (power 2) difference of measures, as numpy's mean to the bit.
 *
 * ones    n_ones x n_measures.
 * others  n_others x n_measures.
 * out     n_ones x n_others.
 */
VH_API void vh_distances(const vh_real *ones, int n_ones, const vh_real *others, int n_others, int n_measures, int power,
                         vh_real *out);

#ifdef __cplusplus
}
#endif

#endif
