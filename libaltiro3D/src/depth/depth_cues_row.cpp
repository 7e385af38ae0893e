#include "depth/depth_cues_row.hpp"

// This file is compiled once per instruction set; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "depth/depth_cues_row.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::ScalableTag<double>;
using Double = hn::Vec<Doubles>;
using HalfFloats = hn::Rebind<float, Doubles>;
using HalfWholes = hn::Rebind<std::int32_t, Doubles>;
using HalfBytes = hn::Rebind<std::uint8_t, Doubles>;
using Floats = hn::ScalableTag<float>;
using Wholes = hn::RebindToSigned<Floats>;
using Bytes = hn::Rebind<std::uint8_t, Wholes>;

HWY_INLINE Double ofFloats(const float* values) {
    return hn::PromoteTo(Doubles(), hn::LoadU(HalfFloats(), values));
}

HWY_INLINE Double ofWholes(const std::int32_t* values) {
    return hn::PromoteTo(Doubles(), hn::LoadU(HalfWholes(), values));
}

HWY_INLINE Double ofBytes(const std::uint8_t* values) {
    const HalfWholes whole;
    return hn::PromoteTo(Doubles(), hn::PromoteTo(whole, hn::LoadU(HalfBytes(), values)));
}

// Reads 24 bytes per px and writes 2.
void colourStepsOn(const RowOf3<float>& a, const RowOf3<float>& b, std::size_t count,
                   std::uint16_t* HWY_RESTRICT steps) {
    const Floats d;
    const Wholes whole;
    const hn::Rebind<std::uint16_t, Floats> narrow;
    const auto scale = hn::Set(d, kColourStepsPerLevel);
    const auto half = hn::Set(d, 0.5f);
    const auto most = hn::Set(d, static_cast<float>(kColourSteps - 1));
    for (std::size_t x = 0; x < count; x += hn::Lanes(d)) {
        auto sum = hn::Zero(d);
        for (std::size_t c = 0; c < 3; ++c) {
            const auto difference = hn::Sub(hn::LoadU(d, a[c] + x), hn::LoadU(d, b[c] + x));
            sum = hn::Add(sum, hn::Mul(difference, difference));
        }
        const auto step = hn::Min(hn::Add(hn::Mul(hn::Sqrt(sum), scale), half), most);
        hn::StoreU(hn::DemoteTo(narrow, hn::ConvertTo(whole, step)), narrow, steps + x);
    }
}

// Adds or subtracts.
template <class D, class T>
HWY_INLINE void addTo(D d, T* HWY_RESTRICT sums, hn::Vec<D> values, bool subtract) {
    const auto before = hn::LoadU(d, sums);
    hn::StoreU(subtract ? hn::Sub(before, values) : hn::Add(before, values), d, sums);
}

// Sums of whole numbers, then of depth; memory in the first-level cache limits the speed.
template <bool kSubtract>
HWY_INLINE void addGuide(const RowOf3<std::uint8_t>& guide, const float* HWY_RESTRICT depth,
                         std::size_t count, const GuideSums& columns) {
    const Wholes whole;
    for (std::size_t x = 0; x < count; x += hn::Lanes(whole)) {
        const auto b = hn::PromoteTo(whole, hn::LoadU(Bytes(), guide[0] + x));
        const auto g = hn::PromoteTo(whole, hn::LoadU(Bytes(), guide[1] + x));
        const auto r = hn::PromoteTo(whole, hn::LoadU(Bytes(), guide[2] + x));
        addTo(whole, columns.colours[0] + x, b, kSubtract);
        addTo(whole, columns.colours[1] + x, g, kSubtract);
        addTo(whole, columns.colours[2] + x, r, kSubtract);
        addTo(whole, columns.colours[3] + x, hn::Mul(b, b), kSubtract);
        addTo(whole, columns.colours[4] + x, hn::Mul(g, g), kSubtract);
        addTo(whole, columns.colours[5] + x, hn::Mul(r, r), kSubtract);
        addTo(whole, columns.colours[6] + x, hn::Mul(b, g), kSubtract);
        addTo(whole, columns.colours[7] + x, hn::Mul(b, r), kSubtract);
        addTo(whole, columns.colours[8] + x, hn::Mul(g, r), kSubtract);
    }
    const Doubles d;
    const HalfFloats half;
    const HalfWholes halfWhole;
    for (std::size_t x = 0; x < count; x += hn::Lanes(d)) {
        const auto value = hn::LoadU(half, depth + x);
        addTo(d, columns.depth[0] + x, hn::PromoteTo(d, value), kSubtract);
        for (std::size_t c = 0; c < 3; ++c) {
            const auto colour =
                hn::ConvertTo(half, hn::PromoteTo(halfWhole, hn::LoadU(HalfBytes(), guide[c] + x)));
            const auto product = hn::Mul(colour, value); // in float, which keeps it on the grid
            addTo(d, columns.depth[c + 1] + x, hn::PromoteTo(d, product), kSubtract);
        }
    }
}

