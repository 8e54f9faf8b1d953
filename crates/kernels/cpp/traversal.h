// Walk through the hierarchies of eight children a node, for x86 processors with AVX2.
//
// What decides a hit is the arithmetic of kernels/intersections.slang and kernels/shapes, operation for operation and without
// fused ones, so that both walks find the same bits; tests hold them to that. What decides which boxes are looked into
// need only be conservative, and may fuse. Among surfaces at one distance the lowest (shape, triangle) is the nearest, in
// whatever order they are found.
//
// `Holes` answers whether surfaces are there that let part of the light pass: see kernels/coverage.slang. It is told of each
// node and block that a ray is tested against, for those who count them.
#pragma once
#include <immintrin.h>
#include "rays.h"

namespace raggio {

constexpr float INFINITE = __builtin_inff();
constexpr float ROUNDING = 5.9604645e-8f;

// ---- What src/cpu/wide.rs makes

/// Boxes of eight children, by planes: lower and upper x, lower and upper y, lower and upper z.
struct alignas(64) Node {
    float planes[6][8];
    uint32_t children[8];
    uint32_t unused[8];
};
static_assert(sizeof(Node) == 256, "");

/// A reference to what is below a child: a node, triangles of a mesh, or a shape of the upper hierarchy.
constexpr uint32_t LEAF = 0x80000000u;
/// Triangles: their number less one in four bits, and the place of the first among the mesh's.
constexpr uint32_t TRIANGLES_SHIFT = 27;
constexpr uint32_t PLACE = (1u << TRIANGLES_SHIFT) - 1;
/// Shapes: their kind, and the place of a block of four or of an instance.
enum Kind : uint32_t { SPHERES = 0, RECTANGLES = 1, BOXES = 2, INSTANCE = 3, ROUNDS = 4 };

/// Four closed forms of one kind, transposed; those that are absent have no shape, and NaN for numbers.
template <int ROWS> struct alignas(16) Block {
    float rows[ROWS][4];
    /// Places in `Scene.order`.
    uint32_t shapes[4];
    /// Not 0 for shapes that let part of the light pass.
    uint32_t holes[4];
};
typedef Block<4> SphereBlock;     // centre, radius
typedef Block<14> RectangleBlock; // corner, edges, normal, the edges' squares
typedef Block<15> BoxBlock;       // centre, half its size, its axes
typedef Block<16> RoundBlock;     // first centre, axes, radius, height, slope, whether it is capped

struct alignas(16) InstanceRecord {
    /// Columns of the map from the world to the mesh.
    float columns[4][4];
    /// The mesh's root, and the places where its nodes and its triangles begin.
    uint32_t root;
    uint32_t firstNode;
    uint32_t firstTriangle;
    /// Place in `Scene.order`.
    uint32_t shape;
    uint32_t holes;
    /// Not 0 if the map changes nothing.
    uint32_t identity;
    uint32_t unused[2];
};
static_assert(sizeof(InstanceRecord) == 96, "");

/// A corner and the number of a vertex, three times.
struct TriangleRecord {
    float corners[3][4];
};

struct Traversal {
    const Node* nodes;
    const Node* meshNodes;
    const TriangleRecord* triangles;
    const InstanceRecord* instances;
    const SphereBlock* spheres;
    const RectangleBlock* rectangles;
    const BoxBlock* boxes;
    const RoundBlock* rounds;
    uint64_t root;
    /// Not 0 where rays that come together take turns: what they read is in no cache near by.
    uint64_t inTurn;
};
static_assert(offsetof(Traversal, inTurn) == 8 * IN_TURN_WORD, "");

// ---- Rays

/// A ray as boxes want it: the distance of a plane is plane x reciprocal + near, or + far, each with the room that rounding
/// needs (kernels/bvh.slang); and as triangles want it (kernels/shapes/mesh.slang).
struct alignas(16) RaySetup {
    float reciprocal[4];
    float near[4];
    float far[4];
    /// Offsets in a node of the planes that the ray meets first, along x, y and z.
    size_t offsets[3];
    /// Axes across and along the ray, for permuting corners.
    __m128i axes;
    float originX, originY, originZ, shearX, shearY, scale;
};

RAGGIO_INLINE void setUp(__m128 origin, __m128 direction, RaySetup& setup) {
    const __m128 sign = _mm_set1_ps(-0.0f), tiny = _mm_set1_ps(1e-18f);
    __m128 size = _mm_andnot_ps(sign, direction);
    __m128 divisor = _mm_blendv_ps(direction, _mm_or_ps(tiny, _mm_and_ps(sign, direction)), _mm_cmplt_ps(size, tiny));
    __m128 reciprocal = _mm_div_ps(_mm_set1_ps(1.0f), divisor);
    __m128 from = _mm_andnot_ps(sign, origin);
    __m128 largest = _mm_max_ps(_mm_max_ps(from, _mm_shuffle_ps(from, from, 0xc9)), _mm_shuffle_ps(from, from, 0xd2));
    largest = _mm_shuffle_ps(largest, largest, 0);
    __m128 room = _mm_xor_ps(_mm_mul_ps(largest, _mm_set1_ps(8.0f * ROUNDING)), _mm_and_ps(sign, reciprocal));
    _mm_store_ps(setup.reciprocal, reciprocal);
    _mm_store_ps(setup.near, _mm_xor_ps(sign, _mm_mul_ps(_mm_add_ps(origin, room), reciprocal)));
    _mm_store_ps(setup.far, _mm_xor_ps(sign, _mm_mul_ps(_mm_sub_ps(origin, room), reciprocal)));
    unsigned negative = _mm_movemask_ps(reciprocal);
    setup.offsets[0] = negative & 1 ? 32 : 0;
    setup.offsets[1] = negative & 2 ? 96 : 64;
    setup.offsets[2] = negative & 4 ? 160 : 128;

    // The axis along which the ray goes furthest: x where |x| >= |y|, |z|; else y where |y| >= |z|; else z.
    unsigned notLess = _mm_movemask_ps(_mm_cmpge_ps(size, _mm_shuffle_ps(size, size, 0xc9))); // x >= y, y >= z, z >= x
    unsigned alsoZ = _mm_movemask_ps(_mm_cmpge_ps(size, _mm_shuffle_ps(size, size, 0xd2)));   // x >= z
    unsigned along = notLess & alsoZ & 1 ? 0 : notLess & 2 ? 1 : 2;
    alignas(16) static const int32_t AXES[3][4] = {{1, 2, 0, 3}, {2, 0, 1, 3}, {0, 1, 2, 3}};
    setup.axes = _mm_load_si128((const __m128i*)AXES[along]);
    alignas(16) float d[4], o[4];
    _mm_store_ps(d, _mm_permutevar_ps(direction, setup.axes));
    _mm_store_ps(o, _mm_permutevar_ps(origin, setup.axes));
    setup.scale = 1.0f / d[2];
    setup.shearX = -(d[0] * setup.scale);
    setup.shearY = -(d[1] * setup.scale);
    setup.originX = o[0];
    setup.originY = o[1];
    setup.originZ = o[2];
}

// ---- Triangles

/// Difference a.x b.y - a.y b.x of products that agree in most digits: `nearlyEqualProducts` of kernels/shapes/mesh.slang.
inline float nearlyEqualProducts(float ax, float ay, float bx, float by) {
    float values[4] = {ax, ay, by, bx};
    uint32_t bits[4], exponents[4], significands[4];
    memcpy(bits, values, sizeof bits);
    for (int i = 0; i < 4; i++) {
        exponents[i] = bits[i] & 0x7f800000u;
        significands[i] = (bits[i] & 0x7fffffu) | 0x800000u;
    }
    int p = int(exponents[0] >> 23) + int(exponents[2] >> 23), q = int(exponents[1] >> 23) + int(exponents[3] >> 23);
    bool finerP = p <= q;
    uint32_t first = significands[0] * significands[2], second = significands[1] * significands[3];
    int difference = int((first << ((p > q ? p - q : 0) & 31)) - (second << ((q > p ? q - p : 0) & 31)));
    float units[2];
    memcpy(&units[0], &exponents[finerP ? 0 : 1], 4);
    memcpy(&units[1], &exponents[finerP ? 2 : 3], 4);
    float value = float(difference) * (1.1920929e-7f * units[0]) * (1.1920929e-7f * units[1]);
    return (bits[0] ^ bits[2]) >> 31 ? -value : value;
}

struct Rows {
    __m256 x, y, z;
};

/// The first three components of eight vectors of four.
RAGGIO_INLINE Rows transposed(__m256 a, __m256 b, __m256 c, __m256 d) {
    __m256 low = _mm256_unpacklo_ps(a, b), lowToo = _mm256_unpacklo_ps(c, d);
    __m256 high = _mm256_unpackhi_ps(a, b), highToo = _mm256_unpackhi_ps(c, d);
    return {_mm256_shuffle_ps(low, lowToo, 0x44), _mm256_shuffle_ps(low, lowToo, 0xee), _mm256_shuffle_ps(high, highToo, 0x44)};
}

RAGGIO_INLINE __m128 lowHalf(__m256 v) { return _mm256_castps256_ps128(v); }
RAGGIO_INLINE __m128 highHalf(__m256 v) { return _mm256_extractf128_ps(v, 1); }
RAGGIO_INLINE __m256 magnitudes(__m256 v) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), v); }
RAGGIO_INLINE __m128 magnitudes(__m128 v) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), v); }

