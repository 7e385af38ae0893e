#pragma once

#include "base/pixel_rows.hpp"
#include "views/views_layered_columns.hpp"
#include "views/views_layered_ends.hpp"
#include "views/views_layered_lines.hpp"
#include "views/views_layered_scene.hpp"
#include "views/views_layered_soft.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// Reads pixels at given columns of the photo, one row at a time. Several parts (channels or views)
/// share the columns.
class LayeredReader {
  public:
    LayeredReader(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns,
                  std::size_t parts);

    std::size_t count() const { return columns_.size(); }
    bool still() const { return scene_.flat || scene_.still[static_cast<std::size_t>(row_)] != 0; }
    const std::uint8_t* bgr() const { return photo_.ptr<std::uint8_t>(row_); }

    /// Pixels of each part that are found together. A multiple of kBlockPixels.
    static constexpr std::size_t kPixelsAtATime = 2048;

    void open(int row);

    /// Finds what the pixels show and gives it to read(part, begin).
    /// @param shifts of the pixels of each part, as for SubpixelSampler::sampleWhole()
    template <class F>
    void find(const std::int16_t* const* shifts, std::size_t parts, const F& read) {
        bounded_ = true;
        const float perStep = scene_.reachPixels * static_cast<float>(1 / kWholeReach);
        for (begin_ = 0; begin_ < columns_.size(); begin_ += kPixelsAtATime) {
            LayeredOpenCounts open;
            for (std::size_t part = 0; part < parts; ++part) {
                if (layeredLines(linePixels(shifts[part]), room_.placesOf(part),
                                 room_.openBlocks(part), room_.shifts.data()))
                    guess(part, open);
            }
            findEnds(open, parts);
            findBehind(parts, [&](std::size_t part, std::size_t pixel) {
                return perStep * static_cast<float>(shifts[part][begin_ + pixel]);
            });
            for (std::size_t part = 0; part < parts; ++part)
                read(part, begin_);
        }
    }

    /// The same for one part and shifts that may be beyond the reach of the scene, in px.
    template <class F>
    void findAnywhere(const float* shifts, const F& read) {
        bounded_ = false;
        for (begin_ = 0; begin_ < columns_.size(); begin_ += kPixelsAtATime) {
            std::fill_n(room_.openBlocks(0), size() / kBlockPixels + 1, std::uint8_t{1});
            findEnds(listAll(shifts), 1);
            findBehind(1, [&](std::size_t, std::size_t pixel) { return shifts[begin_ + pixel]; });
            read(0, begin_);
        }
    }

    /// Reads a channel of the pixels just found. @param values of these pixels
    void read(std::size_t part, int channel, std::uint8_t* values) const;

  private:
    // The memory of a LayeredRoom, and more of the pixels being found, as in LayeredPixels.
    struct Room {
        // @param count pixels of each part
        Room(std::size_t parts, std::size_t count)
            : stride((count / kBlockPixels + 1) * kBlockPixels),
              places(parts * stride + kRowPadding), hardColumns(places), mixed(places),
              covers(places), shares(places),
              soft(places), open{List(places.size()), List(places.size())}, hard(places.size()),
              shifts(stride + kRowPadding), openBlocks_(parts * stride / kBlockPixels) {}

        // The memory of a LayeredList.
        struct List {
            explicit List(std::size_t size) : pixels(size), columns(size), shifts(size) {}
            std::vector<std::int32_t> pixels;
            std::vector<float> columns, shifts;

            LayeredList pointers() { return {pixels.data(), columns.data(), shifts.data()}; }
        };

        std::size_t stride; // pixels from part to part
        std::vector<std::int32_t> places, hardColumns, mixed, covers, shares, soft;
        List open[2];
        List hard;
        std::vector<float> shifts; // of the pixels of one part, px

        std::int32_t* placesOf(std::size_t part) { return places.data() + part * stride; }
        std::uint8_t* openBlocks(std::size_t part) {
            return openBlocks_.data() + part * (stride / kBlockPixels);
        }
        const std::uint8_t* openBlocks(std::size_t part) const {
            return openBlocks_.data() + part * (stride / kBlockPixels);
        }
        LayeredRoom pointers() {
            return {places.data(),   {open[0].pointers(), open[1].pointers()},
                    hard.pointers(), hardColumns.data(),
                    mixed.data(),    covers.data(),
                    shares.data()};
        }

      private:
        std::vector<std::uint8_t> openBlocks_; // LayeredPixels::open
    };

    // The entries of a list of pixels, sorted by part.
    class PartOrder {
      public:
        // @param pixels indices in Room::places
        void sort(const std::vector<std::int32_t>& pixels, std::size_t count, std::size_t parts,
                  std::size_t stride);
        const std::size_t* begin(std::size_t part) const { return order_.data() + starts_[part]; }
        const std::size_t* end(std::size_t part) const { return begin(part + 1); }

