#include "base/pixel_rows.hpp"
#include "depth/stereo/stereo_parts.hpp"

#include "image/pixel_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

namespace altiro3D {

namespace {

constexpr int kCoarseSide = 240;        // px; the whole search range is scanned at this size
constexpr int kCoarseBlock = 15;        // px a side
constexpr int kFineBlock = 31;          // px a side
constexpr int kBlocksAcross = 12;       // blocks in a row and in a column
constexpr double kSearchColumns = 0.35; // share of the width, to both sides
constexpr double kSearchRows = 0.04;    // share of the height, up and down
constexpr double kMinCorrelation = 0.8;
constexpr double kMinDeviation = 4; // grey levels: below, a block has no texture
constexpr double kMinDrop = 0.02;   // drop of the correlation 3 rows above and below the match
constexpr double kTolerance = 1.5;  // px; a block within it agrees with the fit
constexpr int kMinBlocks = 12;

struct Block {
    cv::Point2d at;   // its middle in the left picture, px
    cv::Point2d seen; // its middle in the right picture
};

struct Match {
    cv::Point shift;
    double correlation = -1;
    double rowPart = 0; // fraction of a px, by a parabola through correlations above and below
};

// Sums over a block of n px, from which the normalized correlation follows without rounding.
struct BlockSums {
    std::int64_t a = 0;
    std::int64_t b = 0;
    std::int64_t aa = 0;
    std::int64_t bb = 0;
    std::int64_t ab = 0;
};

double correlationOf(const BlockSums& s, std::int64_t n) {
    const double variances =
        static_cast<double>(n * s.aa - s.a * s.a) * static_cast<double>(n * s.bb - s.b * s.b);
    if (variances <= 0) return -1;
    return static_cast<double>(n * s.ab - s.a * s.b) / std::sqrt(variances);
}

double correlation(const cv::Mat& left, cv::Point at, const cv::Mat& right, cv::Point to,
                   int side) {
    BlockSums sums;
    for (int y = 0; y < side; ++y) {
        const std::uint8_t* const a = left.ptr(at.y + y) + at.x;
        const std::uint8_t* const b = right.ptr(to.y + y) + to.x;
        int sumA = 0;
        int sumB = 0;
        int sumAA = 0;
        int sumBB = 0;
        int sumAB = 0;
        for (int x = 0; x < side; ++x) {
            sumA += a[x];
            sumB += b[x];
            sumAA += a[x] * a[x];
            sumBB += b[x] * b[x];
            sumAB += a[x] * b[x];
        }
        sums.a += sumA;
        sums.b += sumB;
        sums.aa += sumAA;
        sums.bb += sumBB;
        sums.ab += sumAB;
    }
    return correlationOf(sums, std::int64_t{side} * side);
}

bool hasTexture(const cv::Mat& picture, cv::Point at, int side) {
    BlockSums sums;
    for (int y = 0; y < side; ++y) {
        const std::uint8_t* const row = picture.ptr(at.y + y) + at.x;
        for (int x = 0; x < side; ++x) {
            sums.a += row[x];
            sums.aa += row[x] * row[x];
        }
    }
    const double n = side * side;
    const double mean = static_cast<double>(sums.a) / n;
    return static_cast<double>(sums.aa) / n - mean * mean >= kMinDeviation * kMinDeviation;
}

// The best place of a block among shifts; the first one of several.
Match bestMatch(const cv::Mat& left, cv::Point at, const cv::Mat& right, int side,
                const cv::Rect& shifts) {
    Match best;
    const auto correlationAt = [&](int dx, int dy) {
        const cv::Point to(at.x + dx, at.y + dy);
        const bool isInside =
            to.x >= 0 && to.y >= 0 && to.x + side <= right.cols && to.y + side <= right.rows;
        return isInside ? correlation(left, at, right, to, side) : -1;
    };
    for (int dy = shifts.y; dy < shifts.y + shifts.height; ++dy) {
        for (int dx = shifts.x; dx < shifts.x + shifts.width; ++dx) {
            const double value = correlationAt(dx, dy);
            if (value > best.correlation) best = {{dx, dy}, value, 0};
        }
    }
    if (best.correlation < kMinCorrelation) return best;
    const double above = correlationAt(best.shift.x, best.shift.y - 1);
    const double below = correlationAt(best.shift.x, best.shift.y + 1);
    const double curve = above + below - 2 * best.correlation;
    if (above > -1 && below > -1 && curve < 0)
        best.rowPart = std::clamp((above - below) / (2 * curve), -0.5, 0.5);
    return best;
}

// The upper left corner of a square around a place, inside the picture.
cv::Point cornerOf(cv::Point2d middle, int side, const cv::Mat& picture) {
    return {std::clamp(static_cast<int>(middle.x) - side / 2, 0, picture.cols - side),
            std::clamp(static_cast<int>(middle.y) - side / 2, 0, picture.rows - side)};
}

// Finds a block of the left picture in the right one, coarsely and then at full size.
std::optional<Block> findBlock(const cv::Mat& left, const cv::Mat& right, const cv::Mat& smallLeft,
                               const cv::Mat& smallRight, cv::Point2d middle) {
    const double scale = static_cast<double>(smallLeft.cols) / left.cols;
    const cv::Point coarse = cornerOf(middle * scale, kCoarseBlock, smallLeft);
    const int columns = static_cast<int>(smallLeft.cols * kSearchColumns);
    const int rows = static_cast<int>(std::ceil(smallLeft.rows * kSearchRows));
    const Match guess = bestMatch(smallLeft, coarse, smallRight, kCoarseBlock,
                                  {-columns, -rows, 2 * columns + 1, 2 * rows + 1});
    if (guess.correlation < kMinCorrelation) return std::nullopt;
    const cv::Point fine = cornerOf(middle, kFineBlock, left);
    const int reach = static_cast<int>(std::ceil(0.7 / scale)) + 1;
    const cv::Point first(cvRound(guess.shift.x / scale) - reach,
                          cvRound(guess.shift.y / scale) - reach);
    const Match match =
        bestMatch(left, fine, right, kFineBlock, {first, cv::Size(2 * reach + 1, 2 * reach + 1)});
    if (match.correlation < kMinCorrelation) return std::nullopt;
    for (const int away : {-3, 3}) { // a block of upright edges says nothing about rows
        const cv::Point to = fine + match.shift + cv::Point(0, away);
        if (to.y < 0 || to.y + kFineBlock > right.rows) continue;
        if (correlation(left, fine, right, to, kFineBlock) > match.correlation - kMinDrop)
            return std::nullopt;
    }
    constexpr double kMiddle = 0.5 * (kFineBlock - 1);
    const cv::Point2d at(fine.x + kMiddle - 0.5 * (left.cols - 1),
                         fine.y + kMiddle - 0.5 * (left.rows - 1));
    return Block{at, {at.x + match.shift.x, at.y + match.shift.y + match.rowPart}};
}

double medianOf(std::vector<double>& values) {
    return values.empty() ? 0 : valueOfRank(values, values.size() / 2);
}

double residual(const RowFit& fit, const Block& block) {
    return block.seen.y - block.at.y - fit.offset - fit.slope * block.seen.x -
           fit.stretch * block.at.y;
}

// Medians of slopes between distant blocks (Theil and Sen); up to a quarter may be wrong matches.
RowFit robustFit(const std::vector<Block>& blocks, cv::Size size) {
    RowFit fit;
    std::vector<double> values;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            const double columns = blocks[i].seen.x - blocks[k].seen.x;
            const double rows = blocks[i].at.y - blocks[k].at.y;
            if (std::abs(columns) < 0.25 * size.width || std::abs(rows) > 0.1 * size.height)
                continue;
            values.push_back(
                (blocks[i].seen.y - blocks[i].at.y - blocks[k].seen.y + blocks[k].at.y) / columns);
        }
    }
    fit.slope = medianOf(values);
    values.clear();
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            const double rows = blocks[i].at.y - blocks[k].at.y;
            if (std::abs(rows) < 0.25 * size.height) continue;
            values.push_back((residual(fit, blocks[i]) - residual(fit, blocks[k])) / rows);
        }
    }
    fit.stretch = medianOf(values);
    values.clear();
    for (const Block& block : blocks)
        values.push_back(residual(fit, block));
    fit.offset = medianOf(values);
    return fit;
}

