// Building blocks of kernels. A file of kernels is compiled once per instruction set, and the best
// one is chosen at run time. It includes this file after hwy/highway.h.

#if defined(ALTIRO3D_KERNEL_PARTS_INL_HPP) == defined(HWY_TARGET_TOGGLE) // NOLINT
#ifdef ALTIRO3D_KERNEL_PARTS_INL_HPP
#undef ALTIRO3D_KERNEL_PARTS_INL_HPP
#else
#define ALTIRO3D_KERNEL_PARTS_INL_HPP
#endif

#include <cstdint>
#include <hwy/highway.h>

// AVX-512 or a later set of x86. Highway gives better sets lower numbers.
#define ALTIRO3D_AVX512 (HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3)
// The same with look-ups of bytes in a whole register.
#define ALTIRO3D_AVX512_BYTES (HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3_DL)

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

// The four bytes at base + offset, for each lane of `offsets` (in bytes, any alignment).
//
// A gather of x86 depends on the old content of its destination register, so each iteration of a
// loop would wait for the previous one. A masked gather over zeros breaks this dependency. The
// compiler must not be able to prove that the mask is all true, or it removes the zeros.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V gatherBytes4([[maybe_unused]] D d, const void* base, V offsets) {
#if ALTIRO3D_AVX512
    const auto all = hn::Ne(offsets, hn::Set(d, INT32_MIN));
    return V{_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), all.raw, offsets.raw, base, 1)};
#elif HWY_TARGET == HWY_AVX2
    const __m256i all = _mm256_cmpgt_epi32(offsets.raw, _mm256_set1_epi32(INT32_MIN));
    return V{_mm256_mask_i32gather_epi32(_mm256_setzero_si256(), static_cast<const int*>(base),
                                         offsets.raw, all, 1)};
#elif HWY_TARGET == HWY_WASM // Highway 1.0.3 goes through memory
    const auto* const from = static_cast<const char*>(base);
    auto found = wasm_v128_load32_zero(from + wasm_i32x4_extract_lane(offsets.raw, 0));
    found = wasm_v128_load32_lane(from + wasm_i32x4_extract_lane(offsets.raw, 1), found, 1);
    found = wasm_v128_load32_lane(from + wasm_i32x4_extract_lane(offsets.raw, 2), found, 2);
    found = wasm_v128_load32_lane(from + wasm_i32x4_extract_lane(offsets.raw, 3), found, 3);
    return V{found};
#else
    return hn::GatherOffset(d, static_cast<const std::int32_t*>(base), offsets);
#endif
}

// The entries of a table of floats, for each lane of `indices`.
template <class D, class I = hn::Vec<hn::RebindToSigned<D>>>
HWY_INLINE hn::Vec<D> gatherFloats(D d, const float* table, I indices) {
    const hn::RebindToSigned<D> whole;
    return hn::BitCast(d, gatherBytes4(whole, table, hn::ShiftLeft<2>(indices)));
}

// The lanes of `values` with the numbers `indices`.
template <class D, class V = hn::Vec<D>, class I = hn::Vec<hn::RebindToSigned<D>>>
HWY_INLINE V lanesAt(D d, V values, I indices) {
#if HWY_TARGET == HWY_WASM // a loop in Highway 1.0.3
    const hn::RebindToSigned<D> whole;
    const I bytes = hn::Add(hn::Mul(indices, hn::Set(whole, 0x04040404)),
                            hn::Set(whole, 0x03020100)); // the four bytes of each lane
    return hn::BitCast(d, I{wasm_i8x16_swizzle(hn::BitCast(whole, values).raw, bytes.raw)});
#else
    return hn::TableLookupLanes(values, hn::IndicesFromVec(d, indices));
#endif
}

// Squared difference of the upper 16 bits plus that of the lower 16 bits, in each 32-bit lane.
template <class D, class I = hn::Vec<D>>
HWY_INLINE I squaresOfPair([[maybe_unused]] D d, I a, I b) {
#if ALTIRO3D_AVX512
    const __m512i both = _mm512_sub_epi16(a.raw, b.raw);
    return I{_mm512_madd_epi16(both, both)};
#elif HWY_TARGET == HWY_AVX2
    const __m256i both = _mm256_sub_epi16(a.raw, b.raw);
    return I{_mm256_madd_epi16(both, both)};
#elif HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
    const __m128i both = _mm_sub_epi16(a.raw, b.raw);
    return I{_mm_madd_epi16(both, both)};
#else
    const I bits = hn::Set(d, 0xFFFF);
    const I low = hn::Sub(hn::And(a, bits), hn::And(b, bits));
    const I high = hn::Sub(hn::ShiftRight<16>(a), hn::ShiftRight<16>(b));
    return hn::Add(hn::Mul(low, low), hn::Mul(high, high));
#endif
}

