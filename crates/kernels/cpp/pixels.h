// KERNEL, which has a thread for each pixel, for LANES pixels of a tile at once.
#pragma once
#include "context.h"

namespace lanes {

static void eachPixel(const uint64_t* globals)
{
    Context context(globals);
    Tile tile(globals);
    uint32_t pixels = tile.width * tile.rows;
    for (uint32_t first = 0; first < pixels; first += LANES) {
        alignas(64) uint32_t x[LANES], y[LANES];
        for (uint32_t i = 0; i < LANES; i++) {
            uint32_t pixel = first + i < pixels ? first + i : first;
            // Columns of a few rows, so that lanes have neighbours.
            x[i] = pixel / tile.rows, y[i] = pixel % tile.rows;
        }
        KERNEL(context, firstLanes(pixels - first), lanesOf(x), lanesOf(y), splat(0u));
    }
}

} // namespace lanes

extern "C" void RAGGIO_ENTRY(const uint32_t*, const uint64_t* globals) { lanes::eachPixel(globals); }
