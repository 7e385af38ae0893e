#include "native/view_columns.hpp"

#include "base/pixel_rows.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "native/view_columns.cpp"
#include <hwy/foreach_target.h> // IWYU pragma: keep

#include "base/kernel_parts_inl.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace altiro3D {
namespace HWY_NAMESPACE { // NOLINT(readability-identifier-naming)

namespace hn = hwy::HWY_NAMESPACE;

using Run = ViewColumns::Run;

#if HWY_TARGET == HWY_SCALAR
void turnOn(const std::vector<std::uint8_t*>& views, std::size_t rowBytes, std::uint8_t* to) {
    for (std::size_t i = 0; i < rowBytes; ++i)
        for (std::size_t view = 0; view < views.size(); ++view)
            to[ViewColumns::kMaxViews * i + view] = views[view][i];
}

void pickOn(const std::uint8_t* bytes, std::size_t, const Run* run, const std::uint8_t* views,
            std::size_t count, std::uint8_t* values) {
    for (std::size_t i = 0; i < count; ++i) {
        if (i >= run[1].begin) ++run;
        values[i] = bytes[run->bytes + views[i]];
    }
}
#else
// 16 bytes of 16 views become the 16 views of 16 bytes, in four rounds.
HWY_INLINE void turn16(const std::uint8_t* const* views, std::size_t count, std::size_t at,
                       std::uint8_t* to) {
    const hn::FixedTag<std::uint8_t, 16> d;
    using V = hn::Vec<decltype(d)>;
    V rows[16];
    for (std::size_t k = 0; k < 16; ++k)
        rows[k] = k < count ? hn::LoadU(d, views[k] + at) : hn::Zero(d);
    for (int round = 0; round < 4; ++round) {
        V next[16];
        for (std::size_t k = 0; k < 8; ++k) {
            next[2 * k] = hn::InterleaveLower(d, rows[k], rows[k + 8]);
            next[2 * k + 1] = hn::InterleaveUpper(d, rows[k], rows[k + 8]);
        }
        std::copy_n(next, 16, rows);
    }
    for (std::size_t k = 0; k < 16; ++k)
        hn::StoreU(rows[k], d, to + ViewColumns::kMaxViews * k);
}

// Shuffles limit the speed: one for each four bytes.
void turnOn(const std::vector<std::uint8_t*>& views, std::size_t rowBytes, std::uint8_t* to) {
    for (std::size_t at = 0; at < rowBytes; at += 16)
        for (std::size_t first = 0; first < views.size(); first += 16)
            turn16(views.data() + first, std::min<std::size_t>(views.size() - first, 16), at,
                   to + ViewColumns::kMaxViews * at + first);
}

// Loads and shuffles limit the speed: one or a few for each column under a vector of sub-pixels.
template <int kTables>
HWY_INLINE void pickBy(const std::uint8_t* HWY_RESTRICT bytes, const Run* HWY_RESTRICT run,
                       const std::uint8_t* HWY_RESTRICT views, std::size_t count,
                       std::uint8_t* HWY_RESTRICT values) {
    const hn::ScalableTag<std::uint8_t> d;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t i = 0; i < count; i += lanes) {
        const auto view = hn::LoadU(d, views + i);
        while (run[1].begin <= i)
            ++run;
        auto found = ByteWindow<kTables>(bytes + run->bytes).at(view);
        while (run[1].begin < i + lanes) {
            ++run;
            const auto next = ByteWindow<kTables>(bytes + run->bytes).at(view);
            found = hn::IfThenElse(hn::FirstN(d, run->begin - i), found, next);
        }
        hn::StoreU(found, d, values + i);
    }
}

void pickOn(const std::uint8_t* bytes, std::size_t viewCount, const Run* runs,
            const std::uint8_t* views, std::size_t count, std::uint8_t* values) {
    switch ((viewCount + 15) / 16) {
    case 1:
        return pickBy<1>(bytes, runs, views, count, values);
    case 2:
        return pickBy<2>(bytes, runs, views, count, values);
    case 3:
        return pickBy<3>(bytes, runs, views, count, values);
    default:
        return pickBy<4>(bytes, runs, views, count, values);
    }
}
#endif

} // namespace HWY_NAMESPACE
} // namespace altiro3D
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace altiro3D {

HWY_EXPORT(turnOn);
HWY_EXPORT(pickOn);

ViewColumns::ViewColumns(const std::vector<int>& columns) : count_(columns.size()) {
    for (std::size_t i = 0; i < count_; ++i) {
        if (i == 0 || columns[i] != columns[i - 1])
            runs_.push_back({i, kMaxViews * 3 * static_cast<std::size_t>(columns[i])});
    }
    runs_.push_back({SIZE_MAX, 0});
}

void ViewColumns::set(const std::vector<std::uint8_t*>& views, std::size_t rowBytes) {
    bytes_.resize(kMaxViews * (rowBytes + kRowPadding));
    viewCount_ = views.size();
    HWY_DYNAMIC_DISPATCH(turnOn)(views, rowBytes, bytes_.data());
}

void ViewColumns::pick(std::size_t channel, const std::uint8_t* views, std::uint8_t* values) const {
    HWY_DYNAMIC_DISPATCH(pickOn)
    (bytes_.data() + kMaxViews * channel, viewCount_, runs_.data(), views, count_, values);
}

} // namespace altiro3D
#endif