#if HWY_TARGET == HWY_AVX2
// For each mask of eight lanes, the numbers of its true lanes, four bits each.
struct LaneOrders {
    std::uint32_t ofMask[256];
};
constexpr LaneOrders laneOrders() {
    LaneOrders result{};
    for (std::uint32_t mask = 0; mask < 256; ++mask) {
        int count = 0;
        for (std::uint32_t lane = 0; lane < 8; ++lane) {
            if ((mask >> lane & 1) != 0) result.ofMask[mask] |= lane << (4 * count++);
        }
    }
    return result;
}
constexpr LaneOrders kLaneOrders = laneOrders();
#endif

// Writes the lanes of vectors that a mask chooses, one behind the other. With AVX2, hn::Compress()
// copies its table to the stack each time.
template <class D, class V = hn::Vec<D>>
class ChosenLanes {
  public:
    HWY_INLINE ChosenLanes(D d, hn::Mask<D> mask) : d_(d), mask_(mask) {
#if HWY_TARGET == HWY_AVX2
        const auto bits = static_cast<std::uint32_t>(
            _mm256_movemask_ps(_mm256_castsi256_ps(hn::VecFromMask(d, mask).raw)));
        count_ = hwy::PopCount(bits);
        const auto orders = hn::Set(d, static_cast<std::int32_t>(kLaneOrders.ofMask[bits]));
        order_ = V{_mm256_srlv_epi32(orders.raw, _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28))};
#else
        count_ = hn::CountTrue(d, mask);
#endif
    }

    HWY_INLINE std::size_t count() const {
        return count_;
    }

    // Writes a whole vector; the lanes behind the chosen ones are undefined.
    HWY_INLINE void store(hn::Vec<hn::Rebind<float, D>> values, float* to) const {
        store(hn::BitCast(d_, values), reinterpret_cast<std::int32_t*>(to));
    }
    HWY_INLINE void store(V values, std::int32_t* to) const {
#if HWY_TARGET == HWY_AVX2
        hn::StoreU(V{_mm256_permutevar8x32_epi32(values.raw, order_.raw)}, d_, to);
#else
        hn::StoreU(hn::Compress(values, mask_), d_, to);
#endif
    }

  private:
    D d_;
    hn::Mask<D> mask_;
    std::size_t count_ = 0;
#if HWY_TARGET == HWY_AVX2
    V order_ = hn::Zero(D());
#endif
};

// Rounds -2^22..2^22 to the nearest whole number (halves to even), without the handling of larger
// values in hn::NearestInt.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> smallNearestInt(D d, V value) {
    const hn::RebindToSigned<D> whole;
    const V magic = hn::Set(d, 0x1.8p23F); // floats beyond have no fraction
    return hn::Sub(hn::BitCast(whole, hn::Add(value, magic)), hn::BitCast(whole, magic));
}

#if HWY_TARGET != HWY_SCALAR
// Packs two vectors of 32-bit lanes into one of 16-bit lanes, in order, with saturation.
class OrderedPack {
    using Narrow = hn::ScalableTag<std::int16_t>;
    using Whole = hn::ScalableTag<std::int32_t>;

  public:
    HWY_INLINE OrderedPack() {
        // ReorderDemote2To() packs each 128-bit block separately.
        HWY_ALIGN std::int32_t order[HWY_LANES(std::int32_t)];
        const std::size_t half = hn::Lanes(Whole()) / 2;
        for (std::size_t i = 0; i < half; ++i) {
            order[i] = static_cast<std::int32_t>(i / 2 * 4 + i % 2);
            order[half + i] = order[i] + 2;
        }
        order_ = hn::Load(Whole(), order);
    }

    HWY_INLINE hn::Vec<Narrow> operator()(hn::Vec<Whole> low, hn::Vec<Whole> high) const {
        const Narrow narrow;
        const Whole whole;
        const auto packed = hn::ReorderDemote2To(narrow, low, high);
        if (HWY_LANES(std::int32_t) == 4) return packed;
        return hn::BitCast(narrow, hn::TableLookupLanes(hn::BitCast(whole, packed),
                                                        hn::IndicesFromVec(whole, order_)));
    }

  private:
    hn::Vec<Whole> order_ = hn::Zero(Whole());
};

// 16 kTables neighbouring bytes in registers.
template <int kTables>
class ByteWindow {
    using Narrow = hn::ScalableTag<std::int16_t>;
    using Bytes = hn::ScalableTag<std::uint8_t>;