void addGuideRowOn(const RowOf3<std::uint8_t>& guide, const float* depth, std::size_t count,
                   bool subtract, const GuideSums& columns) {
    if (subtract) {
        addGuide<true>(guide, depth, count, columns);
    } else {
        addGuide<false>(guide, depth, count, columns);
    }
}

// out[x] = in[x] + ... + in[x + 16], by sums of 2, 4, 8 and 16.
template <class T>
HWY_INLINE void sumWindows(const T* HWY_RESTRICT in, std::size_t count, T* HWY_RESTRICT out) {
    const hn::ScalableTag<T> d;
    static_assert(2 * kGuideRadius == 16, "sums of 16 and one more");
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t x = 0; x < count + 2 * kGuideRadius; x += lanes)
        hn::StoreU(hn::Add(hn::LoadU(d, in + x), hn::LoadU(d, in + x + 1)), d, out + x);
    for (std::size_t x = 0; x < count + 2 * kGuideRadius; x += lanes)
        hn::StoreU(hn::Add(hn::LoadU(d, out + x), hn::LoadU(d, out + x + 2)), d, out + x);
    for (std::size_t x = 0; x < count + 2 * kGuideRadius; x += lanes)
        hn::StoreU(hn::Add(hn::LoadU(d, out + x), hn::LoadU(d, out + x + 4)), d, out + x);
    for (std::size_t x = 0; x < count; x += lanes) {
        const auto sum = hn::Add(hn::LoadU(d, out + x), hn::LoadU(d, out + x + 8));
        hn::StoreU(hn::Add(sum, hn::LoadU(d, in + x + 16)), d, out + x);
    }
}

HWY_INLINE void storeOnGrid(Double value, float* to) {
    const Doubles d;
    const auto shift = hn::Set(d, kToGrid);
    hn::StoreU(hn::DemoteTo(HalfFloats(), hn::Sub(hn::Add(value, shift), shift)), HalfFloats(), to);
}

// Some 80 operations per px in double limit the speed.
void fitGuideRowOn(const WindowRow& row, const GuideSums& columns, const GuideSums& windows,
                   const std::array<float*, 4>& lines) {
    for (std::size_t i = 0; i < columns.depth.size(); ++i)
        sumWindows(columns.depth[i], row.count, windows.depth[i]);
    for (std::size_t i = 0; i < columns.colours.size(); ++i)
        sumWindows(columns.colours[i], row.count, windows.colours[i]);
    const Doubles d;
    const auto one = hn::Set(d, 1.0);
    const auto height = hn::Set(d, row.height);
    const auto flat = hn::Set(d, kGuideFlatVariance);
    const auto minor = [](Double a, Double b, Double e, Double f)
                           HWY_ATTR { return hn::Sub(hn::Mul(a, b), hn::Mul(e, f)); };
    const auto product = [](Double a, Double b, Double e, Double x, Double y, Double z) HWY_ATTR {
        return hn::Add(hn::Add(hn::Mul(a, x), hn::Mul(b, y)), hn::Mul(e, z));
    };
    for (std::size_t x = 0; x < row.count; x += hn::Lanes(d)) {
        const auto share = hn::Div(one, hn::Mul(hn::LoadU(d, row.widths + x), height));
        const auto mean = hn::Mul(share, hn::LoadU(d, windows.depth[0] + x));
        const auto meanOf = [&](std::size_t i) HWY_ATTR {
            return hn::Mul(share, ofWholes(windows.colours[i] + x));
        };
        const auto meanB = meanOf(0);
        const auto meanG = meanOf(1);
        const auto meanR = meanOf(2);
        const auto withDepth = [&](std::size_t i, Double colour) HWY_ATTR {
            const auto both = hn::Mul(share, hn::LoadU(d, windows.depth[i] + x));
            return hn::Sub(both, hn::Mul(colour, mean));
        };
        const auto b = withDepth(1, meanB);
        const auto g = withDepth(2, meanG);
        const auto r = withDepth(3, meanR);
        const auto bb = hn::Add(hn::Sub(meanOf(3), hn::Mul(meanB, meanB)), flat);
        const auto gg = hn::Add(hn::Sub(meanOf(4), hn::Mul(meanG, meanG)), flat);
        const auto rr = hn::Add(hn::Sub(meanOf(5), hn::Mul(meanR, meanR)), flat);
        const auto bg = hn::Sub(meanOf(6), hn::Mul(meanB, meanG));
        const auto br = hn::Sub(meanOf(7), hn::Mul(meanB, meanR));
        const auto gr = hn::Sub(meanOf(8), hn::Mul(meanG, meanR));
        // Cramer's rule; the matrix is positive definite thanks to kGuideFlatVariance.
        const auto minorBB = minor(gg, rr, gr, gr);
        const auto minorBG = minor(br, gr, bg, rr);
        const auto minorBR = minor(bg, gr, br, gg);
        const auto minorGG = minor(bb, rr, br, br);
        const auto minorGR = minor(bg, br, bb, gr);
        const auto minorRR = minor(bb, gg, bg, bg);
        const auto scale = hn::Div(one, product(bb, bg, br, minorBB, minorBG, minorBR));
        const auto slopeB = hn::Mul(product(minorBB, minorBG, minorBR, b, g, r), scale);
        const auto slopeG = hn::Mul(product(minorBG, minorGG, minorGR, b, g, r), scale);
        const auto slopeR = hn::Mul(product(minorBR, minorGR, minorRR, b, g, r), scale);
        auto rest = hn::Sub(mean, hn::Mul(slopeB, meanB));
        rest = hn::Sub(rest, hn::Mul(slopeG, meanG));
        rest = hn::Sub(rest, hn::Mul(slopeR, meanR));
        storeOnGrid(slopeB, lines[0] + x);
        storeOnGrid(slopeG, lines[1] + x);
        storeOnGrid(slopeR, lines[2] + x);
        storeOnGrid(rest, lines[3] + x);
    }
    for (float* line : lines) // what was written beyond the row
        for (std::size_t i = 0; i < hn::Lanes(d); ++i)
            line[row.count + i] = 0;
}

