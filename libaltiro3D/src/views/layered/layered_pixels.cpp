#include "views/layered/layered_pixels.hpp"

#include "views/layered/layered_scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

constexpr float kLeastShare = 1.0F / 16; // of a px; less is not seen

// Collects the px of a scene, row by row.
class PixelLister {
  public:
    PixelLister(const cv::Mat& photo, const LayeredScene& scene, double focus, double tear)
        : photo_(photo), scene_(scene), focus_(static_cast<float>(focus)),
          tear_(static_cast<float>(tear)) {}

    void listRow(int y, std::vector<LayeredPixel>& pixels) const {
        const auto row = static_cast<std::size_t>(y);
        const std::vector<LayeredSurface>& surfaces = scene_.rows[0][row].surfaces;
        for (std::size_t i = 0; i < surfaces.size(); ++i) {
            const LayeredSurface& surface = surfaces[i];
            for (int x = surface.first; x <= surface.last; ++x)
                pixels.push_back(visible(y, x, i));
            // a border that covers a part of a mixed px
            addBorder(y, surface.first, -1, surface.leftExtra, pixels);
            addBorder(y, surface.last, 1, surface.rightExtra, pixels);
        }
        for (const int direction : {0, 1})
            for (const LayeredSurface& surface : scene_.rows[direction][row].surfaces)
                addHidden(y, direction, surface, pixels);
    }

  private:
    // @param direction 1: x counts from the right
    float depthAt(int y, int x, int direction = 0) const {
        const std::int16_t* const words =
            scene_.words.ptr<std::int16_t>(y) + kTablePadding + direction * scene_.stride();
        return focus_ + scene_.scale * static_cast<float>(wordOffset(words[x]));
    }

    // The larger of two steps, so that px that move apart are covered.
    float slope(float before, float here, float after) const {
        float largest = 0;
        for (const float step : {here - before, after - here}) // NaN: there is none
            if (std::abs(step) <= tear_ && std::abs(step) > std::abs(largest)) largest = step;
        return largest;
    }

    LayeredPixel pixelAt(int y, int x) const {
        LayeredPixel pixel;
        pixel.x = x;
        pixel.y = y;
        pixel.depth = depthAt(y, x);
        std::memcpy(pixel.bgr, photo_.ptr(y, x), 3);
        return pixel;
    }

    // A px of surface i.
    LayeredPixel visible(int y, int x, std::size_t i) const {
        const std::vector<LayeredSurface>& surfaces =
            scene_.rows[0][static_cast<std::size_t>(y)].surfaces;
        const LayeredSurface& surface = surfaces[i];
        LayeredPixel pixel = pixelAt(y, x);
        pixel.isLast = x == surface.last;
        const float none = std::nanf("");
        pixel.across = slope(x > surface.first ? depthAt(y, x - 1) : none, pixel.depth,
                             x < surface.last ? depthAt(y, x + 1) : none);
        pixel.down = slope(y > 0 ? depthAt(y - 1, x) : none, pixel.depth,
                           y + 1 < photo_.rows ? depthAt(y + 1, x) : none);
        if (scene_.shares.empty()) return pixel;
        const int behind = scene_.shares.at<std::uint8_t>(y, x);
        if (behind == 0) return pixel;
        // the px shows both: takes out the colour of what is behind
        const std::uint8_t* colour = nullptr;
        const LayeredRow& rightwards = scene_.rows[0][static_cast<std::size_t>(y)];
        const LayeredRow& leftwards = scene_.rows[1][static_cast<std::size_t>(y)];
        if (x > surface.last - surface.softRight && i + 1 < surfaces.size()) {
            colour = hiddenColour(rightwards, rightwards.surfaces[i + 1],
                                  rightwards.surfaces[i + 1].first - x);
        } else if (x < surface.first + surface.softLeft && i > 0) {
            const LayeredSurface& other = leftwards.surfaces[surfaces.size() - i];
            colour = hiddenColour(leftwards, other, other.first - (scene_.width - 1 - x));
        }
        if (colour == nullptr) return pixel;
        pixel.share = std::max(1 - static_cast<float>(behind) / 256, kLeastShare);
        for (int c = 0; c < 3; ++c) {
            const float own = static_cast<float>(pixel.bgr[c]) -
                              (1 - pixel.share) * static_cast<float>(colour[c]);
            pixel.bgr[c] = cv::saturate_cast<std::uint8_t>(own / pixel.share);
        }
        return pixel;
    }

    // The painted colour k columns behind the border of a surface; null if none is painted there.
    static const std::uint8_t* hiddenColour(const LayeredRow& row, const LayeredSurface& surface,
                                            int k) {
        return k >= 1 && k <= surface.hidden
                   ? row.strips.data() + 4 * static_cast<std::ptrdiff_t>(surface.hiddenAt(k))
                   : nullptr;
    }

    void addBorder(int y, int end, int outwards, float extra,
                   std::vector<LayeredPixel>& pixels) const {
        const int x = end + outwards;
        if (extra < kLeastShare || x < 0 || x >= photo_.cols) return;
        LayeredPixel pixel = pixelAt(y, end);
        pixel.x = x;
        pixel.beside = outwards;
        pixel.share = extra;
        pixels.push_back(pixel);
    }

    void addHidden(int y, int direction, const LayeredSurface& surface,
                   std::vector<LayeredPixel>& pixels) const {
        const LayeredRow& row = scene_.rows[direction][static_cast<std::size_t>(y)];
        LayeredPixel pixel;
        pixel.y = y;
        pixel.isHidden = true;
        pixel.width = surface.last - surface.first + 1;
        const auto add = [&](int x, int beside, int cell) {
            pixel.x = direction == 0 ? x : photo_.cols - 1 - x;
            pixel.beside = direction == 0 ? beside : -beside;
            std::memcpy(pixel.bgr, row.strips.data() + 4 * static_cast<std::ptrdiff_t>(cell), 3);
            pixels.push_back(pixel);
        };
        pixel.depth = depthAt(y, surface.first, direction);
        for (int k = 1; k <= surface.hidden; ++k)
            add(surface.first - k, -k, surface.hiddenAt(k));
        if (surface.last + 1 < photo_.cols) return; // the other direction has what is hidden there
        pixel.depth = depthAt(y, surface.last, direction);
        for (int k = 1; k <= surface.beyond; ++k)
            add(surface.last + k, k, surface.beyondAt(k));
    }

    const cv::Mat& photo_;
    const LayeredScene& scene_;
    float focus_;
    float tear_;
};

} // namespace

std::vector<LayeredPixel> layeredPixels(const cv::Mat& photo, const cv::Mat& depth, double focus,
                                        const LayeredSettings& options) {
    const LayeredScene scene =
        layeredScene(photo, withoutLevels(depth, options.reachPixels), focus, options);
    std::vector<LayeredPixel> pixels;
    if (scene.flat) {
        for (int y = 0; y < photo.rows; ++y)
            for (int x = 0; x < photo.cols; ++x) {
                LayeredPixel pixel;
                pixel.x = x;
                pixel.y = y;
                pixel.depth = static_cast<float>(focus);
                std::memcpy(pixel.bgr, photo.ptr(y, x), 3);
                pixels.push_back(pixel);
            }
        return pixels;
    }
    const PixelLister lister(photo, scene, focus, options.tearStep());
    for (int y = 0; y < photo.rows; ++y)
        lister.listRow(y, pixels);
    return pixels;
}

} // namespace altiro3D
