#pragma once

#include "base/pixel_rows.hpp"
#include "views/layered/layered_ends.hpp"
#include "views/layered/layered_scene.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace altiro3D {

/// Reads pixels at given places of the photo, one row at a time.
class LayeredReader {
  public:
    /// @param columns, parts as for ViewRenderer::sampler()
    LayeredReader(const cv::Mat& photo, const LayeredScene& scene, const std::vector<int>& columns,
                  const std::vector<std::uint8_t>& parts);

    std::size_t count() const { return columns_.size(); }
    bool still() const { return scene_.flat || scene_.still[static_cast<std::size_t>(row_)] != 0; }
    const std::uint8_t* bgr() const { return photo_.ptr<std::uint8_t>(row_); }

    /// Pixels that are found together. A multiple of kBlockPixels.
    static constexpr std::size_t kPixelsAtATime = 2048;

    void open(int row);

    /// Finds what the pixels show and gives it to read(begin).
    /// @param shifts of the pixels, as for SubpixelSampler::sampleWhole()
    template <class F>
    void find(const std::int16_t* shifts, const F& read) {
        bounded_ = true;
        for (begin_ = 0; begin_ < columns_.size(); begin_ += kPixelsAtATime) {
            clearLists();
            if (layeredLines(linePixels(shifts), room_)) guess();
            findEnds();
            read(begin_);
        }
    }

    /// The same for shifts that may be beyond the reach of the scene, in px.
    template <class F>
    void findAnywhere(const float* shifts, const F& read) {
        bounded_ = false;
        for (begin_ = 0; begin_ < columns_.size(); begin_ += kPixelsAtATime) {
            clearLists();
            listAll(shifts + begin_);
            findEnds();
            read(begin_);
        }
    }

    /// Reads a channel of the pixels just found. @param values of these pixels
    void read(int channel, std::uint8_t* values) const;

  private:
    // Number of pixels being found.
    std::size_t size() const { return std::min(kPixelsAtATime, columns_.size() - begin_); }

    LayeredLinePixels linePixels(const std::int16_t* shifts) const;
    LayeredPixels pixels() const;
    void clearLists();
    // Turns what is known of columns into what is known of the places from each to the next one.
    void joinColumns();
    // Finds what pixels of open blocks show and lists the others.
    void guess();
    // Lists all pixels.
    void listAll(const float* shifts);
    // Finds what the listed pixels show.
    void findEnds();
    // Leaves listed pixels to LayeredSearch.
    void leaveToSearch(int direction);
    // Finds what is behind soft borders.
    void findBehind();
    // Lists the surfaces of both directions as LayeredSurfaces.
    void listSurfaces();
    // LayeredEndOffsets::passing of the last surface. @param begin the first one of its direction
    float passing(std::size_t begin) const;
    // Planes of the row and of the mirrored row, with their last px repeated on both sides, and of
    // the painted strips.
    void splitPlanes();

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
    bool isWholeRow_ = false;         // pixels and columns are the same
    std::vector<std::uint8_t> parts_; // 1/256 px right of the columns; empty if all are at columns
    std::vector<float> scratch_;
    std::vector<float> columnPlaces_;  // all pixels, see LayeredPixels
    std::vector<std::int32_t> places_; // the same, in 1/256 px
    LayeredRoom room_;
    std::vector<LayeredPixel> hard_; // of LayeredRoom::hard
    SoftBorders soft_;
    std::vector<std::int32_t> softPixels_; // at soft borders
    std::vector<SoftPixel> behind_;        // what is behind them,
    std::vector<SoftPixel> behindCovers_;  // behind LayeredRoom::covers
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
