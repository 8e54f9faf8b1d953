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
            uint32_t x = column + along, y = tile.firstRow + row;
            sample = tile.work[work_words::firstSample] + number;
            advance();
            if (!tile.takesSamples(x, y)) continue;
            pixel = x | y << 16;
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

/// Paths that wait, word by word: `WaitingPath` of kernels/stages/state.slang.
class Queue {
public:
    static constexpr uint32_t CAPACITY = 8 * LANES < 64 ? 64 : 8 * LANES;

    Context& at(Context& context, uint32_t slot) {
        context.paths = {words[0] + slot, CAPACITY};
        return context;
    }

    void clear() { memset(words[path_columns::status], 0, sizeof words[0]); }

    /// Brings the paths among the first `count` that go on to the front, and returns their number.
    RAGGIO_NOINLINE uint32_t divide(uint32_t count) {
        uint16_t from[CAPACITY], to[CAPACITY];
        uint32_t moves = 0, front = 0, back = count, media = 0;
        const uint32_t* states = (const uint32_t*)words[path_columns::status];
        for (;;) {
            while (front < back && states[front] == ALIVE) front++;
            while (front < back && states[back - 1] != ALIVE) back--;
            if (front == back) break;
            to[moves] = uint16_t(front++);
            from[moves++] = uint16_t(--back);
            uint32_t held;
            memcpy(&held, &words[path_columns::mediaCount][from[moves - 1]], 4);
            media = held > media ? held : media;
        }
        using namespace path_columns;
        for (uint32_t column = 0; column < bodies + 2 * media; column++) {
            float* row = words[column];
            // Of a path that has ended nothing is needed but what `renew` adds to the film.
            bool isKept = column == status || column == pixel || column == weight || column == rays || column == flags
                || (column >= radiance && column < radiance + 3);
            if (isKept)
                for (uint32_t i = 0; i < moves; i++) {
                    float ended = row[to[i]];
                    row[to[i]] = row[from[i]];
                    row[from[i]] = ended;
                }
            else
                for (uint32_t i = 0; i < moves; i++) row[to[i]] = row[from[i]];
        }
        return front;
    }

private:
    /// `Status.Alive`.
    static constexpr uint32_t ALIVE = 1;

    alignas(64) float words[path_columns::size][CAPACITY];
};

static void path(const uint64_t* globals)
{
    static thread_local Queue queue;
    Context context(globals);
    Tile tile(globals);
    Samples samples(tile);
    queue.clear();
    uint32_t alive = 0;
    for (;;) {
        // Behind the paths that go on, ended ones make room for new ones.
        uint32_t begun = 0;
        for (uint32_t slot = alive; slot < Queue::CAPACITY; slot += LANES) {
            alignas(64) uint32_t slots[LANES], pixels[LANES], numbers[LANES];
            uint32_t count = Queue::CAPACITY - slot < LANES ? Queue::CAPACITY - slot : LANES;
            for (uint32_t i = 0; i < LANES; i++) {
                slots[i] = slot + i;
                pixels[i] = 0;
                numbers[i] = 0xffffffffu;
                if (i < count && samples.next(pixels[i], numbers[i])) begun++;
            }
            renew(queue.at(context, slot), firstLanes(count), lanesOf(slots), lanesOf(pixels), lanesOf(numbers));
        }
        alive += begun;
        if (alive == 0) return;
        const Uint zero = splat(0u);
        for (uint32_t slot = 0; slot < alive; slot += LANES)
            find(queue.at(context, slot), firstLanes(alive - slot), splat(slot), zero, zero);
        uint32_t found = queue.divide(alive);
        for (uint32_t slot = 0; slot < found; slot += LANES)
            shade(queue.at(context, slot), firstLanes(found - slot), splat(slot), zero, zero);
        alive = queue.divide(found);
    }
}

} // namespace lanes

extern "C" void RAGGIO_OF_LEVEL(raggio_path_)(const uint32_t*, const uint64_t* globals) { lanes::path(globals); }
