#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/quilt.hpp"

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

// The published method, written as fast as OpenCV allows: for each view a map x + p (depth - focus)
// S/2 and a linear cv::remap directly into its tile, in parallel over the views; then the look-up
// table, in parallel over the rows. All memory is allocated before.
class PaperPipeline {
  public:
    PaperPipeline(const altiro3D::QuiltLayout& layout, const altiro3D::NativeLut& lut)
        : layout_(layout), lut_(lut), quilt_(layout.size(), CV_8UC3, cv::Scalar::all(0)),
          native_(lut.channel(0).size(), CV_8UC3),
          mapsX_(static_cast<std::size_t>(layout.viewCount)), mapY_(layout.tileSize, CV_32FC1),
          sourceRows_(static_cast<std::size_t>(quilt_.rows)) {
        for (cv::Mat& map : mapsX_)
            map.create(layout.tileSize, CV_32FC1);
        for (int y = 0; y < quilt_.rows; ++y)
            sourceRows_[static_cast<std::size_t>(y)] = quilt_.ptr(y);
    }

    static double shiftPixels(const altiro3D::QuiltLayout& layout, int view) {
        const altiro3D::ViewOptions options;
        return altiro3D::viewPosition(view, layout.viewCount) * options.strengthPercent / 100 *
               layout.tileSize.width / 2;
    }

    // photo [tile's size, CV_8UC3], depth [tile's size, CV_32FC1]
    void run(const cv::Mat& photo, const cv::Mat& depth) {
        makeViews(photo, depth);
        mapToNative();
    }

    const cv::Mat& quilt() const { return quilt_; }
    const cv::Mat& native() const { return native_; }

  private:
    void makeViews(const cv::Mat& photo, const cv::Mat& depth) {
        const auto focus = static_cast<float>(altiro3D::ViewOptions().focus);
        for (int y = 0; y < mapY_.rows; ++y)
            mapY_.row(y).setTo(y);
        cv::parallel_for_(cv::Range(0, layout_.viewCount), [&](const cv::Range& views) {
            for (int view = views.start; view < views.end; ++view) {
                const auto shift = static_cast<float>(shiftPixels(layout_, view));
                cv::Mat& map = mapsX_[static_cast<std::size_t>(view)];
                for (int y = 0; y < map.rows; ++y) {
                    auto* to = map.ptr<float>(y);
                    const auto* d = depth.ptr<float>(y);
                    for (int x = 0; x < map.cols; ++x)
                        to[x] = static_cast<float>(x) + shift * (d[x] - focus);
                }
                cv::Mat tile = quilt_(layout_.tile(view));
                cv::remap(photo, tile, map, mapY_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
            }
        });
    }

    void mapToNative() {
        const std::uint8_t* const* rowOf = sourceRows_.data();
        cv::parallel_for_(cv::Range(0, native_.rows), [&](const cv::Range& rows) {
            for (int y = rows.start; y < rows.end; ++y) {
                std::uint8_t* out = native_.ptr(y);
                const auto* red = lut_.channel(0).ptr<std::uint16_t>(y);
                const auto* green = lut_.channel(1).ptr<std::uint16_t>(y);
                const auto* blue = lut_.channel(2).ptr<std::uint16_t>(y);
                for (int i = 0; i < 2 * native_.cols; i += 2, out += 3) {
                    out[0] = rowOf[blue[i + 1]][3 * blue[i]];
                    out[1] = rowOf[green[i + 1]][3 * green[i] + 1];
                    out[2] = rowOf[red[i + 1]][3 * red[i] + 2];
                }
            }
        });
    }

    altiro3D::QuiltLayout layout_;
    const altiro3D::NativeLut& lut_;
    cv::Mat quilt_;
    cv::Mat native_;
    std::vector<cv::Mat> mapsX_; // one per view
    cv::Mat mapY_;
    std::vector<const std::uint8_t*> sourceRows_;
};
