// What kernels that run for LANES paths at once find around them: their buffers, the work, and the functions that are not
// translated.
//
// The build script writes, before this file, the translated kernels, `fill`, which finds their buffers, and where members of
// structures stand; LEVEL ends the names of this level's functions.
#pragma once
#include "rays.h"

namespace lanes {

/// Columns of what is found ahead for the paths in the queue: hits, word by word, of the rays onward and of shadow rays, each
/// before a word whose bits are all set where there is one.
enum Ahead : uint32_t { ONWARD = 0, SHADOW = 6, AHEAD = 12 };

struct Context {
    Buffers buffers;
    const char* work;
    char* film;
    const uint64_t* globals;
    /// Words of the paths in the queue, from the first lane's on.
    Columns paths;
    /// Columns of `Ahead` beside these; none where nothing is found ahead.
    Columns ahead;

    /// Counts of the host, or null.
    raggio::Counts* counts() const { return (raggio::Counts*)globals[COUNTS_WORD]; }

    explicit Context(const uint64_t* globals)
        : work((const char*)globals[WORK_WORD]), film((char*)globals[FILM_WORD]), globals(globals), paths{nullptr, 0}, ahead{nullptr, 0}
    {
        fill(buffers, globals);
    }

    /// Walks with the rays of active lanes.
    RAGGIO_NOINLINE void walk(
        Mask mask, Float originX, Float originY, Float originZ, Float directionX, Float directionY, Float directionZ,
        Uint key, Mask any, Float before, Uint shapeBefore, Uint triangleBefore, Float secondBefore, Float thirdBefore,
        Float& distance, Uint& shape, Uint& triangle, Float& second, Float& third) const
    {
        alignas(64) float in[12][LANES], out[5][LANES];
        const Float rows[12] = {
            originX, originY, originZ, directionX, directionY, directionZ, as_float(key), before, as_float(shapeBefore),
            as_float(triangleBefore), secondBefore, thirdBefore,
        };
        memcpy(in, rows, sizeof in);
        Float known[5];
        const Mask isKnown = ahead.base ? foundAhead(mask, rows, any, known) : splat(false);
        mask = without(mask, isKnown);
        raggio::TracedRay rays[LANES];
        raggio::TracedHit hits[LANES];
        uint32_t anyBits = bits(any), count = 0;
        each_lane(mask, [&](int i) {
            float words[12];
            for (int k = 0; k < 12; k++) words[k] = in[k][i];
            memcpy(&rays[count], words, 28);
            rays[count].any = anyBits >> i & 1;
            memcpy(&hits[count++], words + 7, sizeof hits[0]);
        });
        if (counts()) counts()->walk.add(count);
        RAGGIO_OF_LEVEL(raggio_walk_)(globals, rays, hits, count);
        count = 0;
        each_lane(mask, [&](int i) {
            float words[5];
            memcpy(words, &hits[count++], sizeof words);
            for (int k = 0; k < 5; k++) out[k][i] = words[k];
        });
        auto row = [&](int k) {
            Float x;
            memcpy(&x, out[k], sizeof x);
            return ahead.base ? choose(isKnown, known[k], x) : x;
        };
        distance = row(0), shape = as_uint(row(1)), triangle = as_uint(row(2)), second = row(3), third = row(4);
    }

