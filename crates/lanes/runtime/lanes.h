// Vectors of LANES numbers, one for each invocation that runs at once, and what kernels do with them. A function that takes
// vectors has a twin of the same bits for scalars, which are the same in all lanes. Compile with -ffp-contract=off.
#pragma once
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifndef LANES
#error "LANES must be 1, 4, 8 or 16"
#endif

// Instructions of the processor for just as many lanes; without, the compiler makes what it can of the vectors.
#if LANES == 4 && defined(__SSE4_2__)
#define LANES_SSE
#include <immintrin.h>
#elif LANES == 8 && defined(__AVX2__)
#define LANES_AVX2
#include <immintrin.h>
#elif LANES == 16 && defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512BW__) && defined(__AVX512VL__)
#define LANES_AVX512
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

#define LANES_INLINE static inline __attribute__((always_inline))

namespace lanes {

// ---- Scalars

LANES_INLINE float number(uint32_t bits) { float x; memcpy(&x, &bits, 4); return x; }
LANES_INLINE uint32_t cast(float x) { uint32_t bits; memcpy(&bits, &x, 4); return bits; }
LANES_INLINE float cast(uint32_t bits) { return number(bits); }

// A word in memory.
template <class T> LANES_INLINE T word(const char* from, size_t offset) { T x; memcpy(&x, from + offset, sizeof x); return x; }

#define LANES_COMPARISONS(TRUTH, T) \
    LANES_INLINE TRUTH equal(T a, T b) { return a == b; } \
    LANES_INLINE TRUTH not_equal(T a, T b) { return a != b; } \
    LANES_INLINE TRUTH less(T a, T b) { return a < b; } \
    LANES_INLINE TRUTH greater(T a, T b) { return a > b; } \
    LANES_INLINE TRUTH less_equal(T a, T b) { return a <= b; } \
    LANES_INLINE TRUTH greater_equal(T a, T b) { return a >= b; }
LANES_COMPARISONS(bool, float)
LANES_COMPARISONS(bool, uint32_t)
LANES_INLINE bool less_or_greater(float a, float b) { return a < b || a > b; }
LANES_INLINE bool less_signed(uint32_t a, uint32_t b) { return (int32_t)a < (int32_t)b; }
LANES_INLINE bool greater_signed(uint32_t a, uint32_t b) { return (int32_t)a > (int32_t)b; }
LANES_INLINE bool less_equal_signed(uint32_t a, uint32_t b) { return (int32_t)a <= (int32_t)b; }
LANES_INLINE bool greater_equal_signed(uint32_t a, uint32_t b) { return (int32_t)a >= (int32_t)b; }
LANES_INLINE bool is_nan(float x) { return x != x; }
LANES_INLINE bool is_infinite(float x) { return (cast(x) & 0x7fffffffu) == 0x7f800000u; }

LANES_INLINE bool inverse(bool a) { return !a; }
LANES_INLINE bool differ(bool a, bool b) { return a != b; }
LANES_INLINE bool agree(bool a, bool b) { return a == b; }
LANES_INLINE float choose(bool c, float a, float b) { return c ? a : b; }
LANES_INLINE uint32_t choose(bool c, uint32_t a, uint32_t b) { return c ? a : b; }
LANES_INLINE bool choose(bool c, bool a, bool b) { return c ? a : b; }

// The second operand where one is NaN, as in `a < b ? a : b`.
LANES_INLINE float least(float a, float b) { return a < b ? a : b; }
LANES_INLINE float largest(float a, float b) { return a > b ? a : b; }
LANES_INLINE uint32_t least(uint32_t a, uint32_t b) { return a < b ? a : b; }
LANES_INLINE uint32_t largest(uint32_t a, uint32_t b) { return a > b ? a : b; }
LANES_INLINE uint32_t least_signed(uint32_t a, uint32_t b) { return (int32_t)a < (int32_t)b ? a : b; }
LANES_INLINE uint32_t largest_signed(uint32_t a, uint32_t b) { return (int32_t)a > (int32_t)b ? a : b; }

LANES_INLINE float negate(float x) { return -x; }
LANES_INLINE uint32_t negate(uint32_t x) { return 0u - x; }
LANES_INLINE uint32_t complement(uint32_t x) { return ~x; }
LANES_INLINE float absolute(float x) { return __builtin_fabsf(x); }
LANES_INLINE float square_root(float x) { return __builtin_sqrtf(x); }
LANES_INLINE float round_down(float x) { return __builtin_floorf(x); }
LANES_INLINE float round_up(float x) { return __builtin_ceilf(x); }
LANES_INLINE float truncate(float x) { return __builtin_truncf(x); }
LANES_INLINE float round_even(float x) { return __builtin_rintf(x); }

LANES_INLINE uint32_t shift_left(uint32_t a, uint32_t b) { return a << (b & 31); }
LANES_INLINE uint32_t shift_right(uint32_t a, uint32_t b) { return a >> (b & 31); }
LANES_INLINE uint32_t shift_right_signed(uint32_t a, uint32_t b) { return (uint32_t)((int32_t)a >> (b & 31)); }
// Lanes that are not active may divide by anything.
LANES_INLINE uint32_t quotient(uint32_t a, uint32_t b) { return a / (b ? b : 1); }
LANES_INLINE uint32_t remainder(uint32_t a, uint32_t b) { return a % (b ? b : 1); }
LANES_INLINE uint32_t quotient_signed(uint32_t a, uint32_t b)
{
    return b + 1 <= 1 ? (b ? 0u - a : a) : (uint32_t)((int32_t)a / (int32_t)b);
}
LANES_INLINE uint32_t remainder_signed(uint32_t a, uint32_t b)
{
    return b + 1 <= 1 ? 0u : (uint32_t)((int32_t)a % (int32_t)b);
}
LANES_INLINE float remainder(float a, float b) { return fmodf(a, b); }
LANES_INLINE uint32_t count_bits(uint32_t x) { return (uint32_t)__builtin_popcount(x); }
template <class T> LANES_INLINE T swap_bits(T x, int shift, uint32_t low) { return ((x >> shift) & low) | ((x & low) << shift); }
template <class T> LANES_INLINE T reversed_bits(T x)
{
    x = swap_bits(x, 1, 0x55555555u);
    x = swap_bits(x, 2, 0x33333333u);
    x = swap_bits(x, 4, 0x0f0f0f0fu);
    x = swap_bits(x, 8, 0x00ff00ffu);
    return (x >> 16) | (x << 16);
}
LANES_INLINE uint32_t reverse_bits(uint32_t x) { return reversed_bits(x); }

LANES_INLINE float from_signed(uint32_t x) { return (float)(int32_t)x; }
LANES_INLINE float from_unsigned(uint32_t x) { return (float)x; }
LANES_INLINE uint32_t to_signed(float x)
{
#ifdef __SSE2__
    return (uint32_t)_mm_cvttss_si32(_mm_set_ss(x));
#else
    return (uint32_t)(int32_t)x;
#endif
}
LANES_INLINE uint32_t to_unsigned(float x)
{
    bool high = x >= 2147483648.0f;
    return to_signed(high ? x - 2147483648.0f : x) ^ (high ? 0x80000000u : 0u);
}

#define LANES_OF_C(WITH) \
    WITH(exp) WITH(exp2) WITH(log) WITH(log2) WITH(sin) WITH(cos) WITH(tan) WITH(asin) WITH(acos) WITH(atan)
#define LANES_OF_C_TWO(WITH) WITH(pow) WITH(atan2)
#define LANES_SCALAR_OF_C(NAME) LANES_INLINE float c_##NAME(float x) { return NAME##f(x); }
LANES_OF_C(LANES_SCALAR_OF_C)
#define LANES_SCALAR_OF_C_TWO(NAME) LANES_INLINE float c_##NAME(float a, float b) { return NAME##f(a, b); }
LANES_OF_C_TWO(LANES_SCALAR_OF_C_TWO)

// Elements of which every invocation owns one, a column for each word: those of the first lane lie at `base`, and columns are
// `capacity` words apart.
struct Columns { float* base; size_t capacity; };

#if LANES == 1

typedef float Float;
typedef uint32_t Uint;
typedef bool Mask;
static const Mask NONE = false;
static const Mask ALL = true;

LANES_INLINE Float splat(float x) { return x; }
LANES_INLINE Uint splat(uint32_t x) { return x; }
LANES_INLINE Mask splat(bool x) { return x; }
LANES_INLINE uint32_t bits(Mask mask) { return mask; }
LANES_INLINE bool any(Mask mask) { return mask; }
LANES_INLINE Mask without(Mask a, Mask b) { return a && !b; }
LANES_INLINE Float as_float(Float x) { return x; }
LANES_INLINE Float as_float(Uint x) { return number(x); }
LANES_INLINE Float as_float(Mask x) { return number(x ? ~0u : 0u); }
LANES_INLINE Uint as_uint(Float x) { return cast(x); }
LANES_INLINE Mask as_mask(Float x) { return cast(x) != 0; }
LANES_INLINE Float lane(Float x, int) { return x; }
LANES_INLINE Uint lane(Uint x, int) { return x; }
LANES_INLINE void set_lane(Float& x, int, float to) { x = to; }
LANES_INLINE void set_lane(Uint& x, int, uint32_t to) { x = to; }

LANES_INLINE Uint settled(Mask, Uint x) { return x; }
LANES_INLINE bool same(Uint) { return true; }
LANES_INLINE uint32_t first(Uint x) { return x; }
LANES_INLINE Float gather(const char* from, Uint place, uint32_t stride, size_t offset)
{
    return word<float>(from + (size_t)place * stride, offset);
}
LANES_INLINE void rows(const char* from, Uint place, uint32_t stride, size_t offset, Float* row)
{
    memcpy(row, from + (size_t)place * stride + offset, 16);
}

#else

typedef float Float __attribute__((vector_size(4 * LANES)));
typedef uint32_t Uint __attribute__((vector_size(4 * LANES)));
typedef int32_t Int __attribute__((vector_size(4 * LANES)));

LANES_INLINE float lane(Float x, int i) { return x[i]; }
LANES_INLINE uint32_t lane(Uint x, int i) { return x[i]; }
LANES_INLINE void set_lane(Float& x, int i, float to) { x[i] = to; }
LANES_INLINE void set_lane(Uint& x, int i, uint32_t to) { x[i] = to; }

// Numbers of the lanes.
LANES_INLINE Uint numbers() { Uint x; for (int i = 0; i < LANES; i++) x[i] = (uint32_t)i; return x; }

// ---- Masks

#ifdef LANES_AVX512
struct Mask { __mmask16 bits; };
#define LANES_MASK(x) Mask{(__mmask16)(x)}
static const Mask NONE = {0};
static const Mask ALL = {0xffff};
LANES_INLINE Mask operator&(Mask a, Mask b) { return LANES_MASK(a.bits & b.bits); }
LANES_INLINE Mask operator|(Mask a, Mask b) { return LANES_MASK(a.bits | b.bits); }
LANES_INLINE Mask operator^(Mask a, Mask b) { return LANES_MASK(a.bits ^ b.bits); }
LANES_INLINE Mask operator~(Mask a) { return LANES_MASK(~a.bits); }
LANES_INLINE uint32_t bits(Mask mask) { return mask.bits; }
LANES_INLINE Mask splat(bool x) { return LANES_MASK(x ? 0xffff : 0); }
LANES_INLINE Float choose(Mask c, Float a, Float b) { return (Float)_mm512_mask_blend_ps(c.bits, (__m512)b, (__m512)a); }
LANES_INLINE Uint choose(Mask c, Uint a, Uint b) { return (Uint)_mm512_mask_blend_epi32(c.bits, (__m512i)b, (__m512i)a); }
LANES_INLINE Mask choose(Mask c, Mask a, Mask b) { return (c & a) | (~c & b); }
LANES_INLINE Float as_float(Mask x) { return (Float)_mm512_movm_epi32(x.bits); }
LANES_INLINE Mask as_mask(Float x) { return LANES_MASK(_mm512_movepi32_mask((__m512i)x)); }
#define LANES_COMPARISON(NAME, FLOAT, INT) \
    LANES_INLINE Mask NAME(Float a, Float b) { return LANES_MASK(_mm512_cmp_ps_mask((__m512)a, (__m512)b, FLOAT)); } \
    LANES_INLINE Mask NAME(Uint a, Uint b) { return LANES_MASK(_mm512_cmp_epu32_mask((__m512i)a, (__m512i)b, INT)); } \
    LANES_INLINE Mask NAME##_signed(Uint a, Uint b) { return LANES_MASK(_mm512_cmp_epi32_mask((__m512i)a, (__m512i)b, INT)); }
LANES_COMPARISON(equal, _CMP_EQ_OQ, _MM_CMPINT_EQ)
LANES_COMPARISON(not_equal, _CMP_NEQ_UQ, _MM_CMPINT_NE)
LANES_COMPARISON(less, _CMP_LT_OQ, _MM_CMPINT_LT)
LANES_COMPARISON(greater, _CMP_GT_OQ, _MM_CMPINT_NLE)
LANES_COMPARISON(less_equal, _CMP_LE_OQ, _MM_CMPINT_LE)
LANES_COMPARISON(greater_equal, _CMP_GE_OQ, _MM_CMPINT_NLT)
#else
typedef Int Mask;
#define NONE (Mask{})
#define ALL (~Mask{})
LANES_INLINE Mask splat(bool x) { return Mask{} - (int32_t)x; }
#if defined(LANES_AVX2)
LANES_INLINE uint32_t bits(Mask mask) { return (uint32_t)_mm256_movemask_ps((__m256)mask); }
LANES_INLINE Float choose(Mask c, Float a, Float b) { return (Float)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)c); }
LANES_INLINE Mask choose(Mask c, Mask a, Mask b) { return (Mask)choose(c, (Float)a, (Float)b); }
#elif defined(LANES_SSE)
LANES_INLINE uint32_t bits(Mask mask) { return (uint32_t)_mm_movemask_ps((__m128)mask); }
LANES_INLINE Float choose(Mask c, Float a, Float b) { return (Float)_mm_blendv_ps((__m128)b, (__m128)a, (__m128)c); }
LANES_INLINE Mask choose(Mask c, Mask a, Mask b) { return (Mask)choose(c, (Float)a, (Float)b); }
#else
LANES_INLINE uint32_t bits(Mask mask) { uint32_t b = 0; for (int i = 0; i < LANES; i++) b |= (mask[i] & 1u) << i; return b; }
LANES_INLINE Mask choose(Mask c, Mask a, Mask b) { return (c & a) | (~c & b); }
LANES_INLINE Float choose(Mask c, Float a, Float b) { return (Float)choose(c, (Mask)a, (Mask)b); }
#endif
LANES_INLINE Uint choose(Mask c, Uint a, Uint b) { return (Uint)choose(c, (Float)a, (Float)b); }
LANES_INLINE Float as_float(Mask x) { return (Float)x; }
LANES_INLINE Mask as_mask(Float x) { return (Mask)x; }
LANES_COMPARISONS(Mask, Float)
LANES_COMPARISONS(Mask, Uint)
LANES_INLINE Mask less_signed(Uint a, Uint b) { return (Int)a < (Int)b; }
LANES_INLINE Mask greater_signed(Uint a, Uint b) { return (Int)a > (Int)b; }
LANES_INLINE Mask less_equal_signed(Uint a, Uint b) { return (Int)a <= (Int)b; }
LANES_INLINE Mask greater_equal_signed(Uint a, Uint b) { return (Int)a >= (Int)b; }
#endif

