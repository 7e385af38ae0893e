#include "base/pixel_rows.hpp"
#include "image/image_codecs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <opencv2/core.hpp>
#include <zlib.h>

// Filters, deflate and checksums of bands of rows are independent:
//
//     signature IHDR tEXt | IDAT: band 0 | IDAT: band 1 | ... | IDAT: Adler-32, IEND
//
// The bands depend only on the picture's size. Deflate searches for runs only (Z_RLE), so the
// division into bands does not reduce compression. Longer matches take twice the time and save
// almost nothing in photos and Natives.

namespace altiro3D {

namespace {

using Bytes = std::vector<unsigned char>;

// Approximate filtered bytes of one band; large compared to deflate's window of 32 kB.
constexpr std::size_t kBandBytes = std::size_t{1} << 19;

void append32(std::uint32_t value, Bytes& to) {
    for (int shift = 24; shift >= 0; shift -= 8)
        to.push_back(static_cast<unsigned char>(value >> shift & 0xffU));
}

// A row in PNG's order: RGB, high byte first.
void orderedRow(const cv::Mat& picture, int y, unsigned char* to) {
    const int channels = picture.channels();
    const auto put = [&](const auto* from, const auto& store) {
        for (int i = 0; i < picture.cols * channels; i += channels) {
            for (int c = 0; c < channels; ++c)
                store(i + c, from[i + channels - 1 - c]);
        }
    };
    if (picture.depth() == CV_8U) {
        put(picture.ptr<std::uint8_t>(y), [to](int i, std::uint8_t value) { to[i] = value; });
    } else {
        put(picture.ptr<std::uint16_t>(y), [to](int i, std::uint16_t value) {
            to[2 * i] = static_cast<unsigned char>(value >> 8);
            to[2 * i + 1] = static_cast<unsigned char>(value & 0xffU);
        });
    }
}

// Filters one row with PNG filter `Filter`. Returns the sum of the absolute values of the results
// as signed numbers; small sums compress well. Vector arithmetic limits the speed.
// @param row preceded by as many zeros as a pixel has bytes
// @param above the row above, preceded by zeros in the same way
template <int Filter>
std::uint32_t filterRow(const unsigned char* row, const unsigned char* above, std::size_t bytes,
                        std::size_t pixel, unsigned char* out) {
    const unsigned char* const lefts = row - pixel;
    const unsigned char* const corners = above - pixel;
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
        const auto left = static_cast<std::int16_t>(lefts[i]);
        const auto up = static_cast<std::int16_t>(above[i]);
        std::int16_t guess = 0;
        if constexpr (Filter == 1) guess = left;
        if constexpr (Filter == 2) guess = up;
        if constexpr (Filter == 3) guess = static_cast<std::int16_t>((left + up) >> 1);
        if constexpr (Filter == 4) {
            const auto corner = static_cast<std::int16_t>(corners[i]);
            const auto toLeft = static_cast<std::int16_t>(std::abs(up - corner));
            const auto toUp = static_cast<std::int16_t>(std::abs(left - corner));
            const auto toCorner = static_cast<std::int16_t>(std::abs(left + up - 2 * corner));
            const std::int16_t other = toUp <= toCorner ? up : corner;
            guess = toLeft <= toUp && toLeft <= toCorner ? left : other;
        }
        const auto result = static_cast<unsigned char>(row[i] - guess);
        out[i] = result;
        sum += static_cast<std::uint32_t>(std::abs(static_cast<signed char>(result)));
    }
    return sum;
}

// The rows of a band. Each row has the filter with the smallest sum and begins with its number.
// @param before the row above the picture; empty: none
Bytes filteredBand(const cv::Mat& picture, cv::Range rows, const cv::Mat& before) {
    const std::size_t pixel = picture.elemSize();
    const std::size_t bytes = static_cast<std::size_t>(picture.cols) * pixel;
    Bytes above(pixel + bytes);
    Bytes row(pixel + bytes);
    if (rows.start > 0) {
        orderedRow(picture, rows.start - 1, above.data() + pixel);
    } else if (!before.empty()) {
        orderedRow(before, 0, above.data() + pixel);
    }
    std::array<Bytes, 5> tried;
    for (Bytes& one : tried)
        one.resize(bytes);
    Bytes band((bytes + 1) * static_cast<std::size_t>(rows.size()));
    auto to = band.begin();
    for (int y = rows.start; y < rows.end; ++y) {
        orderedRow(picture, y, row.data() + pixel);
        const unsigned char* const now = row.data() + pixel;
        const unsigned char* const over = above.data() + pixel;
        const std::array<std::uint32_t, 5> sums = {
            filterRow<0>(now, over, bytes, pixel, tried[0].data()),
            filterRow<1>(now, over, bytes, pixel, tried[1].data()),
            filterRow<2>(now, over, bytes, pixel, tried[2].data()),
            filterRow<3>(now, over, bytes, pixel, tried[3].data()),
            filterRow<4>(now, over, bytes, pixel, tried[4].data())};
        const auto best = std::min_element(sums.begin(), sums.end()) - sums.begin();
        *to++ = static_cast<unsigned char>(best);
        to = std::copy_n(tried[static_cast<std::size_t>(best)].begin(), bytes, to);
        row.swap(above);
    }
    return band;
}

// Appends a part of a deflate stream. Another part can follow unless it is the last one.
void appendDeflated(Bytes& contents, bool isLast, Bytes& to) {
    z_stream stream{};
    if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, -15, 9, Z_RLE) != Z_OK)
        throw std::bad_alloc();
    const std::size_t begin = to.size();
    // deflateBound() does not include the flush marker between two parts
    to.resize(begin + deflateBound(&stream, static_cast<uLong>(contents.size())) + 64);
    stream.next_in = contents.data();
    stream.avail_in = static_cast<uInt>(contents.size());
    stream.next_out = to.data() + begin;
    stream.avail_out = static_cast<uInt>(to.size() - begin);
    const int result = deflate(&stream, isLast ? Z_FINISH : Z_SYNC_FLUSH);
    const bool isWhole = stream.avail_out > 0 && result == (isLast ? Z_STREAM_END : Z_OK);
    to.resize(to.size() - stream.avail_out);
    deflateEnd(&stream);
    CV_Assert(isWhole);
}

} // namespace