/// Intersects up to four triangles that stand side by side, the first with the number `first`.
///
/// Corners lie as the other kernels read them and are transposed here: that costs less than reading a copy would.
template <class Holes>
RAGGIO_INLINE void intersectTriangles(
    const TriangleRecord* triangles, uint32_t first, unsigned count, const RaySetup& ray, uint32_t shape, bool hasHoles,
    const Holes& holes, TracedHit& hit)
{
    holes.meetsTriangles();
    const float* t0 = triangles[first].corners[0];
    const float* t1 = t0 + (count > 1 ? 12 : 0);
    const float* t2 = t0 + (count > 2 ? 24 : 0);
    const float* t3 = t0 + (count > 3 ? 36 : 0);
    __m128i axes = ray.axes;
    __m256i axesTwice = _mm256_broadcastsi128_si256(axes);
    auto two = [&](const float* t) { return _mm256_permutevar_ps(_mm256_loadu_ps(t), axesTwice); };
    // The third corner of a triangle stands in both halves: beside the first and the second.
    auto third = [&](const float* t) { return _mm256_permutevar_ps(_mm256_broadcast_ps((const __m128*)(t + 8)), axesTwice); };
    Rows ab = transposed(two(t0), two(t1), two(t2), two(t3));
    Rows cc = transposed(third(t0), third(t1), third(t2), third(t3));

    __m256 originX = _mm256_broadcast_ss(&ray.originX), originY = _mm256_broadcast_ss(&ray.originY),
           originZ = _mm256_broadcast_ss(&ray.originZ), shearX = _mm256_broadcast_ss(&ray.shearX),
           shearY = _mm256_broadcast_ss(&ray.shearY);
    __m256 abZ = _mm256_sub_ps(ab.z, originZ), ccZ = _mm256_sub_ps(cc.z, originZ);
    __m256 abX = _mm256_add_ps(_mm256_sub_ps(ab.x, originX), _mm256_mul_ps(shearX, abZ));
    __m256 abY = _mm256_add_ps(_mm256_sub_ps(ab.y, originY), _mm256_mul_ps(shearY, abZ));
    __m256 ccX = _mm256_add_ps(_mm256_sub_ps(cc.x, originX), _mm256_mul_ps(shearX, ccZ));
    __m256 ccY = _mm256_add_ps(_mm256_sub_ps(cc.y, originY), _mm256_mul_ps(shearY, ccZ));

    // Edge functions: u of c and b, v of a and c, w of b and a. The difference of b and c is that of c and b, negated.
    __m256 p = _mm256_mul_ps(abX, ccY), q = _mm256_mul_ps(abY, ccX), d = _mm256_sub_ps(p, q);
    __m128 aX = lowHalf(abX), aY = lowHalf(abY), bX = highHalf(abX), bY = highHalf(abY);
    __m128 pw = _mm_mul_ps(bX, aY), qw = _mm_mul_ps(bY, aX);
    __m128 u = _mm_xor_ps(highHalf(d), _mm_set1_ps(-0.0f)), v = lowHalf(d), w = _mm_sub_ps(pw, qw);
    const float near = 16.0f * ROUNDING;
    unsigned close = _mm256_movemask_ps(_mm256_cmp_ps(
        magnitudes(d), _mm256_mul_ps(_mm256_set1_ps(near), _mm256_add_ps(magnitudes(p), magnitudes(q))), _CMP_LT_OQ));
    unsigned closeW = _mm_movemask_ps(
        _mm_cmplt_ps(magnitudes(w), _mm_mul_ps(_mm_set1_ps(near), _mm_add_ps(magnitudes(pw), magnitudes(qw)))));
    if (__builtin_expect(close | closeW, 0)) {
        alignas(32) float x[8], y[8], cx[8], cy[8], us[4], vs[4], ws[4];
        _mm256_store_ps(x, abX), _mm256_store_ps(y, abY), _mm256_store_ps(cx, ccX), _mm256_store_ps(cy, ccY);
        _mm_store_ps(us, u), _mm_store_ps(vs, v), _mm_store_ps(ws, w);
        for (; close; close &= close - 1) {
            int i = __builtin_ctz(close);
            if (i < 4) vs[i] = nearlyEqualProducts(x[i], y[i], cx[i], cy[i]);
            else us[i - 4] = nearlyEqualProducts(cx[i], cy[i], x[i], y[i]);
        }
        for (; closeW; closeW &= closeW - 1) {
            int i = __builtin_ctz(closeW);
            ws[i] = nearlyEqualProducts(x[i + 4], y[i + 4], x[i], y[i]);
        }
        u = _mm_load_ps(us), v = _mm_load_ps(vs), w = _mm_load_ps(ws);
    }
    __m128 zero = _mm_setzero_ps();
    __m128 outside = _mm_and_ps(
        _mm_cmplt_ps(_mm_min_ps(u, _mm_min_ps(v, w)), zero), _mm_cmplt_ps(zero, _mm_max_ps(u, _mm_max_ps(v, w))));
    __m128 sum = _mm_add_ps(_mm_add_ps(u, v), w);
    unsigned met = _mm_movemask_ps(_mm_andnot_ps(outside, _mm_cmpneq_ps(sum, zero))) & ((1u << count) - 1);
    if (!met) return;

    __m128 scale = _mm_broadcast_ss(&ray.scale), inverse = _mm_div_ps(_mm_set1_ps(1.0f), sum);
    __m128 az = _mm_mul_ps(scale, lowHalf(abZ)), bz = _mm_mul_ps(scale, highHalf(abZ)), cz = _mm_mul_ps(scale, lowHalf(ccZ));
    __m128 t = _mm_mul_ps(
        _mm_add_ps(_mm_add_ps(_mm_mul_ps(u, az), _mm_mul_ps(v, bz)), _mm_mul_ps(w, cz)), inverse);
    met &= _mm_movemask_ps(_mm_and_ps(_mm_cmplt_ps(zero, t), _mm_cmple_ps(t, _mm_set1_ps(hit.distance))));
    if (!met) return;
    alignas(16) float distances[4], second[4], third4[4];
    _mm_store_ps(distances, t), _mm_store_ps(second, _mm_mul_ps(v, inverse)), _mm_store_ps(third4, _mm_mul_ps(w, inverse));
    do {
        unsigned i = __builtin_ctz(met);
        met &= met - 1;
        if (!hit.isBehind(distances[i], shape, first + i)) continue;
        if (hasHoles && !holes.triangleIsThere(shape, first + i, second[i], third4[i])) continue;
        hit = {distances[i], shape, first + i, {second[i], third4[i]}};
    } while (met);
}