LANES_INLINE bool any(Mask mask) { return bits(mask) != 0; }
LANES_INLINE Mask without(Mask a, Mask b) { return ~b & a; }
LANES_INLINE Mask inverse(Mask a) { return ~a; }
LANES_INLINE Mask differ(Mask a, Mask b) { return a ^ b; }
LANES_INLINE Mask agree(Mask a, Mask b) { return ~(a ^ b); }
LANES_INLINE Mask less_or_greater(Float a, Float b) { return less(a, b) | greater(a, b); }
LANES_INLINE Mask is_nan(Float x) { return not_equal(x, x); }

// ---- Words

LANES_INLINE Float as_float(Float x) { return x; }
LANES_INLINE Float as_float(Uint x) { return (Float)x; }
LANES_INLINE Uint as_uint(Float x) { return (Uint)x; }
LANES_INLINE Uint cast(Float x) { return (Uint)x; }
LANES_INLINE Float cast(Uint x) { return (Float)x; }

#define LANES_EACH(T, NAME) LANES_INLINE T NAME(T x) { T r; for (int i = 0; i < LANES; i++) r[i] = NAME(x[i]); return r; }
#define LANES_EACH_TWO(T, NAME) \
    LANES_INLINE T NAME(T a, T b) { T r; for (int i = 0; i < LANES; i++) r[i] = NAME(a[i], b[i]); return r; }