void addLinesRowOn(const std::array<const float*, 4>& lines, std::size_t count, bool subtract,
                   const std::array<double*, 4>& columns) {
    const Doubles d;
    for (std::size_t i = 0; i < columns.size(); ++i)
        for (std::size_t x = 0; x < count; x += hn::Lanes(d))
            addTo(d, columns[i] + x, ofFloats(lines[i] + x), subtract);
}

void guidedRowOn(const WindowRow& row, const RowOf3<std::uint8_t>& guide,
                 const std::array<double*, 4>& columns, const std::array<double*, 4>& windows,
                 float* HWY_RESTRICT depth) {
    for (std::size_t i = 0; i < columns.size(); ++i)
        sumWindows(columns[i], row.count, windows[i]);
    const Doubles d;
    const auto height = hn::Set(d, row.height);
    for (std::size_t x = 0; x < row.count; x += hn::Lanes(d)) {
        auto total = hn::LoadU(d, windows[3] + x);
        for (std::size_t c = 0; c < 3; ++c)
            total = hn::Add(total, hn::Mul(hn::LoadU(d, windows[c] + x), ofBytes(guide[c] + x)));
        const auto count = hn::Mul(hn::LoadU(d, row.widths + x), height);
        hn::StoreU(hn::DemoteTo(HalfFloats(), hn::Div(total, count)), HalfFloats(), depth + x);
    }
}

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(colourStepsOn);
HWY_EXPORT(addGuideRowOn);
HWY_EXPORT(fitGuideRowOn);
HWY_EXPORT(addLinesRowOn);
HWY_EXPORT(guidedRowOn);

void colourSteps(const RowOf3<float>& a, const RowOf3<float>& b, std::size_t count,
                 std::uint16_t* steps) {
    HWY_DYNAMIC_DISPATCH(colourStepsOn)(a, b, count, steps);
}

void addGuideRow(const RowOf3<std::uint8_t>& guide, const float* depth, std::size_t count,
                 bool subtract, const GuideSums& columns) {
    HWY_DYNAMIC_DISPATCH(addGuideRowOn)(guide, depth, count, subtract, columns);
}

void fitGuideRow(const WindowRow& row, const GuideSums& columns, const GuideSums& windows,
                 const std::array<float*, 4>& lines) {
    HWY_DYNAMIC_DISPATCH(fitGuideRowOn)(row, columns, windows, lines);
}

void addLinesRow(const std::array<const float*, 4>& lines, std::size_t count, bool subtract,
                 const std::array<double*, 4>& columns) {
    HWY_DYNAMIC_DISPATCH(addLinesRowOn)(lines, count, subtract, columns);
}

void guidedRow(const WindowRow& row, const RowOf3<std::uint8_t>& guide,
               const std::array<double*, 4>& columns, const std::array<double*, 4>& windows,
               float* depth) {
    HWY_DYNAMIC_DISPATCH(guidedRowOn)(row, guide, columns, windows, depth);
}

} // namespace altiro3D
#endif