// ---- Closed forms, four at a time

struct Vector4 {
    __m128 x, y, z;
};

RAGGIO_INLINE __m128 dot(const Vector4& a, const Vector4& b) {
    return _mm_add_ps(_mm_add_ps(_mm_mul_ps(a.x, b.x), _mm_mul_ps(a.y, b.y)), _mm_mul_ps(a.z, b.z));
}
RAGGIO_INLINE Vector4 minus(const Vector4& a, const Vector4& b) {
    return {_mm_sub_ps(a.x, b.x), _mm_sub_ps(a.y, b.y), _mm_sub_ps(a.z, b.z)};
}
/// Point `t` along the ray.
RAGGIO_INLINE Vector4 along(const Vector4& origin, const Vector4& direction, __m128 t) {
    return {_mm_add_ps(origin.x, _mm_mul_ps(t, direction.x)), _mm_add_ps(origin.y, _mm_mul_ps(t, direction.y)),
            _mm_add_ps(origin.z, _mm_mul_ps(t, direction.z))};
}
template <int ROWS> RAGGIO_INLINE Vector4 rowsOf(const Block<ROWS>& block, int row) {
    return {_mm_load_ps(block.rows[row]), _mm_load_ps(block.rows[row + 1]), _mm_load_ps(block.rows[row + 2])};
}
/// The first of two distances that is in front of the origin, INFINITE if neither is.
RAGGIO_INLINE __m128 inFront(__m128 near, __m128 far) {
    const __m128 zero = _mm_setzero_ps(), none = _mm_set1_ps(INFINITE);
    return _mm_blendv_ps(_mm_blendv_ps(none, far, _mm_cmplt_ps(zero, far)), near, _mm_cmplt_ps(zero, near));
}