#if defined(LANES_AVX512)
#define LANES_(NAME) _mm512_##NAME
#define LANES_PS __m512
#define LANES_SI __m512i
#define LANES_ROUND(x, mode) _mm512_roundscale_ps(x, mode)
#define LANES_REPEAT(x) _mm512_broadcast_i32x4(x)
#elif defined(LANES_AVX2)
#define LANES_(NAME) _mm256_##NAME
#define LANES_PS __m256
#define LANES_SI __m256i
#define LANES_ROUND(x, mode) _mm256_round_ps(x, mode)
#define LANES_REPEAT(x) _mm256_broadcastsi128_si256(x)
#elif defined(LANES_SSE)
#define LANES_(NAME) _mm_##NAME
#define LANES_PS __m128
#define LANES_SI __m128i
#define LANES_ROUND(x, mode) _mm_round_ps(x, mode)
#define LANES_REPEAT(x) (x)
#endif

#ifdef LANES_
LANES_INLINE Float splat(float x) { return (Float)LANES_(set1_ps)(x); }
LANES_INLINE Uint splat(uint32_t x) { return (Uint)LANES_(set1_epi32)((int)x); }
LANES_INLINE Float least(Float a, Float b) { return (Float)LANES_(min_ps)((LANES_PS)a, (LANES_PS)b); }
LANES_INLINE Float largest(Float a, Float b) { return (Float)LANES_(max_ps)((LANES_PS)a, (LANES_PS)b); }
LANES_INLINE Uint least(Uint a, Uint b) { return (Uint)LANES_(min_epu32)((LANES_SI)a, (LANES_SI)b); }
LANES_INLINE Uint largest(Uint a, Uint b) { return (Uint)LANES_(max_epu32)((LANES_SI)a, (LANES_SI)b); }
LANES_INLINE Uint least_signed(Uint a, Uint b) { return (Uint)LANES_(min_epi32)((LANES_SI)a, (LANES_SI)b); }
LANES_INLINE Uint largest_signed(Uint a, Uint b) { return (Uint)LANES_(max_epi32)((LANES_SI)a, (LANES_SI)b); }
LANES_INLINE Float square_root(Float x) { return (Float)LANES_(sqrt_ps)((LANES_PS)x); }
LANES_INLINE Float round_down(Float x) { return (Float)LANES_ROUND((LANES_PS)x, 9); }
LANES_INLINE Float round_up(Float x) { return (Float)LANES_ROUND((LANES_PS)x, 10); }
LANES_INLINE Float truncate(Float x) { return (Float)LANES_ROUND((LANES_PS)x, 11); }
LANES_INLINE Float round_even(Float x) { return (Float)LANES_ROUND((LANES_PS)x, 8); }
LANES_INLINE Uint to_signed(Float x) { return (Uint)LANES_(cvttps_epi32)((LANES_PS)x); }
#else
LANES_INLINE Float splat(float x) { return x - Float{}; }
LANES_INLINE Uint splat(uint32_t x) { return x + Uint{}; }
LANES_INLINE Float least(Float a, Float b) { return choose(less(a, b), a, b); }
LANES_INLINE Float largest(Float a, Float b) { return choose(greater(a, b), a, b); }
LANES_INLINE Uint least(Uint a, Uint b) { return choose(less(a, b), a, b); }
LANES_INLINE Uint largest(Uint a, Uint b) { return choose(greater(a, b), a, b); }
LANES_INLINE Uint least_signed(Uint a, Uint b) { return choose(less_signed(a, b), a, b); }
LANES_INLINE Uint largest_signed(Uint a, Uint b) { return choose(greater_signed(a, b), a, b); }
LANES_EACH(Float, square_root)
LANES_EACH(Float, round_down)
LANES_EACH(Float, round_up)
LANES_EACH(Float, truncate)
LANES_EACH(Float, round_even)
LANES_INLINE Uint to_signed(Float x) { Uint r; for (int i = 0; i < LANES; i++) r[i] = to_signed(x[i]); return r; }
#endif