  public:
    // Reads 64 bytes, of which the last ones may be undefined.
    HWY_INLINE explicit ByteWindow(const std::uint8_t* from) {
#if ALTIRO3D_AVX512_BYTES
        tables_[0] = hn::LoadU(Bytes(), from);
#else
        for (int k = 0; k < kTables; ++k)
            tables_[k] = hn::LoadDup128(Bytes(), from + 16 * k);
#endif
    }

    // The bytes at `places`. @param places 0..16 kTables - 1; others give undefined bytes
    HWY_INLINE hn::Vec<Bytes> at(hn::Vec<Bytes> places) const {
#if ALTIRO3D_AVX512_BYTES
        return hn::Vec<Bytes>{_mm512_permutexvar_epi8(places.raw, tables_[0].raw)};
#else
        auto found = lookUp(tables_[0], kTables > 1 ? inTable(places) : places);
        for (int k = 1; k < kTables; ++k) {
            places = hn::Sub(places, hn::Set(Bytes(), 16));
            found = hn::Or(found, lookUp(tables_[k], k + 1 < kTables ? inTable(places) : places));
        }
        return found;
#endif
    }

    // The bytes `index` and index + 1, in the lower and the upper half of each lane.
    // @param index 0..16 kTables - 2; others give undefined bytes
    HWY_INLINE hn::Vec<Narrow> pairs(hn::Vec<Narrow> index) const {
        const Narrow narrow;
        const auto both = hn::Add(hn::Or(index, hn::ShiftLeft<8>(index)), hn::Set(narrow, 0x100));
        return hn::BitCast(narrow, at(hn::BitCast(Bytes(), both)));
    }

  private:
    static HWY_INLINE hn::Vec<Bytes> lookUp(hn::Vec<Bytes> table, hn::Vec<Bytes> places) {
#if HWY_TARGET == HWY_WASM // a loop in Highway 1.0.3
        return hn::Vec<Bytes>{wasm_i8x16_swizzle(table.raw, places.raw)};
#else
        return hn::TableLookupBytesOr0(table, places);
#endif
    }

    // Indices of a 16-byte table that give 0 for later tables. Highway promises 0 from 128 on.
    static HWY_INLINE hn::Vec<Bytes> inTable(hn::Vec<Bytes> places) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSSE3 // the lower four bits of an index below 128 count
        return hn::SaturatedAdd(places, hn::Set(Bytes(), 0x70));
#elif HWY_ARCH_ARM || HWY_ARCH_WASM // any index from 16 on gives 0
        return places;
#else
        return hn::Or(places, hn::VecFromMask(Bytes(), hn::Gt(places, hn::Set(Bytes(), 15))));
#endif
    }

    hn::Vec<Bytes> tables_[ALTIRO3D_AVX512_BYTES ? 1 : kTables];
};

// lower byte * (2^kBits - part) + upper byte * part, for each lane of `pairs`.
// @param part 0..2^kBits, kBits at most 6
template <int kBits, class V>
HWY_INLINE V mixPairs(V pairs, V part) {
    const hn::ScalableTag<std::int16_t> d;
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSSE3 // the better set, the lower the number
    const auto weights =
        hn::Add(hn::Sub(hn::ShiftLeft<8>(part), part), hn::Set(d, std::int16_t{1} << kBits));
#if ALTIRO3D_AVX512
    return V{_mm512_maddubs_epi16(pairs.raw, weights.raw)};
#elif HWY_TARGET == HWY_AVX2
    return V{_mm256_maddubs_epi16(pairs.raw, weights.raw)};
#else
    return V{_mm_maddubs_epi16(pairs.raw, weights.raw)};
#endif
#else
    const auto lower = hn::And(pairs, hn::Set(d, 255));
    const hn::RebindToUnsigned<decltype(d)> bits;
    const auto upper = hn::BitCast(d, hn::ShiftRight<8>(hn::BitCast(bits, pairs)));
    return hn::Add(hn::ShiftLeft<kBits>(lower), hn::Mul(hn::Sub(upper, lower), part));
#endif
}
#endif

// Stores the lowest byte of each lane.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void storeBytes(D d, V values, std::uint8_t* to) {
#if ALTIRO3D_AVX512 // hn::TruncateTo() of Highway 1.0.3 is wrong for AVX3_DL
    static_cast<void>(d);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm512_cvtepi32_epi8(values.raw));
#else
    const hn::RebindToUnsigned<D> bits;
    const hn::Rebind<std::uint8_t, D> narrow;
    static_cast<void>(d);
    hn::StoreU(hn::TruncateTo(narrow, hn::BitCast(bits, values)), narrow, to);
#endif
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#endif