RAGGIO_INLINE __m128 distances(const SphereBlock& block, const Vector4& origin, const Vector4& direction) {
    const __m128 sign = _mm_set1_ps(-0.0f), zero = _mm_setzero_ps();
    Vector4 f = minus(origin, rowsOf(block, 0));
    __m128 radius = _mm_load_ps(block.rows[3]), square = _mm_mul_ps(radius, radius);
    __m128 b = _mm_xor_ps(dot(f, direction), sign);
    Vector4 toLine = along(f, direction, b);
    __m128 discriminant = _mm_sub_ps(square, dot(toLine, toLine));
    __m128 met = _mm_cmpge_ps(discriminant, zero);
    if (!_mm_movemask_ps(met)) return _mm_set1_ps(INFINITE);
    __m128 root = _mm_sqrt_ps(discriminant);
    __m128 q = _mm_blendv_ps(_mm_add_ps(b, root), _mm_sub_ps(b, root), _mm_cmplt_ps(b, zero));
    met = _mm_and_ps(met, _mm_cmpneq_ps(q, zero));
    __m128 other = _mm_div_ps(_mm_sub_ps(dot(f, f), square), q);
    return _mm_blendv_ps(_mm_set1_ps(INFINITE), inFront(_mm_min_ps(other, q), _mm_max_ps(other, q)), met);
}

RAGGIO_INLINE __m128 distances(const RectangleBlock& block, const Vector4& origin, const Vector4& direction) {
    const __m128 zero = _mm_setzero_ps(), none = _mm_set1_ps(INFINITE);
    Vector4 corner = rowsOf(block, 0), normal = rowsOf(block, 9);
    __m128 cosine = dot(normal, direction);
    __m128 t = _mm_div_ps(dot(normal, minus(corner, origin)), cosine);
    __m128 met = _mm_and_ps(_mm_cmpneq_ps(cosine, zero), _mm_and_ps(_mm_cmplt_ps(zero, t), _mm_cmplt_ps(t, none)));
    if (!_mm_movemask_ps(met)) return none;
    Vector4 m = minus(along(origin, direction, t), corner);
    __m128 u = dot(m, rowsOf(block, 3)), v = dot(m, rowsOf(block, 6));
    __m128 inside = _mm_and_ps(_mm_and_ps(_mm_cmpge_ps(u, zero), _mm_cmple_ps(u, _mm_load_ps(block.rows[12]))),
                               _mm_and_ps(_mm_cmpge_ps(v, zero), _mm_cmple_ps(v, _mm_load_ps(block.rows[13]))));
    return _mm_blendv_ps(none, t, _mm_and_ps(met, inside));
}

RAGGIO_INLINE __m128 safeReciprocal(__m128 d) {
    const __m128 tiny = _mm_set1_ps(1e-18f), zero = _mm_setzero_ps();
    __m128 least = _mm_blendv_ps(tiny, _mm_set1_ps(-1e-18f), _mm_cmplt_ps(d, zero));
    return _mm_div_ps(_mm_set1_ps(1.0f), _mm_blendv_ps(d, least, _mm_cmplt_ps(magnitudes(d), tiny)));
}

RAGGIO_INLINE __m128 distances(const BoxBlock& block, const Vector4& origin, const Vector4& direction) {
    const __m128 sign = _mm_set1_ps(-0.0f), none = _mm_set1_ps(INFINITE);
    Vector4 from = minus(origin, rowsOf(block, 0));
    __m128 enter[3], leave[3];
    for (int axis = 0; axis < 3; axis++) {
        Vector4 along = rowsOf(block, 6 + 3 * axis);
        __m128 half = _mm_load_ps(block.rows[3 + axis]), at = dot(from, along), r = safeReciprocal(dot(direction, along));
        __m128 a = _mm_mul_ps(_mm_sub_ps(_mm_xor_ps(half, sign), at), r), b = _mm_mul_ps(_mm_sub_ps(half, at), r);
        enter[axis] = _mm_min_ps(a, b);
        leave[axis] = _mm_max_ps(a, b);
    }
    __m128 near = _mm_max_ps(enter[0], _mm_max_ps(enter[1], enter[2]));
    __m128 far = _mm_min_ps(leave[0], _mm_min_ps(leave[1], leave[2]));
    return _mm_blendv_ps(inFront(near, far), none, _mm_cmpgt_ps(near, far));
}