LANES_INLINE Mask is_infinite(Float x) { return equal((Uint)x & 0x7fffffffu, splat(0x7f800000u)); }
LANES_INLINE Float negate(Float x) { return (Float)((Uint)x ^ 0x80000000u); }
LANES_INLINE Uint negate(Uint x) { return 0u - x; }
LANES_INLINE Uint complement(Uint x) { return ~x; }
LANES_INLINE Float absolute(Float x) { return (Float)((Uint)x & 0x7fffffffu); }
LANES_INLINE Uint shift_left(Uint a, Uint b) { return a << (b & 31u); }
LANES_INLINE Uint shift_right(Uint a, Uint b) { return a >> (b & 31u); }
LANES_INLINE Uint shift_right_signed(Uint a, Uint b) { return (Uint)((Int)a >> (Int)(b & 31u)); }
LANES_EACH_TWO(Uint, quotient)
LANES_EACH_TWO(Uint, remainder)
LANES_EACH_TWO(Uint, quotient_signed)
LANES_EACH_TWO(Uint, remainder_signed)
LANES_EACH_TWO(Float, remainder)
LANES_EACH(Uint, count_bits)
LANES_INLINE Float from_signed(Uint x) { return __builtin_convertvector((Int)x, Float); }
LANES_INLINE Float from_unsigned(Uint x) { return __builtin_convertvector(x, Float); }
LANES_INLINE Uint to_unsigned(Float x)
{
    Mask high = greater_equal(x, splat(2147483648.0f));
    return to_signed(choose(high, x - 2147483648.0f, x)) ^ choose(high, splat(0x80000000u), splat(0u));
}
#define LANES_VECTOR_OF_C(NAME) LANES_EACH(Float, c_##NAME)
LANES_OF_C(LANES_VECTOR_OF_C)
#define LANES_VECTOR_OF_C_TWO(NAME) LANES_EACH_TWO(Float, c_##NAME)
LANES_OF_C_TWO(LANES_VECTOR_OF_C_TWO)

