#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <opencv2/core.hpp>
#include <string_view>
#include <utility>
#include <vector>
#include <zlib.h>

/// Writes PNG files on all threads: filters, deflate and checksums of bands of rows are
/// independent.
///
///     signature IHDR tEXt | IDAT: band 0 | IDAT: band 1 | ... | IDAT: Adler-32, IEND
///
/// The bands depend only on the picture's size, so any number of threads gives the same bytes.
/// Deflate searches for runs only (Z_RLE), so the division into bands does not reduce compression.
/// Longer matches take twice the time and save almost nothing in photos and Natives.
namespace altiro3D::png {

/// One piece of a file.
using Piece = std::vector<unsigned char>;

/// Approximate filtered bytes of one band; large compared to deflate's window of 32 kB.
constexpr std::size_t kBandBytes = std::size_t{1} << 19;

inline void put32(unsigned char* to, std::uint32_t value) {
    for (int i = 0; i < 4; ++i)
        to[i] = static_cast<unsigned char>(value >> (24 - 8 * i) & 0xffU);
}

/// A chunk with space for its length, which is not known yet, and room for `bytes` of contents
/// after its name.
inline Piece beginChunk(const char* name, std::size_t bytes) {
    Piece chunk;
    chunk.reserve(8 + bytes + 4);
    chunk.resize(4);
    for (int i = 0; i < 4; ++i)
        chunk.push_back(static_cast<unsigned char>(name[i]));
    chunk.resize(8 + bytes);
    return chunk;
}

inline void endChunk(Piece& chunk) {
    const std::size_t size = chunk.size();
    put32(chunk.data(), static_cast<std::uint32_t>(size - 8));
    const uLong sum = crc32_z(0, chunk.data() + 4, size - 4);
    chunk.resize(size + 4);
    put32(chunk.data() + size, static_cast<std::uint32_t>(sum));
}

/// A row in PNG's order: RGB, high byte first.
inline void orderedRow(const cv::Mat& picture, int y, unsigned char* to) {
    const int samples = picture.cols * picture.channels();
    const bool swaps = picture.channels() == 3;
    const auto put = [&](const auto* from, const auto& store) {
        if (swaps) {
            for (int i = 0; i < samples; i += 3) {
                store(i, from[i + 2]);
                store(i + 1, from[i + 1]);
                store(i + 2, from[i]);
            }
        } else {
            for (int i = 0; i < samples; ++i)
                store(i, from[i]);
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

/// Filters one row with PNG filter `Filter`. Returns the sum of the absolute values of the results
/// as signed numbers; small sums compress well. Vector arithmetic limits the speed.
///
/// @param row preceded by as many zeros as a pixel has bytes
/// @param above the row above, preceded by zeros in the same way
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

/// The rows of a band. Each row has the filter with the smallest sum, preceded by the filter's
/// number.
inline Piece filteredBand(const cv::Mat& picture, cv::Range rows) {
    const std::size_t pixel = picture.elemSize();
    const std::size_t bytes = static_cast<std::size_t>(picture.cols) * pixel;
    Piece above(pixel + bytes);
    Piece row(pixel + bytes);
    if (rows.start > 0) orderedRow(picture, rows.start - 1, above.data() + pixel);
    std::array<Piece, 5> tried;
    for (Piece& one : tried)
        one.resize(bytes);
    Piece band((bytes + 1) * static_cast<std::size_t>(rows.size()));
    auto to = band.begin();
    for (int y = rows.start; y < rows.end; ++y) {
        orderedRow(picture, y, row.data() + pixel);
        const unsigned char* const now = row.data() + pixel;
        const unsigned char* const before = above.data() + pixel;
        const std::array<std::uint32_t, 5> sums = {
            filterRow<0>(now, before, bytes, pixel, tried[0].data()),
            filterRow<1>(now, before, bytes, pixel, tried[1].data()),
            filterRow<2>(now, before, bytes, pixel, tried[2].data()),
            filterRow<3>(now, before, bytes, pixel, tried[3].data()),
            filterRow<4>(now, before, bytes, pixel, tried[4].data())};
        const auto best = std::min_element(sums.begin(), sums.end()) - sums.begin();
        *to++ = static_cast<unsigned char>(best);
        to = std::copy_n(tried[static_cast<std::size_t>(best)].begin(), bytes, to);
        row.swap(above);
    }
    return band;
}

/// Appends a part of a deflate stream. Another part can follow unless it is the last one.
inline void appendDeflated(Piece& contents, bool isLast, Piece& to) {
    z_stream stream{};
    if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, -15, 9, Z_RLE) != Z_OK) {
        throw std::bad_alloc();
    }
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

/// @param text contents of a text chunk: keyword, a zero byte, text; empty = no chunk
inline Piece beginning(const cv::Mat& picture, std::string_view text) {
    constexpr std::array<unsigned char, 8> kSignature = {0x89, 'P',  'N',  'G',
                                                         '\r', '\n', 0x1a, '\n'};
    Piece header = beginChunk("IHDR", 13);
    put32(header.data() + 8, static_cast<std::uint32_t>(picture.cols));
    put32(header.data() + 12, static_cast<std::uint32_t>(picture.rows));
    header[16] = picture.depth() == CV_8U ? 8 : 16;
    header[17] = picture.channels() == 1
                     ? 0
                     : 2; // grey or RGB; the zeros after it: deflate, filters, no interlace
    endChunk(header);
    Piece piece(kSignature.begin(), kSignature.end());
    piece.insert(piece.end(), header.begin(), header.end());
    if (!text.empty()) {
        Piece chunk = beginChunk("tEXt", text.size());
        std::copy(text.begin(), text.end(), chunk.begin() + 8);
        endChunk(chunk);
        piece.insert(piece.end(), chunk.begin(), chunk.end());
    }
    return piece;
}

inline Piece ending(uLong adler) {
    Piece last = beginChunk("IDAT", 4);
    put32(last.data() + 8, static_cast<std::uint32_t>(adler));
    endChunk(last);
    Piece end = beginChunk("IEND", 0);
    endChunk(end);
    Piece piece(last.size() + end.size());
    std::copy(end.begin(), end.end(), std::copy(last.begin(), last.end(), piece.begin()));
    return piece;
}

/// Encodes a picture; the pieces in order are the file.
///
/// @param picture [rows x cols, CV_8UC1, CV_8UC3, CV_16UC1 or CV_16UC3, BGR], not empty
/// @param text see beginning()
inline std::vector<Piece> encode(const cv::Mat& picture, std::string_view text = {}) {
    const std::size_t rowBytes = 1 + static_cast<std::size_t>(picture.cols) * picture.elemSize();
    const int bandRows = static_cast<int>(std::max<std::size_t>(1, kBandBytes / rowBytes));
    const int bands = (picture.rows + bandRows - 1) / bandRows;
    std::vector<Piece> pieces(static_cast<std::size_t>(bands) + 2);
    std::vector<uLong> sums(static_cast<std::size_t>(bands));
    cv::parallel_for_(cv::Range(0, bands), [&](const cv::Range& range) {
        for (int i = range.start; i < range.end; ++i) {
            const auto band = static_cast<std::size_t>(i);
            Piece contents =
                filteredBand(picture, {i * bandRows, std::min((i + 1) * bandRows, picture.rows)});
            sums[band] = adler32_z(1, contents.data(), contents.size());
            Piece chunk = beginChunk("IDAT", i == 0 ? 2 : 0);
            if (i == 0) { // zlib's header: deflate with a window of 32 kB, fast
                chunk[8] = 0x78;
                chunk[9] = 0x01;
            }
            appendDeflated(contents, i + 1 == bands, chunk);
            endChunk(chunk);
            chunk.shrink_to_fit();
            pieces[band + 1] = std::move(chunk);
        }
    });
    uLong sum = 1;
    for (int i = 0; i < bands; ++i) {
        const auto rows = static_cast<std::size_t>(std::min(bandRows, picture.rows - i * bandRows));
        sum = adler32_combine(sum, sums[static_cast<std::size_t>(i)],
                              static_cast<z_off_t>(rows * rowBytes));
    }
    pieces.front() = beginning(picture, text);
    pieces.back() = ending(sum);
    return pieces;
}

} // namespace altiro3D::png