/// `spanOf` and `intersect` of kernels/shapes/round.slang.
RAGGIO_INLINE __m128 distances(const RoundBlock& block, const Vector4& origin, const Vector4& direction) {
    const __m128 sign = _mm_set1_ps(-0.0f), zero = _mm_setzero_ps(), none = _mm_set1_ps(INFINITE), least = _mm_set1_ps(-INFINITE);
    const __m128 one = _mm_set1_ps(1.0f), tiny = _mm_set1_ps(1e-18f);
    auto negative = [&](__m128 x) { return _mm_xor_ps(x, sign); };
    auto times = [](__m128 x, __m128 y) { return _mm_mul_ps(x, y); };
    auto plus = [](__m128 x, __m128 y) { return _mm_add_ps(x, y); };
    auto less = [](__m128 x, __m128 y) { return _mm_sub_ps(x, y); };
    auto chosen = [](__m128 mask, __m128 yes, __m128 no) { return _mm_blendv_ps(no, yes, mask); };
    Vector4 offset = minus(origin, rowsOf(block, 0));
    Vector4 axisX = rowsOf(block, 3), axisY = rowsOf(block, 6), axisZ = rowsOf(block, 9);
    __m128 radius = _mm_load_ps(block.rows[12]), height = _mm_load_ps(block.rows[13]), slope = _mm_load_ps(block.rows[14]);
    __m128 capped = _mm_cmpneq_ps(_mm_load_ps(block.rows[15]), zero);
    Vector4 from = {dot(offset, axisX), dot(offset, axisY), dot(offset, axisZ)};
    Vector4 d = {dot(direction, axisX), dot(direction, axisY), dot(direction, axisZ)};
    Vector4 fromMiddle = {from.x, from.y, less(from.z, times(_mm_set1_ps(0.5f), height))};
    __m128 toMiddle = negative(dot(fromMiddle, d));
    Vector4 nearby = along(from, d, toMiddle);
    __m128 across2 = plus(times(d.x, d.x), times(d.y, d.y)), reach = plus(height, times(_mm_set1_ps(2.0f), radius));
    __m128 outward = plus(times(d.x, nearby.x), times(d.y, nearby.y));
    __m128 toAxis = _mm_div_ps(negative(outward), _mm_max_ps(across2, _mm_set1_ps(1e-30f)));
    toAxis = _mm_min_ps(_mm_max_ps(toAxis, negative(reach)), reach);
    __m128 shift = plus(toMiddle, toAxis);
    Vector4 o = along(nearby, d, toAxis);

    __m128 width = plus(radius, times(slope, o.z)), growth = times(slope, d.z);
    __m128 growth2 = times(growth, growth);
    __m128 a = less(across2, growth2);
    __m128 b = less(plus(times(d.x, o.x), times(d.y, o.y)), times(growth, width));
    __m128 fromAxis2 = plus(times(o.x, o.x), times(o.y, o.y)), width2 = times(width, width), c = less(fromAxis2, width2);
    __m128 discriminant = less(times(b, b), times(a, c));
    __m128 root = _mm_sqrt_ps(_mm_max_ps(discriminant, zero));
    __m128 ahead = less(root, b), behind = negative(plus(b, root)), isAhead = _mm_cmplt_ps(b, zero);
    __m128 larger = chosen(isAhead, ahead, behind), smaller = chosen(isAhead, behind, ahead);
    __m128 steep = _mm_cmple_ps(a, zero);
    __m128 divisor = chosen(steep, _mm_min_ps(a, _mm_set1_ps(-1e-30f)), a), first = _mm_div_ps(larger, divisor);
    __m128 byProduct = _mm_cmplt_ps(times(magnitudes(a), plus(fromAxis2, width2)), times(larger, larger));
    __m128 second = chosen(byProduct, _mm_div_ps(c, larger), _mm_div_ps(smaller, divisor));
    __m128 low = _mm_min_ps(first, second), high = _mm_max_ps(first, second);
    __m128 grows = _mm_cmplt_ps(zero, growth);
    __m128 enter = chosen(steep, chosen(grows, high, least), low), leave = chosen(steep, chosen(grows, none, low), high);
    __m128 parallel = _mm_cmplt_ps(_mm_max_ps(across2, growth2), _mm_set1_ps(1e-24f));
    __m128 flat = _mm_cmplt_ps(magnitudes(d.z), tiny);
    __m128 misses = _mm_or_ps(
        chosen(parallel, _mm_cmplt_ps(zero, c), _mm_andnot_ps(steep, _mm_cmplt_ps(discriminant, zero))),
        _mm_and_ps(_mm_cmpeq_ps(height, zero), flat));
    enter = chosen(misses, none, chosen(parallel, least, plus(enter, shift)));
    leave = chosen(misses, least, chosen(parallel, none, plus(leave, shift)));

    __m128 smallest = chosen(_mm_cmplt_ps(d.z, zero), negative(tiny), tiny);
    __m128 reciprocal = _mm_div_ps(one, chosen(flat, smallest, d.z));
    __m128 bottom = times(negative(from.z), reciprocal), top = times(less(height, from.z), reciprocal);
    __m128 endsEnter = _mm_min_ps(bottom, top), endsLeave = _mm_max_ps(bottom, top);

    __m128 near = chosen(capped, _mm_max_ps(enter, endsEnter), enter), far = chosen(capped, _mm_min_ps(leave, endsLeave), leave);
    auto meets = [&](__m128 t) {
        __m128 between = _mm_and_ps(_mm_cmpge_ps(t, endsEnter), _mm_cmple_ps(t, endsLeave));
        return _mm_and_ps(_mm_cmple_ps(near, far), _mm_or_ps(capped, between));
    };
    __m128 meetsNear = _mm_and_ps(meets(near), _mm_cmplt_ps(zero, near));
    __m128 meetsFar = _mm_and_ps(meets(far), _mm_cmplt_ps(zero, far));
    return chosen(meetsNear, near, chosen(meetsFar, far, none));
}

template <int ROWS, class Holes>
RAGGIO_INLINE void intersectBlock(
    const Block<ROWS>& block, const float* origin, const float* direction, const Holes& holes, TracedHit& hit)
{
    holes.meetsShapes();
    auto all = [](const float* v) { return Vector4{_mm_set1_ps(v[0]), _mm_set1_ps(v[1]), _mm_set1_ps(v[2])}; };
    __m128 t = distances(block, all(origin), all(direction));
    unsigned met = _mm_movemask_ps(_mm_and_ps(_mm_cmple_ps(t, _mm_set1_ps(hit.distance)), _mm_cmplt_ps(t, _mm_set1_ps(INFINITE))));
    if (!met) return;
    alignas(16) float each[4];
    _mm_store_ps(each, t);
    do {
        unsigned i = __builtin_ctz(met);
        met &= met - 1;
        float distance = each[i];
        uint32_t shape = block.shapes[i];
        if (shape == NOTHING || !hit.isBehind(distance, shape, 0)) continue;
        if (block.holes[i]) {
            distance = holes.firstThere(shape, distance);
            if (!hit.isBehind(distance, shape, 0)) continue;
        }
        hit = {distance, shape, 0, {0, 0}};
    } while (met);
}