    /// Looks for the rays in `rows` among those that were followed ahead. Returns the lanes in which they are, whose hits
    /// become `known`.
    RAGGIO_INLINE Mask foundAhead(Mask mask, const Float (&rows)[12], Mask any, Float (&known)[5]) const
    {
        auto column = [](const Columns& columns, uint32_t k) {
            Float x;
            memcpy(&x, columns.base + k * columns.capacity, sizeof x);
            return x;
        };
        auto isRay = [&](uint32_t ray, uint32_t key, uint32_t found) {
            Mask same = mask & as_mask(column(ahead, found + 5)) & equal(as_uint(rows[6]), as_uint(column(paths, key)));
            for (int k = 0; k < 6; k++) same = same & equal(rows[k], column(paths, ray + k));
            return same;
        };
        const Float before = rows[7];
        const Uint shapeBefore = as_uint(rows[8]), nothing = splat(raggio::NOTHING);

        // Rays onward were followed as if nothing were before. Of surfaces at one distance the lowest is the nearest:
        // `isBehind` of rays.h.
        Mask onward = isRay(path_columns::ray, path_columns::key, ONWARD) & inverse(any);
        Float distance = column(ahead, ONWARD);
        Uint shape = as_uint(column(ahead, ONWARD + 1)), triangle = as_uint(column(ahead, ONWARD + 2));
        Mask lower = less(shape, shapeBefore) | (equal(shape, shapeBefore) & less(triangle, as_uint(rows[9])));
        Mask nearer = less(distance, before) | (equal(distance, before) & not_equal(shapeBefore, nothing) & lower);
        for (int k = 0; k < 5; k++) known[k] = choose(nearer, column(ahead, ONWARD + k), rows[7 + k]);

        // Shadow rays outside all bodies were asked for any surface, and one that is in the way may not be the nearest.
        Mask shadow = isRay(path_columns::shadowRay, path_columns::shadowKey, SHADOW) & equal(shapeBefore, nothing)
            & equal(before, column(paths, path_columns::shadowDistance));
        Mask isNearest = not_equal(as_uint(column(paths, path_columns::mediaCount)), splat(0u))
            | equal(as_uint(column(ahead, SHADOW + 1)), nothing);
        shadow = shadow & (any | isNearest);
        for (int k = 0; k < 5; k++) known[k] = choose(shadow, column(ahead, SHADOW + k), known[k]);
        return onward | shadow;
    }

    /// Adds what samples are to their pixels, of which some may be the same: sums of 96 bits, then counts.
    template <class... Terms> RAGGIO_NOINLINE void addTerms(Mask mask, Uint place, const Terms&... terms) const
    {
        constexpr uint32_t WORDS = film_words::size, SUMS = film_words::samples / 3;
        static_assert(sizeof...(terms) == WORDS && film_words::samples % 3 == 0, "");
        alignas(64) uint32_t words[WORDS][LANES];
        const Uint rows[WORDS] = {terms...};
        memcpy(words, rows, sizeof words);
        each_lane(mask, [&](int i) {
            char* pixel = film + size_t(lane(place, i)) * 4 * WORDS;
            for (uint32_t sum = 0; sum < SUMS; sum++) {
                uint64_t low;
                uint32_t high;
                memcpy(&low, pixel + 12 * sum, 8);
                memcpy(&high, pixel + 12 * sum + 8, 4);
                uint64_t term = words[3 * sum][i] | uint64_t(words[3 * sum + 1][i]) << 32;
                low += term;
                high += words[3 * sum + 2][i] + (low < term);
                memcpy(pixel + 12 * sum, &low, 8);
                memcpy(pixel + 12 * sum + 8, &high, 4);
            }
            for (uint32_t count = 3 * SUMS; count < WORDS; count++) {
                uint32_t word;
                memcpy(&word, pixel + 4 * count, 4);
                word += words[count][i];
                memcpy(pixel + 4 * count, &word, 4);
            }
        });
    }
};

/// The work of one call.
struct Tile {
    const uint32_t* work;
    const uint32_t* resting;
    uint32_t width, firstRow, rows;

    explicit Tile(const uint64_t* globals)
        : work((const uint32_t*)globals[WORK_WORD]), resting((const uint32_t*)globals[RESTING_WORD]),
          width(work[work_words::width]), firstRow(work[work_words::firstRow]), rows(work[work_words::rows])
    {
    }

    bool takesSamples(uint32_t x, uint32_t y) const {
        if (work[work_words::adaptive] == 0) return true;
        uint32_t block = y / BLOCK * ((width + BLOCK - 1) / BLOCK) + x / BLOCK;
        return !(resting[block / 32] >> (block % 32) & 1);
    }
};

RAGGIO_INLINE Uint lanesOf(const uint32_t* words) { Uint x; memcpy(&x, words, sizeof x); return x; }

/// The first `count` lanes, at most all.
RAGGIO_INLINE Mask firstLanes(uint32_t count) {
    alignas(64) uint32_t numbers[LANES];
    for (uint32_t i = 0; i < LANES; i++) numbers[i] = i;
    return less(lanesOf(numbers), splat(count));
}

} // namespace lanes