// Least squares over the blocks that agree with the fit so far.
RowFit refined(const RowFit& fit, const std::vector<Block>& blocks) {
    cv::Matx33d normal = cv::Matx33d::zeros();
    cv::Vec3d side(0, 0, 0);
    RowFit result = fit;
    result.blocks = 0;
    for (const Block& block : blocks) {
        if (std::abs(residual(fit, block)) > kTolerance) continue;
        const cv::Vec3d row(1, block.seen.x, block.at.y);
        normal += row * row.t();
        side += row * (block.seen.y - block.at.y);
        ++result.blocks;
    }
    cv::Vec3d solution;
    if (result.blocks >= kMinBlocks && cv::solve(normal, side, solution, cv::DECOMP_CHOLESKY)) {
        result.offset = solution[0];
        result.slope = solution[1];
        result.stretch = solution[2];
    }
    return result;
}

} // namespace

RowFit fitRows(const cv::Mat& left, const cv::Mat& right) {
    RowFit fit;
    if (std::min(left.cols, left.rows) < 2 * kFineBlock) return fit;
    const double scale = std::min(1.0, static_cast<double>(kCoarseSide) / left.cols);
    const cv::Size small(cvRound(left.cols * scale), cvRound(left.rows * scale));
    if (std::min(small.width, small.height) < 2 * kCoarseBlock) return fit;
    cv::Mat smallLeft;
    cv::Mat smallRight;
    cv::resize(left, smallLeft, small, 0, 0, cv::INTER_AREA);
    cv::resize(right, smallRight, small, 0, 0, cv::INTER_AREA);

    constexpr int kPlaces = kBlocksAcross * kBlocksAcross;
    std::vector<std::optional<Block>> found(kPlaces);
    std::vector<char> textured(kPlaces);
    overRows(kPlaces, [&](int i) {
        const int column = i % kBlocksAcross;
        const int row = i / kBlocksAcross;
        const cv::Point2d middle((column + 0.5) * left.cols / kBlocksAcross,
                                 (row + 0.5) * left.rows / kBlocksAcross);
        const auto place = static_cast<std::size_t>(i);
        if (!hasTexture(left, cornerOf(middle, kFineBlock, left), kFineBlock)) return;
        textured[place] = 1;
        found[place] = findBlock(left, right, smallLeft, smallRight, middle);
    });
    std::vector<Block> blocks;
    for (const auto& block : found) {
        if (block) blocks.push_back(*block);
    }
    const auto count = static_cast<int>(std::count(textured.begin(), textured.end(), 1));
    if (blocks.size() >= static_cast<std::size_t>(kMinBlocks)) {
        fit = robustFit(blocks, left.size());
        for (int pass = 0; pass < 3; ++pass)
            fit = refined(fit, blocks);
    }
    if (fit.blocks < kMinBlocks || 4 * fit.blocks < count) fit = {0, 0, 0, fit.blocks, 0};
    fit.textured = count;
    return fit;
}

cv::Mat moveRows(const cv::Mat& right, const RowFit& fit) {
    if (fit.offset == 0 && fit.slope == 0 && fit.stretch == 0) return right;
    const double x = 0.5 * (right.cols - 1);
    const double y = 0.5 * (right.rows - 1);
    // row y' of the result is row y' + offset + slope (x' - x) + stretch (y' - y); what turns rows
    // turns columns as well
    const cv::Matx23d from(1, -fit.slope, fit.slope * y, fit.slope, 1 + fit.stretch,
                           fit.offset - fit.slope * x - fit.stretch * y);
    cv::Mat moved;
    cv::warpAffine(right, moved, from, right.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                   cv::BORDER_REPLICATE);
    return moved;
}

} // namespace altiro3D