      private:
        std::vector<std::size_t> starts_; // of each part, and the end
        std::vector<std::size_t> order_;
    };

    // Number of pixels of each part being found.
    std::size_t size() const { return std::min(kPixelsAtATime, columns_.size() - begin_); }

    LayeredLinePixels linePixels(const std::int16_t* shifts) const;
    LayeredPixels pixels(std::size_t part) const;
    // Finds what pixels of open blocks show and lists the others.
    void guess(std::size_t part, LayeredOpenCounts& open);
    // Lists the pixels of one part.
    LayeredOpenCounts listAll(const float* shifts);
    // Finds what the listed pixels show.
    void findEnds(const LayeredOpenCounts& open, std::size_t parts);
    // Leaves listed pixels to LayeredSearch.
    void leaveToSearch(const LayeredList& list, std::size_t size, int direction);
    // Lists the surfaces of both directions as LayeredSurfaces.
    void listSurfaces();
    // LayeredEndOffsets::passing of the last surface. @param begin the first one of its direction
    float passing(std::size_t begin) const;
    // Planes of the row and of the mirrored row, with their last px repeated on both sides, and of
    // the painted strips.
    void splitPlanes();

    // Finds what is behind soft borders at the pixels just found.
    // @param shiftOf(part, pixel) shift of a pixel of a part, px
    template <class F>
    void findBehind(std::size_t parts, const F& shiftOf) {
        behind_.clear();
        behindStarts_.assign(parts + 1, 0);
        if (!soft_.any()) return;
        const auto at = [&](std::size_t part, std::size_t pixel, std::int32_t place) {
            SoftPixel soft = soft_.at(place, columns_[begin_ + pixel], shiftOf(part, pixel));
            soft.pixel = static_cast<std::int32_t>(pixel);
            return soft;
        };
        behindCovers_.resize(counts_.mixed);
        behindHard_.resize(counts_.hard);
        for (std::size_t part = 0; part < parts; ++part) {
            const std::size_t first = part * room_.stride;
            const std::int32_t* const places = room_.places.data() + first;
            const std::size_t count = soft_.find(pixels(part), places, room_.soft.data());
            for (std::size_t i = 0; i < count; ++i)
                behind_.push_back(
                    at(part, static_cast<std::size_t>(room_.soft[i]), places[room_.soft[i]]));
            behindStarts_[part + 1] = behind_.size();
            for (const auto* i = mixedOrder_.begin(part); i < mixedOrder_.end(part); ++i)
                behindCovers_[*i] =
                    at(part, static_cast<std::size_t>(room_.mixed[*i]) - first, room_.covers[*i]);
            for (const auto* i = hardOrder_.begin(part); i < hardOrder_.end(part); ++i) {
                const auto pixel = static_cast<std::size_t>(room_.hard.pixels[*i]) - first;
                for (int k = 0; k < hard_[*i].count; ++k)
                    behindHard_[*i][static_cast<std::size_t>(k)] =
                        at(part, pixel, hard_[*i].place[k]);
            }
        }
    }

    const cv::Mat& photo_;
    const LayeredScene& scene_;
    const std::vector<int>& columns_;
    int row_ = 0;
    bool bounded_ = true;
    LayeredTables tables_;
    LayeredColumns known_;
    LayeredLines<std::int16_t> lines_; // of each pixel's column
    LayeredColumns copies_;            // of each pixel's column, if isPicked_ and not isWholeRow_
    bool isPicked_ = false;
    bool isWholeRow_ = false; // pixels and columns are the same
    std::vector<float> scratch_;
    std::vector<float> columnPlaces_;  // all pixels, see LayeredPixels
    std::vector<std::int32_t> places_; // of their columns
    Room room_;
    LayeredCounts counts_;
    PartOrder mixedOrder_; // of LayeredRoom::mixed
    PartOrder hardOrder_;  // of LayeredRoom::hard
    std::vector<LayeredPixel> hard_;
    SoftBorders soft_;
    std::vector<SoftPixel> behind_; // what is behind pixels at soft borders, part after part,
    std::vector<std::size_t> behindStarts_;
    std::vector<SoftPixel> behindCovers_; // behind LayeredRoom::covers
    std::vector<std::array<SoftPixel, LayeredPixel::kMax>> behindHard_; // and behind those of hard_
    std::size_t begin_ = 0;        // the first pixel being found
    std::vector<LayeredEnd> left_; // see LayeredSurfaces
    std::vector<LayeredEnd> right_;
    std::vector<LayeredEndOffsets> endOffsets_;
    int mirroredSurfaces_ = 0;
    int strips_[2] = {0, 0};
    std::array<std::vector<std::uint8_t>, 3> planes_;
};

} // namespace altiro3D
