#include "views_layered_row.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <opencv2/core/hal/intrin.hpp>

namespace altiro3D {

namespace {

constexpr int kSubNodes = 1 << kSubNodeBits;
constexpr int kWeightBits = 14;
constexpr int kMostBorders = 3; // that are blended in one pixel

// Catmull-Rom weights of the nodes -1, 0, 1, 2 for each place between 0 and 1. At 0 only node 0
// counts, so that what does not move is copied.
struct Weights {
    std::array<std::array<std::int16_t, 4>, kSubNodes + 1> of{};

    Weights() {
        for (int i = 0; i <= kSubNodes; ++i) {
            const double t = static_cast<double>(i) / kSubNodes;
            const double w[] = {((-0.5 * t + 1) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1,
                                ((-1.5 * t + 2) * t + 0.5) * t, (0.5 * t - 0.5) * t * t};
            std::array<std::int16_t, 4>& weights = of[static_cast<std::size_t>(i)];
            int sum = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                weights[k] = static_cast<std::int16_t>(std::lround(w[k] * (1 << kWeightBits)));
                sum += weights[k];
            }
            std::int16_t& largest = weights[t < 0.5 ? 1 : 2];
            largest = static_cast<std::int16_t>(largest + (1 << kWeightBits) - sum);
        }
    }
};

const Weights kWeights;

// B G R and a byte of no meaning.
inline std::uint32_t samplePlace(const LayeredRow& row, std::int32_t place) {
    const std::uint8_t* node = row.colour + 4 * static_cast<std::ptrdiff_t>(place >> kSubNodeBits);
    const auto& w = kWeights.of[static_cast<std::size_t>(place & (kSubNodes - 1))];
    std::uint32_t packed = 0;
#if CV_SIMD128
    std::int32_t pair[2];
    std::memcpy(pair, w.data(), sizeof(pair));
    const cv::v_uint8x16 nodes = cv::v_load(node - 4); // -1 0 1 2, four bytes each
    cv::v_uint8x16 low;                                // channels of -1 0, then of 0 1
    cv::v_uint8x16 high;                               // channels of 1 2, then of no use
    cv::v_zip(nodes, cv::v_extract<4>(nodes, nodes), low, high);
    const cv::v_int16x8 before = cv::v_reinterpret_as_s16(cv::v_expand_low(low));
    const cv::v_int16x8 after = cv::v_reinterpret_as_s16(cv::v_expand_low(high));
    const cv::v_int16x8 weightsBefore = cv::v_reinterpret_as_s16(cv::v_setall_s32(pair[0]));
    const cv::v_int16x8 weightsAfter = cv::v_reinterpret_as_s16(cv::v_setall_s32(pair[1]));
    const cv::v_int32x4 half = cv::v_setall_s32(1 << (kWeightBits - 1));
    const cv::v_int32x4 sum =
        cv::v_dotprod(before, weightsBefore) + cv::v_dotprod(after, weightsAfter) + half;
    const cv::v_int16x8 words = cv::v_pack(sum >> kWeightBits, half);
    const cv::v_uint8x16 bytes = cv::v_pack_u(words, words);
    packed = cv::v_reinterpret_as_u32(bytes).get0();
#else
    std::uint8_t bytes[4] = {0, 0, 0, 0};
    for (int c = 0; c < 3; ++c) {
        const std::int32_t sum = w[0] * node[c - 4] + w[1] * node[c] + w[2] * node[c + 4] +
                                 w[3] * node[c + 8] + (1 << (kWeightBits - 1));
        bytes[c] = static_cast<std::uint8_t>(std::clamp(sum >> kWeightBits, 0, 255));
    }
    std::memcpy(&packed, bytes, 4);
#endif
    return packed;
}

void sampleCode(const LayeredRow& row, const LayeredTrace& trace, std::int32_t code,
                std::uint8_t* bgr, int depth) {
    if (code >= 0) {
        const std::uint32_t packed = samplePlace(row, code);
        std::memcpy(bgr, &packed, 3);
        return;
    }
    const LayeredBorder& border = trace.borders[static_cast<std::size_t>(-1 - code)];
    const std::uint32_t top = samplePlace(row, border.top);
    std::memcpy(bgr, &top, 3);
    if (depth == 0) return;
    std::uint8_t under[3];
    sampleCode(row, trace, border.under, under, depth - 1);
    for (int c = 0; c < 3; ++c) {
        const int sum = border.coverage * bgr[c] + (kSubNodes - border.coverage) * under[c];
        bgr[c] = static_cast<std::uint8_t>((sum + kSubNodes / 2) >> kSubNodeBits);
    }
}

// The first whole column at or right of a place, 0..width.
inline int columnFrom(double place, double width) {
    const double inside = std::min(std::max(place, 0.0), width);
    const int whole = static_cast<int>(inside);
    return whole + static_cast<int>(static_cast<double>(whole) < inside);
}

// Lays the border of a surface over a pixel.
void drawBorder(LayeredTrace& trace, int x, int width, std::int32_t top, double coverage) {
    if (x < 0 || x >= width || coverage <= 0) return;
    std::int32_t& code = trace.code[static_cast<std::size_t>(x)];
    const auto part = static_cast<std::int32_t>(std::lround(coverage * kSubNodes));
    if (part == 0 && code != kNothing) return;
    if (code == kNothing || part >= kSubNodes) {
        code = top;
        return;
    }
    trace.borders.push_back({top, code, part});
    code = -static_cast<std::int32_t>(trace.borders.size());
}

void traceSpan(const LayeredRow& row, const LayeredSpan& span, double shiftPixels, int width,
               LayeredTrace& trace) {
    const float* offset = row.offset + span.first;
    std::int32_t* code = trace.code.data();
    double left = span.x - shiftPixels * static_cast<double>(offset[0]);
    const std::int32_t base = span.first << kSubNodeBits;
    if (span.leftEnd && left > -1 && left < width + 2) {
        const int x = static_cast<int>(std::ceil(left)) - 1;
        const double covered = x + 1 - left + static_cast<double>(span.leftExtra);
        drawBorder(trace, x, width, base, covered);
        drawBorder(trace, x - 1, width, base, covered - 1);
    }
    int from = columnFrom(left, width);
    for (int i = 1; i < span.count; ++i) {
        const double right = span.x + i - shiftPixels * static_cast<double>(offset[i]);
        const int to = columnFrom(right, width);
        if (from < to) {
            const double step = kSubNodes / (right - left);
            const std::int32_t node = base + ((i - 1) << kSubNodeBits);
            int x = from;
            do {
                code[x] = node + static_cast<std::int32_t>((x - left) * step + 0.5);
            } while (++x < to);
        }
        left = right;
        from = to;
    }
    const std::int32_t last = base + ((span.count - 1) << kSubNodeBits);
    if (left >= 0 && left <= width - 1 && from < width && static_cast<double>(from) == left)
        code[from] = last;
    if (span.rightEnd && left > -3 && left < width) {
        const int x = static_cast<int>(std::floor(left)) + 1;
        const double covered = left + 1 - x + static_cast<double>(span.rightExtra);
        drawBorder(trace, x, width, last, covered);
        drawBorder(trace, x + 1, width, last, covered - 1);
    }
}

// The surface's end that went out of the frame least far, where nothing is left in it.
std::int32_t nearestNode(const LayeredRow& row, double shiftPixels, int width) {
    std::int32_t nearest = row.spans[0].first << kSubNodeBits;
    double least = std::numeric_limits<double>::infinity();
    int column = 0;
    for (int i = 0; i < row.spanCount; ++i) {
        const LayeredSpan& span = row.spans[i];
        for (const int end : {0, span.count - 1}) {
            const int node = span.first + end;
            const int x = static_cast<int>(span.x) + end;
            const double place = x - shiftPixels * static_cast<double>(row.offset[node]);
            const double out = place < 0 ? -place : place - (width - 1);
            // where distances are too large to differ, the last to leave is on the frame's side
            const bool later = place < 0 ? x > column : x < column;
            if (out > least || (out == least && !later)) continue;
            least = out;
            column = x;
            nearest = node << kSubNodeBits;
        }
    }
    return nearest;
}

} // namespace

void traceRow(const LayeredRow& row, double shiftPixels, int width, LayeredTrace& trace) {
    trace.code.assign(static_cast<std::size_t>(width), kNothing);
    trace.borders.clear();
    for (int i = 0; i < row.spanCount; ++i)
        traceSpan(row, row.spans[i], shiftPixels, width, trace);
    int gaps = 0;
    std::int32_t* code = trace.code.data();
    for (int x = 0; x < width; ++x)
        gaps += static_cast<int>(code[x] == kNothing);
    if (gaps == 0) return;
    // Beyond the reach nothing is prepared: the farther side of a gap is the one at its right.
    for (int x = width - 2; x >= 0; --x)
        if (code[x] == kNothing) code[x] = code[x + 1];
    if (code[0] == kNothing) code[0] = nearestNode(row, shiftPixels, width);
    for (int x = 1; x < width; ++x)
        if (code[x] == kNothing) code[x] = code[x - 1];
}

void samplePixel(const LayeredRow& row, const LayeredTrace& trace, int x, std::uint8_t* bgr) {
    sampleCode(row, trace, trace.code[static_cast<std::size_t>(x)], bgr, kMostBorders);
}

void sampleRow(const LayeredRow& row, const LayeredTrace& trace, int width, std::uint8_t* bgr) {
    const std::int32_t* code = trace.code.data();
    for (int x = 0; x + 1 < width; ++x, bgr += 3) { // four bytes at a time: the next px mends it
        if (code[x] >= 0) {
            const std::uint32_t packed = samplePlace(row, code[x]);
            std::memcpy(bgr, &packed, 4);
        } else {
            sampleCode(row, trace, code[x], bgr, kMostBorders);
        }
    }
    samplePixel(row, trace, width - 1, bgr);
}

} // namespace altiro3D
