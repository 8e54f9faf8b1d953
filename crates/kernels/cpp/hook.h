// Puts the walk of traversal.h in the place of the kernels' own, where the processor and the scene have it.
//
// The build script takes the names below from the generated kernels: KERNEL_HIT, KERNEL_RAY and KERNEL_CONTEXT are types,
// KERNEL_WALK is kernels/walk.slang's `walk`, KERNEL_OWN_WALK its definition, KERNEL_TRIANGLE_IS_THERE and
// KERNEL_FIRST_THERE are those of kernels/coverage.slang.
#include "rays.h"

#if defined(__AVX2__) && defined(__FMA__)
#include "traversal.h"

namespace raggio {

/// Surfaces that let part of the light pass, for one ray; nothing is counted.
struct KernelHoles {
    KERNEL_RAY* ray;
    uint32_t key;
    KERNEL_CONTEXT* context;

    RAGGIO_INLINE bool triangleIsThere(uint32_t shape, uint32_t triangle, float second, float third) const {
        Vector<float, 2> barycentrics;
        barycentrics.x = second;
        barycentrics.y = third;
        return KERNEL_TRIANGLE_IS_THERE(shape, triangle, barycentrics, key, context);
    }

    RAGGIO_INLINE float firstThere(uint32_t shape, float distance) const {
        return KERNEL_FIRST_THERE(ray, shape, distance, key, context);
    }

    RAGGIO_INLINE void meetsNode() const {}
    RAGGIO_INLINE void meetsTriangles() const {}
    RAGGIO_INLINE void meetsShapes() const {}
};

struct CountingHoles : KernelHoles {
    Counts* counts;

    RAGGIO_INLINE void meetsNode() const { counts->nodes++; }
    RAGGIO_INLINE void meetsTriangles() const { counts->triangleBlocks++; }
    RAGGIO_INLINE void meetsShapes() const { counts->shapeBlocks++; }
};

/// What the host puts behind the parameters of the kernels; null where rays go as on other devices.
RAGGIO_INLINE const Traversal* traversalOf(const uint64_t* globals) {
    return (const Traversal*)globals[KERNEL_TRAVERSAL_WORD];
}

/// Traces `count` rays, each into its hit. `holesOf` answers for each ray.
template <class HolesOf>
RAGGIO_INLINE void walkAll(
    const Traversal& traversal, const TracedRay* rays, TracedHit* hits, uint32_t count, const HolesOf& holesOf)
{
    if (traversal.inTurn) {
        walkInTurn(traversal, rays, hits, count, [&](const Way& way) { return holesOf(way.ray); });
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        auto holes = holesOf(rays[i]);
        if (rays[i].any) walk<true>(traversal, rays[i], holes, hits[i]);
        else walk<false>(traversal, rays[i], holes, hits[i]);
    }
}

/// `walkAll` for a host that counts: out of the way of renders, which do not.
RAGGIO_NOINLINE void walkAndCount(
    const Traversal& traversal, const TracedRay* rays, TracedHit* hits, uint32_t count, KERNEL_CONTEXT* context, Counts* counts)
{
    walkAll(traversal, rays, hits, count, [&](const TracedRay& ray) {
        return CountingHoles{{(KERNEL_RAY*)&ray, ray.key, context}, counts};
    });
}

} // namespace raggio
#endif

static RAGGIO_NOINLINE void KERNEL_WALK(KERNEL_RAY* ray, uint32_t key, bool any, KERNEL_HIT* hit, KERNEL_CONTEXT* context)
{
#if defined(__AVX2__) && defined(__FMA__)
    const uint64_t* globals;
    memcpy(&globals, context, sizeof globals);
    if (const raggio::Traversal* traversal = raggio::traversalOf(globals)) {
        raggio::TracedRay traced;
        static_assert(sizeof(KERNEL_RAY) == sizeof traced.origin + sizeof traced.direction, "");
        memcpy(&traced, ray, sizeof(KERNEL_RAY));
        traced.key = key;
        raggio::KernelHoles holes = {ray, key, context};
        raggio::TracedHit found;
        static_assert(sizeof *hit == sizeof found, "");
        memcpy(&found, hit, sizeof found);
        if (any) raggio::walk<true>(*traversal, traced, holes, found);
        else raggio::walk<false>(*traversal, traced, holes, found);
        memcpy(hit, &found, sizeof found);
        return;
    }
#endif
    KERNEL_OWN_WALK(ray, key, any, hit, context);
}

extern "C" void RAGGIO_OF_LEVEL(raggio_walk_)(
    const uint64_t* globals, const raggio::TracedRay* rays, raggio::TracedHit* hits, uint32_t count)
{
    KERNEL_CONTEXT context;
    static_assert(sizeof context == sizeof globals, "");
    memcpy(&context, &globals, sizeof globals);
#if defined(__AVX2__) && defined(__FMA__)
    if (const raggio::Traversal* traversal = raggio::traversalOf(globals)) {
        raggio::Counts* counts = (raggio::Counts*)globals[KERNEL_COUNTS_WORD];
        if (counts) return raggio::walkAndCount(*traversal, rays, hits, count, &context, counts);
        return raggio::walkAll(*traversal, rays, hits, count, [&](const raggio::TracedRay& ray) {
            return raggio::KernelHoles{(KERNEL_RAY*)&ray, ray.key, &context};
        });
    }
#endif
    static_assert(sizeof(KERNEL_HIT) == sizeof *hits, "");
    for (uint32_t i = 0; i < count; i++)
        KERNEL_OWN_WALK((KERNEL_RAY*)&rays[i], rays[i].key, rays[i].any, (KERNEL_HIT*)&hits[i], &context);
}
