// The path tracer for LANES paths at once: paths wait in a queue, and those that are at the same stage of kernels/stages go
// through it together.
#pragma once
#include "context.h"

namespace lanes {

/// Samples of a tile one by one: those of a few columns of pixels, then the next few, so that paths that are under way
/// together begin side by side.
class Samples {
public:
    explicit Samples(const Tile& tile) : tile(tile) { left = samples() > 0 && tile.rows > 0 && tile.width > 0; }

    /// The next pixel that takes samples, x below y of 16 bits each, and the sample. False at the end.
    bool next(uint32_t& pixel, uint32_t& sample) {
        while (left) {
            uint32_t x = column + along, y = tile.firstRow + row, of = tile.work[work_words::firstSample] + number;
            advance();
            if (!tile.takesSamples(x, y)) continue;
            pixel = x | y << 16;
            sample = of;
            return true;
        }
        return false;
    }

private:
    static constexpr uint32_t COLUMNS = 4;

    uint32_t samples() const { return tile.work[work_words::samples]; }

    void advance() {
        uint32_t columns = tile.width - column < COLUMNS ? tile.width - column : COLUMNS;
        if (++along < columns) return;
        along = 0;
        if (++row < tile.rows) return;
        row = 0;
        if (++number < samples()) return;
        number = 0;
        column += COLUMNS;
        left = column < tile.width;
    }

    const Tile& tile;
    uint32_t column = 0, along = 0, row = 0, number = 0;
    bool left;
};

#if defined(LANES_AVX2)
/// For each mask the places of its active lanes, a byte each.
struct ActivePlaces {
    uint64_t places[256];

    constexpr ActivePlaces() : places() {
        for (int mask = 0; mask < 256; mask++)
            for (int lane = 0, count = 0; lane < 8; lane++)
                if (mask >> lane & 1) places[mask] |= (uint64_t)lane << 8 * count++;
    }
};
static constexpr ActivePlaces ACTIVE_PLACES;
#endif

/// Way in which the active lanes of a vector come to stand side by side.
struct Packing {
    uint32_t count;

    Packing() = default;

#if defined(LANES_AVX2)
    __m256i order;

    explicit Packing(Mask mask) : count(__builtin_popcount(bits(mask))) {
        order = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)ACTIVE_PLACES.places[bits(mask)]));
    }
#else
    Mask mask;

    explicit Packing(Mask mask) : count(__builtin_popcount(bits(mask))), mask(mask) {}
#endif

    /// Writes the active lanes, and anything behind them, LANES words in all. Returns their number.
    RAGGIO_INLINE uint32_t write(float* to, Float x) const {
#if defined(LANES_AVX512)
        _mm512_storeu_ps(to, _mm512_maskz_compress_ps(mask.bits, (__m512)x));
#elif defined(LANES_AVX2)
        _mm256_storeu_ps(to, _mm256_permutevar8x32_ps((__m256)x, order));
#else
        float packed[LANES] = {};
        uint32_t next = 0;
        each_lane(mask, [&](int i) { packed[next++] = lane(x, i); });
        memcpy(to, packed, sizeof packed);
#endif
        return count;
    }
};

/// Paths that wait, word by word: `WaitingPath` of kernels/stages/state.slang.
class Queue {
public:
    static constexpr uint32_t CAPACITY = 8 * LANES < 64 ? 64 : 8 * LANES;

    Context& at(Context& context, uint32_t slot) {
        context.paths = {words[0] + slot, CAPACITY};
        context.ahead = {nullptr, 0};
        return context;
    }

    /// Context at `slot` for the stage that takes what has been found ahead.
    Context& atFound(Context& context, uint32_t slot) {
        at(context, slot);
        if (takeTurns(context.globals)) context.ahead = {ahead[0] + slot, CAPACITY};
        return context;
    }

    /// Follows the rays that the first `count` paths are about to ask for, more of them in turn than one vector has. The stage
    /// that asks need not find here what it asks for.
    RAGGIO_NOINLINE void followAhead(const uint64_t* globals, uint32_t count, raggio::Counts* counts) {
        if (!takeTurns(globals)) return;
        using namespace path_columns;
        raggio::TracedRay followed[2 * CAPACITY];
        raggio::TracedHit hits[2 * CAPACITY];
        float* places[2 * CAPACITY];
        uint32_t number = 0;
        auto follow = [&](uint32_t slot, Ahead found, bool isAsked, uint32_t ray, uint32_t key, float limit, bool any) {
            memset(&ahead[found + 5][slot], isAsked ? 0xff : 0, 4);
            if (!isAsked) return;
            raggio::TracedRay& to = followed[number];
            for (int k = 0; k < 3; k++) to.origin[k] = words[ray + k][slot], to.direction[k] = words[ray + 3 + k][slot];
            to.key = bits(key, slot);
            to.any = any;
            hits[number] = {limit, raggio::NOTHING, 0, {0, 0}};
            places[number++] = &ahead[found][slot];
        };
        for (uint32_t slot = 0; slot < count; slot++) {
            follow(slot, ONWARD, !(bits(flags, slot) & NO_RAY_ONWARD), ray, key, __builtin_inff(), false);
            follow(slot, SHADOW, hasShadowRay(slot), shadowRay, shadowKey, words[shadowDistance][slot], bits(mediaCount, slot) == 0);
        }
        if (counts) counts->walk.add(number);
        RAGGIO_OF_LEVEL(raggio_walk_)(globals, followed, hits, number);
        for (uint32_t i = 0; i < number; i++) {
            float hit[5];
            memcpy(hit, &hits[i], sizeof hit);
            for (int k = 0; k < 5; k++) places[i][k * CAPACITY] = hit[k];
        }
    }