// ---- Memory

LANES_INLINE uint32_t first(Uint x) { return x[0]; }

#if defined(LANES_AVX512)
LANES_INLINE Uint broadcast(Uint x, int from) { return (Uint)_mm512_permutexvar_epi32(_mm512_set1_epi32(from), (__m512i)x); }
#elif defined(LANES_AVX2)
LANES_INLINE Uint broadcast(Uint x, int from) { return (Uint)_mm256_permutevar8x32_epi32((__m256i)x, _mm256_set1_epi32(from)); }
#else
LANES_INLINE Uint broadcast(Uint x, int from) { return splat((uint32_t)x[from]); }
#endif

// Places as they are in active lanes; in others the first active lane's.
LANES_INLINE Uint settled(Mask mask, Uint place)
{
    return choose(mask, place, broadcast(place, __builtin_ctz(bits(mask) | 1u << LANES) & (LANES - 1)));
}
LANES_INLINE bool same(Uint place) { return !any(not_equal(place, broadcast(place, 0))); }

// The word at `offset` of each lane's element.
LANES_INLINE Float gather(const char* from, Uint place, uint32_t stride, size_t offset)
{
    from += offset;
#if defined(LANES_AVX512)
    return (Float)_mm512_i32gather_ps((__m512i)(place * (stride / 4)), (const float*)from, 4);
#elif defined(LANES_AVX2)
    return (Float)_mm256_i32gather_ps((const float*)from, (__m256i)(place * (stride / 4)), 4);
#else
    Float r;
    for (int i = 0; i < LANES; i++) r[i] = word<float>(from, (size_t)place[i] * stride);
    return r;
#endif
}