// ---- The walk

/// What waits: the bits of the distance at which the ray enters it, over the reference. Distances are not negative, so the
/// numbers are ordered as they are.
typedef uint64_t Waiting;
constexpr unsigned STACK = 8 * 96;

RAGGIO_INLINE uint32_t bitsOf(float x) {
    uint32_t bits;
    memcpy(&bits, &x, 4);
    return bits;
}
RAGGIO_INLINE Waiting waiting(float distance, uint32_t reference) { return Waiting(bitsOf(distance)) << 32 | reference; }

/// Lanes of the children of `node` whose boxes the ray meets before `limit`; `near` is where it enters each.
RAGGIO_INLINE __m256 boxesMet(const char* node, const RaySetup& ray, float limit, __m256& near) {
    auto planes = [&](size_t offset) { return _mm256_load_ps((const float*)(node + offset)); };
    auto all = [](const float& x) { return _mm256_broadcast_ss(&x); };
    __m256 rx = all(ray.reciprocal[0]), ry = all(ray.reciprocal[1]), rz = all(ray.reciprocal[2]);
    __m256 nearX = _mm256_fmadd_ps(planes(ray.offsets[0]), rx, all(ray.near[0]));
    __m256 nearY = _mm256_fmadd_ps(planes(ray.offsets[1]), ry, all(ray.near[1]));
    __m256 nearZ = _mm256_fmadd_ps(planes(ray.offsets[2]), rz, all(ray.near[2]));
    __m256 farX = _mm256_fmadd_ps(planes(ray.offsets[0] ^ 32), rx, all(ray.far[0]));
    __m256 farY = _mm256_fmadd_ps(planes(ray.offsets[1] ^ 32), ry, all(ray.far[1]));
    __m256 farZ = _mm256_fmadd_ps(planes(ray.offsets[2] ^ 32), rz, all(ray.far[2]));
    near = _mm256_max_ps(_mm256_max_ps(nearX, nearY), _mm256_max_ps(nearZ, _mm256_setzero_ps()));
    __m256 far = _mm256_min_ps(_mm256_min_ps(farX, farY), _mm256_min_ps(farZ, _mm256_set1_ps(limit)));
    return _mm256_cmp_ps(near, far, _CMP_LE_OQ);
}

/// The child of `node` that the ray enters first becomes `reference`; the others wait, the nearest on top, or in any order
/// where any hit will do. False if the ray enters none.
template <bool ANY>
RAGGIO_INLINE bool enter(const char* node, const RaySetup& ray, float limit, Waiting*& top, uint32_t& reference)
{
    __m256 near;
    unsigned met = _mm256_movemask_ps(boxesMet(node, ray, limit, near));
    if (!met) return false;

    const uint32_t* children = (const uint32_t*)(node + offsetof(Node, children));
    unsigned i = __builtin_ctz(met);
    met &= met - 1;
    reference = children[i];
    if (!met) return true;
    alignas(32) float distance[8];
    _mm256_store_ps(distance, near);
    unsigned j = __builtin_ctz(met);
    met &= met - 1;
    Waiting a = waiting(distance[i], reference), b = waiting(distance[j], children[j]);
    if (!met) {
        *top++ = a < b ? b : a;
        reference = uint32_t(a < b ? a : b);
        return true;
    }
    Waiting* base = top;
    *top++ = a < b || ANY ? b : a;
    *top++ = a < b || ANY ? a : b;
    do {
        unsigned k = __builtin_ctz(met);
        met &= met - 1;
        Waiting c = waiting(distance[k], children[k]);
        Waiting* place = top++;
        if (!ANY)
            for (; place > base && place[-1] < c; place--) *place = place[-1];
        *place = c;
    } while (met);
    reference = uint32_t(*--top);
    return true;
}

/// What waits on top becomes `reference`, but for what is beyond `limit`. False if nothing is left above `base`.
RAGGIO_INLINE bool next(const Waiting* base, float limit, Waiting*& top, uint32_t& reference) {
    uint32_t bits = bitsOf(limit);
    while (top != base) {
        Waiting last = *--top;
        if (uint32_t(last >> 32) > bits) continue;
        reference = uint32_t(last);
        return true;
    }
    return false;
}

/// Triangles of a leaf.
template <class Holes>
RAGGIO_INLINE void intersectLeaf(
    const TriangleRecord* triangles, uint32_t reference, const InstanceRecord& instance, const RaySetup& ray,
    const Holes& holes, TracedHit& hit)
{
    uint32_t first = instance.firstTriangle + (reference & PLACE);
    unsigned count = ((reference & ~LEAF) >> TRIANGLES_SHIFT) + 1;
    for (;;) {
        intersectTriangles(triangles, first, count < 4 ? count : 4, ray, instance.shape, instance.holes != 0, holes, hit);
        if (count <= 4) return;
        first += 4;
        count -= 4;
    }
}

/// Origin and direction of the ray in the space of the instance's mesh.
RAGGIO_INLINE void intoMesh(const InstanceRecord& instance, const float* o, const float* d, __m128& origin, __m128& direction)
{
    __m128 x = _mm_load_ps(instance.columns[0]), y = _mm_load_ps(instance.columns[1]), z = _mm_load_ps(instance.columns[2]),
           offset = _mm_load_ps(instance.columns[3]);
    auto linear = [&](const float* v) {
        return _mm_add_ps(
            _mm_add_ps(_mm_mul_ps(x, _mm_set1_ps(v[0])), _mm_mul_ps(y, _mm_set1_ps(v[1]))), _mm_mul_ps(z, _mm_set1_ps(v[2])));
    };
    origin = _mm_add_ps(linear(o), offset);
    direction = linear(d);
}

