// Puts the walk of traversal.h in the place of the kernels' own, where the processor and the scene have it.
//
// The build script takes the names below from the generated kernels: KERNEL_HIT, KERNEL_RAY and KERNEL_CONTEXT are types,
// KERNEL_TRACE is kernels/tracing.slang's `trace`, KERNEL_WALK its definition, KERNEL_TRIANGLE_IS_THERE and
// KERNEL_FIRST_THERE are those of kernels/coverage.slang, KERNEL_ADD that of kernels/pixels.slang.
#include "rays.h"

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

/// What the host puts behind the parameters of the kernels; null where rays go as on other devices.
RAGGIO_INLINE const Traversal* traversalOf(const uint64_t* globals) {
    return (const Traversal*)globals[KERNEL_TRAVERSAL_WORD];
}

} // namespace raggio
#endif

static RAGGIO_NOINLINE KERNEL_HIT KERNEL_TRACE(KERNEL_RAY* ray, uint32_t key, float limit, bool any, KERNEL_CONTEXT* context)
{
#if defined(__AVX2__) && defined(__FMA__)
    const uint64_t* globals;
    memcpy(&globals, context, sizeof globals);
    if (const raggio::Traversal* traversal = raggio::traversalOf(globals)) {
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
#endif
    return KERNEL_WALK(ray, key, limit, any, context);
}

extern "C" void RAGGIO_OF_LEVEL(raggio_walk_)(
    const uint64_t* globals, const raggio::TracedRay* rays, raggio::TracedHit* hits, uint32_t count)
{
    KERNEL_CONTEXT context;
    static_assert(sizeof context == sizeof globals, "");
    memcpy(&context, &globals, sizeof globals);
#if defined(__AVX2__) && defined(__FMA__)
    if (const raggio::Traversal* traversal = raggio::traversalOf(globals)) {
        raggio::walkInTurn(*traversal, rays, hits, count, [&](raggio::Way& way) {
            return raggio::KernelHoles{(KERNEL_RAY*)&way.ray, way.ray.key, &context};
        });
        return;
    }
#endif
    for (uint32_t i = 0; i < count; i++) {
        KERNEL_HIT hit = KERNEL_WALK((KERNEL_RAY*)&rays[i], rays[i].key, rays[i].limit, rays[i].any, &context);
        static_assert(sizeof hit == sizeof hits[i], "");
        memcpy(&hits[i], &hit, sizeof hit);
    }
}

extern "C" void RAGGIO_OF_LEVEL(raggio_add_)(
    const uint64_t* globals, uint32_t place, float red, float green, float blue, bool valid, uint32_t rays, float weight)
{
    KERNEL_CONTEXT context;
    memcpy(&context, &globals, sizeof globals);
    Vector<float, 3> radiance;
    radiance.x = red;
    radiance.y = green;
    radiance.z = blue;
    KERNEL_ADD(place, radiance, valid, rays, weight, &context);
}