void appendPngChunk(std::string_view name, const Bytes& contents, Bytes& to) {
    append32(static_cast<std::uint32_t>(contents.size()), to);
    const std::size_t begin = to.size();
    to.insert(to.end(), name.begin(), name.end());
    to.insert(to.end(), contents.begin(), contents.end());
    append32(static_cast<std::uint32_t>(crc32_z(0, to.data() + begin, to.size() - begin)), to);
}

std::vector<unsigned char> pngHead(cv::Size size, int type, std::string_view text) {
    Bytes header;
    append32(static_cast<std::uint32_t>(size.width), header);
    append32(static_cast<std::uint32_t>(size.height), header);
    const unsigned char bits = CV_MAT_DEPTH(type) == CV_8U ? 8 : 16;
    const unsigned char colours = CV_MAT_CN(type) == 1 ? 0 : 2; // grey or RGB
    header.insert(header.end(), {bits, colours, 0, 0, 0});      // deflate, not interlaced
    Bytes file = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    appendPngChunk("IHDR", header, file);
    if (!text.empty()) appendPngChunk("tEXt", Bytes(text.begin(), text.end()), file);
    return file;
}

void appendPngSize(cv::Size2d dpi, Bytes& to) {
    constexpr double kInchesPerMetre = 1 / 0.0254;
    appendPngChunk("sRGB", {0}, to); // perceptual
    Bytes size;
    for (const double perInch : {dpi.width, dpi.height})
        append32(static_cast<std::uint32_t>(std::lround(perInch * kInchesPerMetre)), size);
    size.push_back(1); // per metre
    appendPngChunk("pHYs", size, to);
}

PngRows::PngRows(cv::Size size) : size_(size) {}

std::vector<Bytes> PngRows::deflated(const cv::Mat& rows) {
    const std::size_t rowBytes = 1 + static_cast<std::size_t>(rows.cols) * rows.elemSize();
    const int bandRows = static_cast<int>(std::max<std::size_t>(1, kBandBytes / rowBytes));
    const int bands = (rows.rows + bandRows - 1) / bandRows;
    std::vector<Bytes> parts(static_cast<std::size_t>(bands));
    std::vector<uLong> sums(static_cast<std::size_t>(bands));
    const auto rowsOf = [&](int band) {
        return cv::Range(band * bandRows, std::min((band + 1) * bandRows, rows.rows));
    };
    overRows(bands, [&](int i) {
        const auto band = static_cast<std::size_t>(i);
        Bytes contents = filteredBand(rows, rowsOf(i), above_);
        sums[band] = adler32_z(1, contents.data(), contents.size());
        if (done_ == 0 && i == 0) parts[band] = {0x78, 0x01}; // zlib: a window of 32 kB, fast
        appendDeflated(contents, done_ + rowsOf(i).end == size_.height, parts[band]);
    });
    for (int i = 0; i < bands; ++i) {
        const auto count = static_cast<std::size_t>(rowsOf(i).size());
        sum_ = adler32_combine(sum_, sums[static_cast<std::size_t>(i)],
                               static_cast<z_off_t>(count * rowBytes));
    }
    done_ += rows.rows;
    if (done_ < size_.height) rows.row(rows.rows - 1).copyTo(above_);
    return parts;
}

Bytes PngRows::end() const {
    Bytes adler;
    append32(static_cast<std::uint32_t>(sum_), adler);
    return adler;
}

std::vector<unsigned char> encodePng(const cv::Mat& picture, std::string_view text) {
    Bytes file = pngHead(picture.size(), picture.type(), text);
    PngRows rows(picture.size());
    for (Bytes& part : rows.deflated(picture)) {
        appendPngChunk("IDAT", part, file);
        Bytes().swap(part);
    }
    appendPngChunk("IDAT", rows.end(), file);
    appendPngChunk("IEND", Bytes(), file);
    return file;
}

} // namespace altiro3D