RAGGIO_INLINE __m128 three(const float* v) { return _mm_setr_ps(v[0], v[1], v[2], 0.0f); }

/// Way of one ray through the mesh of an instance, above what waits already.
template <bool ANY, class Holes>
RAGGIO_INLINE void walkMesh(
    const Traversal& all, const InstanceRecord& instance, const RaySetup& ray, const Holes& holes, Waiting* base,
    TracedHit& hit)
{
    const char* nodes = (const char*)(all.meshNodes + instance.firstNode);
    Waiting* top = base;
    uint32_t reference = instance.root;
    do {
        while (!(reference & LEAF)) {
            holes.meetsNode();
            if (!enter<ANY>(nodes + (size_t(reference) << 8), ray, hit.distance, top, reference)) goto waits;
        }
        intersectLeaf(all.triangles, reference, instance, ray, holes, hit);
        if (ANY && hit.found()) return;
    waits:;
    } while (next(base, hit.distance, top, reference));
}

/// Way of one ray through the scene, above a stack of its own.
template <bool ANY, class Holes>
RAGGIO_INLINE void walk(const Traversal& all, const TracedRay& ray, const Holes& holes, TracedHit& hit)
{
    uint32_t reference = uint32_t(all.root);
    RaySetup setup;
    setUp(three(ray.origin), three(ray.direction), setup);
    Waiting stack[STACK];
    Waiting* top = stack;
    do {
        while (!(reference & LEAF)) {
            holes.meetsNode();
            if (!enter<ANY>((const char*)all.nodes + (size_t(reference) << 8), setup, hit.distance, top, reference)) goto waits;
        }
        {
            uint32_t place = reference & PLACE;
            switch ((reference & ~LEAF) >> TRIANGLES_SHIFT) {
            case SPHERES: intersectBlock(all.spheres[place], ray.origin, ray.direction, holes, hit); break;
            case RECTANGLES: intersectBlock(all.rectangles[place], ray.origin, ray.direction, holes, hit); break;
            case BOXES: intersectBlock(all.boxes[place], ray.origin, ray.direction, holes, hit); break;
            case ROUNDS: intersectBlock(all.rounds[place], ray.origin, ray.direction, holes, hit); break;
            default: {
                const InstanceRecord& instance = all.instances[place];
                if (instance.identity) {
                    walkMesh<ANY>(all, instance, setup, holes, top, hit);
                    break;
                }
                __m128 origin, direction;
                intoMesh(instance, ray.origin, ray.direction, origin, direction);
                RaySetup inside;
                setUp(origin, direction, inside);
                walkMesh<ANY>(all, instance, inside, holes, top, hit);
            }
            }
        }
        if (ANY && hit.found()) return;
    waits:;
    } while (next(stack, hit.distance, top, reference));
}

// ---- Several rays in turn
//
// Rays that are on their way together hide one another's waits for memory, and, as far as no branch depends on what a ray
// meets, one another's arithmetic. So they go in two lists: those that are at a node, and those that are at anything else.

/// Ends below what waits in a mesh, and below all that waits.
constexpr uint32_t MESH_ENDS = 0xfffffffeu, RAY_ENDS = 0xffffffffu;

/// The largest numbers first (a bitonic network).
RAGGIO_INLINE __m256i descending(__m256i x) {
    // Bits of each comparison's pattern: the lanes that take the smaller number of each pair.
#define RAGGIO_EXCHANGE(other, smaller) \
    { \
        __m256i y = other; \
        x = _mm256_blend_epi32(_mm256_max_epu32(x, y), _mm256_min_epu32(x, y), smaller); \
    }
    RAGGIO_EXCHANGE(_mm256_shuffle_epi32(x, 0xb1), 0x66)
    RAGGIO_EXCHANGE(_mm256_shuffle_epi32(x, 0x4e), 0x3c)
    RAGGIO_EXCHANGE(_mm256_shuffle_epi32(x, 0xb1), 0x5a)
    RAGGIO_EXCHANGE(_mm256_permute2x128_si256(x, x, 1), 0xf0)
    RAGGIO_EXCHANGE(_mm256_shuffle_epi32(x, 0x4e), 0xcc)
    RAGGIO_EXCHANGE(_mm256_shuffle_epi32(x, 0xb1), 0xaa)
#undef RAGGIO_EXCHANGE
    return x;
}

/// Where a ray is on its way.
struct alignas(64) Way {
    TracedRay ray;
    TracedHit hit;
    RaySetup world;
    RaySetup inside;
    /// That of the hierarchy which the ray is in, and its nodes.
    const RaySetup* setup;
    const char* nodes;
    /// The instance whose mesh that is, or null.
    const InstanceRecord* instance;
    /// Place of the ray among all.
    uint32_t number;
    /// Place of the ray: a node, a leaf or an end.
    uint32_t reference;
    /// Distances at which the ray enters what waits, the nearest on top, and references.
    uint32_t top;
    alignas(32) float distances[STACK + 16];
    alignas(32) uint32_t references[STACK + 16];

    /// Sets out from `ray`.
    RAGGIO_INLINE void begin(const Traversal& all) {
        setUp(three(ray.origin), three(ray.direction), world);
        top = 0;
        push(RAY_ENDS);
        goTo(all);
        reference = uint32_t(all.root);
    }

