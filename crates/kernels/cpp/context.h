// What kernels that run for LANES paths at once find around them: their buffers, the work, and the functions that are not
// translated.
//
// The build script writes, before this file, the translated kernels, `fill`, which finds their buffers, and where members of
// structures stand; LEVEL ends the names of this level's functions.
#pragma once
#include "rays.h"

namespace lanes {

struct Context {
    Buffers buffers;
    const char* work;
    const uint64_t* globals;
    /// Words of the paths in the queue, from the first lane's on.
    Columns paths;

    explicit Context(const uint64_t* globals)
        : work((const char*)globals[WORK_WORD]), globals(globals), paths{nullptr, 0}
    {
        fill(buffers, globals);
    }

    /// Traces the rays of active lanes in turn.
    RAGGIO_NOINLINE void trace(
        Mask mask, Float originX, Float originY, Float originZ, Float directionX, Float directionY, Float directionZ,
        Uint key, Float limit, Mask any, Float& distance, Uint& shape, Uint& triangle, Float& second, Float& third) const
    {
        alignas(64) float in[7][LANES], out[5][LANES];
        alignas(64) uint32_t keys[LANES];
        const Float rows[7] = {originX, originY, originZ, directionX, directionY, directionZ, limit};
        memcpy(in, rows, sizeof in);
        memcpy(keys, &key, sizeof keys);
        raggio::TracedRay rays[LANES];
        raggio::TracedHit hits[LANES];
        uint32_t anyBits = bits(any), count = 0;
        each_lane(mask, [&](int i) {
            bool isAny = anyBits >> i & 1;
            rays[count++] = {{in[0][i], in[1][i], in[2][i]}, {in[3][i], in[4][i], in[5][i]}, keys[i], in[6][i], isAny};
        });
        RAGGIO_OF_LEVEL(raggio_walk_)(globals, rays, hits, count);
        count = 0;
        each_lane(mask, [&](int i) {
            float words[5];
            memcpy(words, &hits[count++], sizeof words);
            for (int k = 0; k < 5; k++) out[k][i] = words[k];
        });
        auto row = [&](int k) { Float x; memcpy(&x, out[k], sizeof x); return x; };
        distance = row(0), shape = as_uint(row(1)), triangle = as_uint(row(2)), second = row(3), third = row(4);
    }

    /// Adds samples to the film, of which some may be of one pixel.
    RAGGIO_NOINLINE void addToFilm(
        Mask mask, Uint place, Float red, Float green, Float blue, Mask valid, Uint rays, Float weight) const
    {
        uint32_t validBits = bits(valid);
        each_lane(mask, [&](int i) {
            RAGGIO_OF_LEVEL(raggio_add_)(
                globals, lane(place, i), lane(red, i), lane(green, i), lane(blue, i), validBits >> i & 1, lane(rays, i), lane(weight, i));
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
