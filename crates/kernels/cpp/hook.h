// Puts the walk of traversal.h in the place of the kernels' own, where the processor and the scene have it.
//
// The build script takes the names below from the generated kernels: KERNEL_HIT, KERNEL_RAY and KERNEL_CONTEXT are types,
// KERNEL_TRACE is kernels/tracing.slang's `trace`, KERNEL_WALK its definition, KERNEL_TRIANGLE_IS_THERE and
// KERNEL_FIRST_THERE are those of kernels/coverage.slang.
#if defined(__AVX2__) && defined(__FMA__)
#include "traversal.h"

namespace raggio {

/// Surfaces that let part of the light pass, for one ray.
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
};

} // namespace raggio

static __attribute__((noinline)) KERNEL_HIT KERNEL_TRACE(
    KERNEL_RAY* ray, uint32_t key, float limit, bool any, KERNEL_CONTEXT* context)
{
    // The host puts the address of its `Traversal` behind the parameters of the kernels.
    const uint64_t* globals;
    memcpy(&globals, context, sizeof globals);
    const raggio::Traversal* traversal = (const raggio::Traversal*)globals[KERNEL_TRAVERSAL_WORD];
    if (!traversal) return KERNEL_WALK(ray, key, limit, any, context);

    raggio::TracedRay traced;
    static_assert(sizeof(KERNEL_RAY) == sizeof traced.origin + sizeof traced.direction, "");
    memcpy(&traced, ray, sizeof(KERNEL_RAY));
    traced.key = key;
    traced.limit = limit;
    raggio::KernelHoles holes = {ray, key, context};
    raggio::TracedHit found =
        any ? raggio::walk<true>(*traversal, traced, holes) : raggio::walk<false>(*traversal, traced, holes);
    KERNEL_HIT hit;
    static_assert(sizeof hit == sizeof found, "");
    memcpy(&hit, &found, sizeof hit);
    return hit;
}
#else
static KERNEL_HIT KERNEL_TRACE(KERNEL_RAY* ray, uint32_t key, float limit, bool any, KERNEL_CONTEXT* context)
{
    return KERNEL_WALK(ray, key, limit, any, context);
}
#endif