    /// Goes to the upper hierarchy.
    RAGGIO_INLINE void goTo(const Traversal& all) {
        setup = &world;
        nodes = (const char*)all.nodes;
        instance = nullptr;
    }

    /// Goes to the mesh of an instance, and to its root.
    RAGGIO_INLINE void goTo(const Traversal& all, const InstanceRecord& to) {
        if (!to.identity) {
            __m128 origin, direction;
            intoMesh(to, ray.origin, ray.direction, origin, direction);
            setUp(origin, direction, inside);
            setup = &inside;
        }
        nodes = (const char*)(all.meshNodes + to.firstNode);
        instance = &to;
        push(MESH_ENDS);
        reference = to.root;
    }

    /// Looks into the node, and goes to the nearest of all that waits.
    RAGGIO_INLINE void enter() {
        const char* node = nodes + (size_t(reference) << 8);
        __m256 near;
        __m256 enters = boxesMet(node, *setup, hit.distance, near);
        // Numbers whose order is that of the distances, but for the last three bits, which say the child.
        __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        __m256i keys = _mm256_or_si256(_mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(near)), lanes);
        keys = descending(_mm256_and_si256(keys, _mm256_castps_si256(enters)));
        __m256i children = _mm256_load_si256((const __m256i*)(node + offsetof(Node, children)));
        // All eight are written; behind those that the ray enters is nothing of use.
        _mm256_storeu_ps(distances + top, _mm256_permutevar8x32_ps(near, keys));
        _mm256_storeu_si256((__m256i*)(references + top), _mm256_permutevar8x32_epi32(children, keys));
        top += unsigned(__builtin_popcount(unsigned(_mm256_movemask_ps(enters))));
        next();
    }

    /// Goes to the nearest of all that waits before the hit.
    RAGGIO_INLINE void next() {
        do top--;
        while (distances[top] > hit.distance);
        reference = references[top];
    }

    /// Memory that the next step reads.
    RAGGIO_INLINE const void* reads(const Traversal& all) const {
        if (!(reference & LEAF)) return nodes + (size_t(reference) << 8);
        return instance ? all.triangles + instance->firstTriangle + (reference & PLACE) : nullptr;
    }

private:
    RAGGIO_INLINE void push(uint32_t end) {
        distances[top] = 0;
        references[top++] = end;
    }
};

/// Intersects what the way is at, which is no node, and goes on to where memory is read next. False if the way has ended.
template <class Holes> RAGGIO_INLINE bool stepOver(const Traversal& all, Way& way, const Holes& holes) {
    const TracedRay& ray = way.ray;
    if (way.instance) {
        if (way.reference != MESH_ENDS) {
            intersectLeaf(all.triangles, way.reference, *way.instance, *way.setup, holes, way.hit);
            if (ray.any && way.hit.found()) return false;
            way.next();
            if (way.reference != MESH_ENDS) return true;
        }
        way.goTo(all);
        way.next();
        if (!(way.reference & LEAF)) return true;
    }
    if (way.reference == RAY_ENDS) return false;
    uint32_t place = way.reference & PLACE;
    switch ((way.reference & ~LEAF) >> TRIANGLES_SHIFT) {
    case SPHERES: intersectBlock(all.spheres[place], ray.origin, ray.direction, holes, way.hit); break;
    case RECTANGLES: intersectBlock(all.rectangles[place], ray.origin, ray.direction, holes, way.hit); break;
    case BOXES: intersectBlock(all.boxes[place], ray.origin, ray.direction, holes, way.hit); break;
    case ROUNDS: intersectBlock(all.rounds[place], ray.origin, ray.direction, holes, way.hit); break;
    default: way.goTo(all, all.instances[place]); return true;
    }
    if (ray.any && way.hit.found()) return false;
    way.next();
    return way.reference != RAY_ENDS;
}

/// Number of rays that are traced in turn: as many as hide one another's waits for memory.
constexpr uint32_t IN_TURN = 32;

/// Room for them, one for each thread whatever `Holes` are.
RAGGIO_INLINE Way* roomForWays() {
    static thread_local Way ways[IN_TURN];
    return ways;
}

/// Traces `count` rays, each into its hit. `holesOf` answers for each way.
template <class HolesOf>
RAGGIO_INLINE void walkInTurn(
    const Traversal& all, const TracedRay* rays, TracedHit* hits, uint32_t count, const HolesOf& holesOf)
{
    Way* ways = roomForWays();
    // Both lists have room for one more: each way is written to the ends of both.
    Way *inner[IN_TURN + 1], *others[IN_TURN + 1];
    uint32_t begun = 0, inners = 0, rest = 0;
    auto begin = [&](Way& way) {
        way.number = begun;
        way.ray = rays[begun];
        way.hit = hits[begun++];
        way.begin(all);
    };
    auto list = [&](Way& way) {
        const char* place = (const char*)way.reads(all);
        for (int line = 0; line < 4; line++) _mm_prefetch(place + 64 * line, _MM_HINT_T0);
        uint32_t other = way.reference >> 31;
        inner[inners] = &way;
        others[rest] = &way;
        inners += 1 - other;
        rest += other;
    };
    while (begun < count && begun < IN_TURN) {
        Way& way = ways[begun];
        begin(way);
        list(way);
    }
    // A list is read ahead of where it is written anew.
    while (inners + rest > 0) {
        uint32_t listed = inners;
        inners = 0;
        for (uint32_t i = 0; i < listed; i++) {
            Way& way = *inner[i];
            holesOf(way).meetsNode();
            way.enter();
            list(way);
        }
        listed = rest;
        rest = 0;
        for (uint32_t i = 0; i < listed; i++) {
            Way& way = *others[i];
            if (!stepOver(all, way, holesOf(way))) {
                hits[way.number] = way.hit;
                if (begun == count) continue;
                begin(way);
            }
            list(way);
        }
    }
}

} // namespace raggio