// Four words at `offset` of each lane's element.
LANES_INLINE void rows(const char* from, Uint place, uint32_t stride, size_t offset, Float* row)
{
    from += offset;
#ifdef LANES_
    // By memory: moving lanes one by one into other registers is slower.
    alignas(64) uint32_t at[LANES];
    memcpy(at, &place, sizeof at);
#define LANES_AT(i) _mm_loadu_ps((const float*)(from + (size_t)at[i] * stride))
#if defined(LANES_AVX512)
#define LANES_ROW(i) _mm512_insertf32x4(_mm512_insertf32x4(_mm512_insertf32x4( \
    _mm512_castps128_ps512(LANES_AT(i)), LANES_AT(i + 4), 1), LANES_AT(i + 8), 2), LANES_AT(i + 12), 3)
#elif defined(LANES_AVX2)
#define LANES_ROW(i) _mm256_insertf128_ps(_mm256_castps128_ps256(LANES_AT(i)), LANES_AT(i + 4), 1)
#else
#define LANES_ROW(i) LANES_AT(i)
#endif
    LANES_PS a = LANES_ROW(0), b = LANES_ROW(1), c = LANES_ROW(2), d = LANES_ROW(3);
#undef LANES_ROW
#undef LANES_AT
    LANES_PS ab = LANES_(unpacklo_ps)(a, b), cd = LANES_(unpacklo_ps)(c, d);
    row[0] = (Float)LANES_(shuffle_ps)(ab, cd, 0x44);
    row[1] = (Float)LANES_(shuffle_ps)(ab, cd, 0xee);
    ab = LANES_(unpackhi_ps)(a, b), cd = LANES_(unpackhi_ps)(c, d);
    row[2] = (Float)LANES_(shuffle_ps)(ab, cd, 0x44);
    row[3] = (Float)LANES_(shuffle_ps)(ab, cd, 0xee);