    void clear() { memset(words[path_columns::status], 0, sizeof words[0]); }

    /// Counts the paths of the vector at `slot`, of which the first `count` may be under way, and their shadow rays.
    RAGGIO_NOINLINE void count(raggio::Counts& counts, uint32_t slot, uint32_t count) const {
        uint32_t paths = count < LANES ? count : LANES, shadows = 0;
        for (uint32_t i = slot; i < slot + paths; i++) shadows += hasShadowRay(i);
        counts.find.add(paths);
        counts.shadow.add(shadows);
    }

    /// Brings the paths among the first `count` that go on to the front, in their order, and those that have ended behind
    /// them. Returns the number of those that go on.
    RAGGIO_NOINLINE uint32_t divide(uint32_t count) {
        const Uint alive = splat(ALIVE);
        uint32_t vectors = (count + LANES - 1) / LANES, left = 0;
        Packing goOn[CAPACITY / LANES], ended[CAPACITY / LANES];
        Uint media = splat(0u);
        for (uint32_t i = 0; i < vectors; i++) {
            // Whole vectors are divided; behind the first `count` no path goes on.
            Mask isAlive = equal(vector(path_columns::status, i), alive);
            goOn[i] = Packing(isAlive);
            ended[i] = Packing(inverse(isAlive));
            left += goOn[i].count;
            media = largest(media, choose(isAlive, vector(path_columns::mediaCount, i), splat(0u)));
        }
        if (left == count) return left;
        uint32_t mostMedia = 0;
        each_lane(ALL, [&](int i) { mostMedia = lane(media, i) > mostMedia ? lane(media, i) : mostMedia; });
        using namespace path_columns;
        for (uint32_t column = 0; column < bodies + 2 * mostMedia; column++) {
            // Of a path that has ended nothing is needed but what `renew` adds to the film.
            bool isKept = column == status || column == pixel || column == weight || column == rays || column == flags
                || (column >= radiance && column < radiance + 3);
            float behind[CAPACITY + LANES];
            uint32_t front = 0, back = 0;
            for (uint32_t i = 0; i < vectors; i++) {
                Float x = as_float(vector(column, i));
                if (isKept) back += ended[i].write(behind + back, x);
                // What is written has been read: the front is not ahead of this vector.
                front += goOn[i].write(words[column] + front, x);
            }
            if (isKept) memcpy(words[column] + front, behind, 4 * back);
        }
        return left;
    }

private:
    /// Whether rays take turns, so that they are faster the more there are of them.
    static bool takeTurns(const uint64_t* globals) {
        const uint64_t* traversal = (const uint64_t*)globals[TRAVERSAL_WORD];
        return traversal && traversal[raggio::IN_TURN_WORD];
    }

    /// `Status.Alive`.
    static constexpr uint32_t ALIVE = 1;
    /// `NO_RAY_ONWARD` of kernels/stages/state.slang.
    static constexpr uint32_t NO_RAY_ONWARD = 64;

    bool hasShadowRay(uint32_t slot) const {
        const auto value = &words[path_columns::shadowValue];
        return value[0][slot] > 0 || value[1][slot] > 0 || value[2][slot] > 0;
    }

    uint32_t bits(uint32_t column, uint32_t slot) const {
        uint32_t x;
        memcpy(&x, &words[column][slot], sizeof x);
        return x;
    }

    Uint vector(uint32_t column, uint32_t i) const {
        Uint x;
        memcpy(&x, words[column] + i * LANES, sizeof x);
        return x;
    }

    alignas(64) float words[path_columns::size][CAPACITY];
    alignas(64) float ahead[AHEAD][CAPACITY];
};

static void path(const uint64_t* globals)
{
    static thread_local Queue queue;
    Context context(globals);
    Tile tile(globals);
    Samples samples(tile);
    queue.clear();
    raggio::Counts* counts = context.counts();
    uint32_t alive = 0;
    for (;;) {
        // Behind the paths that go on, ended ones make room for new ones.
        uint32_t begun = 0;
        for (uint32_t slot = alive; slot < Queue::CAPACITY; slot += LANES) {
            alignas(64) uint32_t slots[LANES], pixels[LANES], numbers[LANES];
            uint32_t count = Queue::CAPACITY - slot < LANES ? Queue::CAPACITY - slot : LANES, before = begun;
            for (uint32_t i = 0; i < LANES; i++) {
                slots[i] = slot + i;
                pixels[i] = 0;
                numbers[i] = 0xffffffffu;
                if (i < count && samples.next(pixels[i], numbers[i])) begun++;
            }
            if (counts) counts->renew.add(begun - before);
            renew(queue.at(context, slot), firstLanes(count), lanesOf(slots), lanesOf(pixels), lanesOf(numbers));
        }
        alive += begun;
        if (alive == 0) return;
        const Uint zero = splat(0u);
        queue.followAhead(globals, alive, counts);
        for (uint32_t slot = 0; slot < alive; slot += LANES) {
            if (counts) queue.count(*counts, slot, alive - slot);
            find(queue.atFound(context, slot), firstLanes(alive - slot), splat(slot), zero, zero);
        }
        uint32_t found = queue.divide(alive);
        for (uint32_t slot = 0; slot < found; slot += LANES) {
            if (counts) counts->shade.add(found - slot < LANES ? found - slot : LANES);
            shade(queue.at(context, slot), firstLanes(found - slot), splat(slot), zero, zero);
        }
        alive = queue.divide(found);
    }
}

} // namespace lanes

extern "C" void RAGGIO_ENTRY(const uint32_t*, const uint64_t* globals) { lanes::path(globals); }
