#include "image/pixel_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

cv::Size downscaledSize(cv::Size size, int longestSide) {
    const int longSide = std::max(size.width, size.height);
    if (longSide <= longestSide) return size;
    const auto scaled = [&](int side) {
        const double exact = static_cast<double>(side) * longestSide / longSide;
        return std::max(1, static_cast<int>(std::lround(exact)));
    };
    return {scaled(size.width), scaled(size.height)};
}

namespace {

// Division of numbers below 256 * divisor, as a multiplication where that is exact.
class Divisor {
  public:
    explicit Divisor(std::uint64_t divisor)
        : divisor_(divisor), factor_(divisor < kTooLarge ? (1ULL << kShift) / divisor + 1 : 0) {}
    std::uint64_t quotient(std::uint64_t number) const {
        return factor_ > 0 ? number * factor_ >> kShift : number / divisor_;
    }
    std::uint64_t half() const { return divisor_ / 2; }

  private:
    // The factor is too large by at most 1, which adds number / 2^kShift to the quotient. That is
    // less than 1 / divisor, so the next whole number is not reached.
    static constexpr int kShift = 54;
    static constexpr std::uint64_t kTooLarge = 1ULL << 23;
    std::uint64_t divisor_;
    std::uint64_t factor_;
};

} // namespace

// Memory limits the speed. The blocks are placed symmetrically.
cv::Mat downscale(const cv::Mat& photo, int longestSide) {
    const cv::Size size = downscaledSize(photo.size(), longestSide);
    if (size == photo.size()) return photo.clone();
    cv::Mat small(size, CV_8UC3);
    const auto blockBegin = [](int i, int from, int to) {
        return static_cast<int>(static_cast<std::int64_t>(i) * from / to);
    };
    const auto blockEnd = [](int i, int from, int to) {
        return static_cast<int>((static_cast<std::int64_t>(i + 1) * from + to - 1) / to);
    };
    struct Block {
        std::size_t left;
        std::size_t width;
    };
    std::vector<Block> blocks;
    std::size_t widest = 0;
    for (int x = 0; x < small.cols; ++x) {
        const int left = blockBegin(x, photo.cols, small.cols);
        const int width = blockEnd(x, photo.cols, small.cols) - left;
        blocks.push_back({static_cast<std::size_t>(left), static_cast<std::size_t>(width)});
        widest = std::max(widest, blocks.back().width);
    }
    cv::parallel_for_(cv::Range(0, small.rows), [&](const cv::Range& range) {
        std::vector<std::uint32_t> sums(static_cast<std::size_t>(photo.cols) * 3);
        for (int y = range.start; y < range.end; ++y) {
            std::fill(sums.begin(), sums.end(), 0U);
            const int top = blockBegin(y, photo.rows, small.rows);
            const int bottom = blockEnd(y, photo.rows, small.rows);
            for (int sourceY = top; sourceY < bottom; ++sourceY) {
                const uchar* source = photo.ptr<uchar>(sourceY);
                for (std::size_t i = 0; i < sums.size(); ++i)
                    sums[i] += source[i];
            }
            uchar* out = small.ptr<uchar>(y);
            const auto height = static_cast<std::size_t>(bottom - top);
            const Divisor counts[] = {Divisor(widest * height), // px of a block, by its width
                                      Divisor(std::max<std::size_t>(widest - 1, 1) * height),
                                      Divisor((std::max<std::size_t>(widest, 3) - 2) * height)};
            for (const Block& block : blocks) {
                std::array<std::uint64_t, 3> total{};
                for (std::size_t i = block.left; i < block.left + block.width; ++i)
                    for (std::size_t c = 0; c < 3; ++c)
                        total[c] += sums[3 * i + c];
                const Divisor& count = counts[widest - block.width];
                for (const std::uint64_t sum : total)
                    *out++ = static_cast<uchar>(count.quotient(sum + count.half()));
            }
        }
    });
    return small;
}

} // namespace altiro3D
