// Rays, and what they find, as hand-written code passes them: `Ray` and `Hit` of kernels/ray.slang begin alike.
#pragma once
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define RAGGIO_INLINE __attribute__((always_inline)) inline
#define RAGGIO_NOINLINE __attribute__((noinline))
#define RAGGIO_JOINED(a, b) a##b
#define RAGGIO_NAME(name, level) RAGGIO_JOINED(name, level)
/// Name of a function of this level of instruction set: LEVEL ends it.
#define RAGGIO_OF_LEVEL(name) RAGGIO_NAME(name, LEVEL)
/// Name of the function that runs KERNEL.
#define RAGGIO_ENTRY RAGGIO_OF_LEVEL(RAGGIO_NAME(RAGGIO_NAME(raggio_, KERNEL), _))

namespace raggio {

constexpr uint32_t NOTHING = 0xffffffffu;

/// Word of `Traversal` that is not 0 where what rays read is in no cache near by: then they take turns.
constexpr uint32_t IN_TURN_WORD = 9;

struct TracedRay {
    float origin[3];
    float direction[3];
    /// Decides which surfaces are there that let part of the light pass: kernels/coverage.slang.
    uint32_t key;
    /// Whether any surface will do.
    bool any;
};

struct TracedHit {
    float distance;
    uint32_t shape;
    uint32_t triangle;
    float barycentrics[2];

    RAGGIO_INLINE bool found() const { return shape != NOTHING; }

    /// Whether a surface at `t` is nearer. The caller's limit, which no surface is at, is nearer than all at its distance.
    RAGGIO_INLINE bool isBehind(float t, uint32_t otherShape, uint32_t otherTriangle) const {
        if (t < distance) return true;
        return t == distance && found() && (otherShape < shape || (otherShape == shape && otherTriangle < triangle));
    }
};

/// Calls of a stage for LANES paths, and paths in them all.
struct StageCounts {
    uint64_t calls;
    uint64_t paths;

    /// One more call, unless it is for no path.
    void add(uint32_t count) {
        calls += count > 0;
        paths += count;
    }
};

/// Work that is counted where the host asks for it: `Counts` of src/cpu/counts.rs.
struct Counts {
    /// Tests of rays that walk: against nodes of eight children, blocks of up to four triangles, blocks of up to four
    /// closed forms.
    uint64_t nodes;
    uint64_t triangleBlocks;
    uint64_t shapeBlocks;
    StageCounts renew;
    StageCounts find;
    /// Paths that have a shadow ray, in calls of `find` with any.
    StageCounts shadow;
    StageCounts shade;
    /// Rays that walk through a hierarchy, those that take turns in one call.
    StageCounts walk;
};

} // namespace raggio

// Tracing for kernels of several paths, by hook.h: `walk` of kernels/walk.slang, for rays that each have their hit.
extern "C" void RAGGIO_OF_LEVEL(raggio_walk_)(
    const uint64_t* globals, const raggio::TracedRay* rays, raggio::TracedHit* hits, uint32_t count);