#else
    for (int i = 0; i < LANES; i++) {
        float words[4];
        memcpy(words, from + (size_t)place[i] * stride, 16);
        for (int k = 0; k < 4; k++) row[k][i] = words[k];
    }
#endif
}

LANES_INLINE Uint reverse_bits(Uint x)
{
#ifdef LANES_
    // Bytes from last to first, then both halves of each by a table.
    LANES_SI bytes = LANES_REPEAT(_mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
    LANES_SI halves = LANES_REPEAT(_mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15));
    LANES_SI low = LANES_(set1_epi8)(15);
    LANES_SI swapped = LANES_(shuffle_epi8)((LANES_SI)x, bytes);
    Uint lower = (Uint)swapped & (Uint)low, upper = ((Uint)swapped >> 4) & (Uint)low;
    return ((Uint)LANES_(shuffle_epi8)(halves, (LANES_SI)lower) << 4) | (Uint)LANES_(shuffle_epi8)(halves, (LANES_SI)upper);
#else
    return reversed_bits(x);
#endif
}

#endif

// ---- Memory that lanes do not share

// Calls `with` with the number of each active lane.
template <class With> LANES_INLINE void each_lane(Mask mask, With with)
{
    for (uint32_t left = bits(mask); left; left &= left - 1) with(__builtin_ctz(left));
}

// Puts a word into each active lane's element; the last one remains where they are the same.
LANES_INLINE void scatter(char* to, Mask mask, Uint place, uint32_t stride, size_t offset, Float value)
{
    each_lane(mask, [&](int i) {
        float x = lane(value, i);
        memcpy(to + (size_t)lane(place, i) * stride + offset, &x, 4);
    });
}

// A word of an array. Words that were never written are handed over by their place: compilers may take a call with such a
// value for one that cannot happen.
LANES_INLINE Float own_word(const Float* array, uint32_t word) { return array[word]; }
LANES_INLINE void set_own_word(Float* array, Mask mask, uint32_t word, Float value)
{
    array[word] = choose(mask, value, array[word]);
}
// The word of an array that each lane's index chooses.
LANES_INLINE Float own_word(const Float* array, Mask mask, Uint place, uint32_t stride, uint32_t word)
{
#if LANES == 1
    (void)mask;
    return array[place * stride + word];
#else
    Uint at = (choose(mask, place, splat(0u)) * stride + word) * LANES + numbers();
    return gather((const char*)array, at, 4, 0);
#endif
}
LANES_INLINE void set_own_word(Float* array, Mask mask, Uint place, uint32_t stride, uint32_t word, Float value)
{
    each_lane(mask, [&](int i) { set_lane(array[lane(place, i) * stride + word], i, lane(value, i)); });
}

// A column of the lanes' own elements.
template <class C> LANES_INLINE Float column(const C& columns, uint32_t number)
{
    Float x;
    memcpy(&x, columns.base + number * columns.capacity, sizeof x);
    return x;
}
template <class C> LANES_INLINE void set_column(const C& columns, Mask mask, uint32_t number, Float value)
{
    float* to = columns.base + number * columns.capacity;
#ifdef LANES_AVX512
    _mm512_mask_storeu_ps(to, mask.bits, (__m512)value);
#else
    Float old;
    memcpy(&old, to, sizeof old);
    value = choose(mask, value, old);
    memcpy(to, &value, sizeof value);
#endif
}
// The word of its own element that each lane's index chooses.
template <class C> LANES_INLINE Float own_words(const C& columns, Mask mask, Uint place, uint32_t stride, uint32_t first)
{
    Float x = splat(0.0f);
    each_lane(mask, [&](int i) { set_lane(x, i, columns.base[(first + lane(place, i) * stride) * columns.capacity + i]); });
    return x;
}
template <class C>
LANES_INLINE void set_own_words(const C& columns, Mask mask, Uint place, uint32_t stride, uint32_t first, Float value)
{
    each_lane(mask, [&](int i) { columns.base[(first + lane(place, i) * stride) * columns.capacity + i] = lane(value, i); });
}

}
