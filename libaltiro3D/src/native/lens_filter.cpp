#include "native/lens_filter.hpp"

#include "base/pixel_rows.hpp"
#include "base/srgb_light.hpp"
#include "native/lens_filter_kernels.hpp"
#include "views/view_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

constexpr double kPi = 3.14159265358979323846;

// The eye's blur, in lens periods: 2 px for luminance on a Portrait, a fine eye at 50 cm, and 3
// times as much for colour.
constexpr double kEyeLuminance = 1.0 / 3.1;
constexpr double kEyeColour = 3 * kEyeLuminance;
// How much coloured noise counts beside noise of luminance; chosen by lens view
// (docs/lab/views.md).
constexpr double kColourWeight = 1;
constexpr int kReach = 16;         // panel px to each side
constexpr double kNear = 2;        // panel px to each side that bound a result
constexpr int kHarmonics = 8;      // of the panel's sub-pixels; higher ones are too weak to matter
constexpr double kLeastPass = 0.3; // of sampling; what it passes less of is not restored

double sinc(double x) {
    return x == 0 ? 1 : std::sin(kPi * x) / (kPi * x);
}

double squared(double x) {
    return x * x;
}

// What red, green and blue add to a quantity of colour.
using Colours = std::array<double, 3>;

// Luminance, and the two differences of which CIELAB makes a and b, scaled as it does relative to
// its lightness (linear sRGB, D65).
constexpr Colours kLuminance{0.2126729, 0.7151522, 0.0721750};
constexpr Colours kGreenRed{500.0 / 116 * (0.4124564 / 0.95047 - 0.2126729),
                            500.0 / 116 * (0.3575761 / 0.95047 - 0.7151522),
                            500.0 / 116 * (0.1804375 / 0.95047 - 0.0721750)};
constexpr Colours kBlueYellow{200.0 / 116 * (0.2126729 - 0.0193339 / 1.08883),
                              200.0 / 116 * (0.7151522 - 0.1191920 / 1.08883),
                              200.0 / 116 * (0.0721750 - 0.9503041 / 1.08883)};

// The strength of a harmonic of the order in which a panel's sub-pixels have their colours.
double harmonic(const Colours& colours, int k) {
    std::complex<double> sum;
    for (int c = 0; c < 3; ++c)
        sum += colours[static_cast<std::size_t>(c)] * std::polar(1.0, -2 * kPi * k * c / 3);
    return std::abs(sum);
}

// Spectrum of what an eye sees of one direction of a display.
class LensSpectrum {
  public:
    explicit LensSpectrum(const LensGeometry& g)
        : period_(g.lensPeriodSubpixels / 3), slant_(g.tilt * g.panelWidth / g.panelHeight) {
        for (int k = 0; k < 3; ++k) {
            const auto i = static_cast<std::size_t>(k);
            luminance_[i] = squared(harmonic(kLuminance, k));
            colour_[i] = squared(harmonic(kGreenRed, k)) + squared(harmonic(kBlueYellow, k));
        }
    }

    // The filter's best gain for a frequency, in cycles per panel px: (2.10).
    double gain(double fx, double fy) const {
        const double pass = sinc(fx / 3) * sinc(period_ * fx);
        const double wanted = blur(fx, fy, kEyeLuminance);
        const double power = pass * pass * wanted + noise(fx, fy);
        return power > 0 ? pass * wanted / power : 0;
    }

  private:
    // Power that passes an eye's blur.
    double blur(double fx, double fy, double sigmaPeriods) const {
        return std::exp(-squared(2 * kPi * sigmaPeriods * period_) * (fx * fx + fy * fy));
    }

    // Power of what detail of a frequency becomes at other frequencies: (2.8).
    double noise(double fx, double fy) const {
        double sum = 0;
        for (int k = -kHarmonics; k <= kHarmonics; ++k) {
            const auto colour = static_cast<std::size_t>((k % 3 + 3) % 3);
            const double subpixel = squared(sinc((fx + k) / 3));
            const int nearest = static_cast<int>(std::lround(-(fx + k) * period_));
            for (int m = nearest - 2; m <= nearest + 2; ++m) {
                if (k == 0 && m == 0) continue;
                const double gx = fx + k + m / period_;
                double gy = fy - m * slant_ / period_;
                gy -= std::round(gy); // rows are samples as well
                sum += subpixel * squared(sinc(period_ * gx)) *
                       (luminance_[colour] * blur(gx, gy, kEyeLuminance) +
                        kColourWeight * colour_[colour] * blur(gx, gy, kEyeColour));
            }
        }
        return sum;
    }

    double period_; // panel px
    double slant_;  // panel px to the right per row
    Colours luminance_{};
    Colours colour_{};
};

// The i-th of n frequencies of a discrete Fourier transform, in cycles per px.
double frequency(int i, int n) {
    return static_cast<double>(i) / n - (2 * i >= n ? 1 : 0);
}

// Reach in px of a photo, of which `perPixel` panel px show one.
int reachOf(double perPixel) {
    return std::max(1, static_cast<int>(std::ceil(kReach / perPixel)));
}

// Reach of the range that results stay in, px.
int nearOf(double perPixel) {
    return std::max(1, static_cast<int>(std::lround(kNear / perPixel)));
}

// The filter's weights.
// @param perPixel panel px per px of the photo
// @param offset of the place, px of the photo to the right
cv::Mat weightsOf(const cv::Mat& gains, cv::Size2d perPixel, double offset) {
    const cv::Size reach(reachOf(perPixel.width), reachOf(perPixel.height));
    cv::Mat weights(2 * reach.height + 1, 2 * reach.width + 1, CV_64FC1);
    const auto window = [](double at, int size) { return sinc(at / (size + 1)); };
    for (int x = -reach.width; x <= reach.width; ++x) {
        // sums over the frequencies across, for each frequency along
        std::vector<std::complex<double>> across(static_cast<std::size_t>(gains.rows));
        for (int v = 0; v < gains.rows; ++v) {
            for (int u = 0; u < gains.cols; ++u)
                across[static_cast<std::size_t>(v)] +=
                    gains.at<double>(v, u) *
                    std::polar(1.0, 2 * kPi * frequency(u, gains.cols) * (x - offset));
        }
        for (int y = -reach.height; y <= reach.height; ++y) {
            std::complex<double> sum;
            for (int v = 0; v < gains.rows; ++v)
                sum += across[static_cast<std::size_t>(v)] *
                       std::polar(1.0, 2 * kPi * frequency(v, gains.rows) * y);
            weights.at<double>(y + reach.height, x + reach.width) =
                sum.real() * window(x, reach.width) * window(y, reach.height);
        }
    }
    cv::Mat result;
    weights.convertTo(result, CV_32F, 1 / cv::sum(weights)[0]);
    return result;
}

// Rows of one colour as linear light, with the px at the borders repeated.
class LightRows {
  public:
    // @param above rows before the first one of the band @param beside px at each side
    LightRows(int columns, int rows, int above, int beside)
        : above_(above), beside_(beside), columns_(columns),
          stride_(static_cast<std::size_t>(columns + 2 * beside) + 4 * kRowPadding),
          light_(stride_ * static_cast<std::size_t>(rows + 2 * above)) {}

    // Reads rows [from - above, to + above) of a channel.
    void read(const cv::Mat& bgr, int channel, int from, int to) {
        const SrgbLight& srgb = SrgbLight::instance();
        for (int y = from - above_; y < to + above_; ++y) {
            const auto* const pixels =
                bgr.ptr<std::uint8_t>(std::clamp(y, 0, bgr.rows - 1)) + channel;
            float* const out =
                light_.data() + stride_ * static_cast<std::size_t>(y - from + above_);
            for (int x = 0; x < columns_; ++x)
                out[beside_ + x] = srgb.ofCode(pixels[static_cast<std::ptrdiff_t>(3) * x]);
            std::fill_n(out, beside_, out[beside_]);
            std::fill_n(out + beside_ + columns_, beside_, out[beside_ + columns_ - 1]);
        }
    }

    int beside() const { return beside_; }

    // A row of the band, or above (negative) or below it, from the first px beside the left border.
    const float* row(int y) const {
        return light_.data() + stride_ * static_cast<std::size_t>(y + above_);
    }

  private:
    int above_, beside_, columns_;
    std::size_t stride_;
    std::vector<float> light_;
};

// The least and the most light around each px of a row.
class Ranges {
  public:
    // @param reach px to each side
    Ranges(cv::Size reach, int columns)
        : reach_(reach), least_(static_cast<std::size_t>(columns + 2 * reach.width)), most_(least_),
          leastAround_(static_cast<std::size_t>(columns)), mostAround_(leastAround_) {}

    void read(const LightRows& light, int y, int columns) {
        const auto width = least_.size();
        const auto rowAt = [&](int row) { return light.row(row) + light.beside() - reach_.width; };
        std::copy_n(rowAt(y), width, least_.begin());
        most_ = least_;
        for (int k = -reach_.height; k <= reach_.height; ++k) {
            const float* const row = rowAt(y + k);
            for (std::size_t x = 0; x < width; ++x) {
                least_[x] = std::min(least_[x], row[x]);
                most_[x] = std::max(most_[x], row[x]);
            }
        }
        const auto count = static_cast<std::size_t>(columns);
        std::copy_n(least_.begin(), count, leastAround_.begin());
        std::copy_n(most_.begin(), count, mostAround_.begin());
        for (std::size_t k = 1; k <= static_cast<std::size_t>(2 * reach_.width); ++k) {
            for (std::size_t x = 0; x < count; ++x) {
                leastAround_[x] = std::min(leastAround_[x], least_[x + k]);
                mostAround_[x] = std::max(mostAround_[x], most_[x + k]);
            }
        }
    }

    float clamp(float value, std::size_t x) const {
        return std::clamp(value, leastAround_[x], mostAround_[x]);
    }

  private:
    cv::Size reach_;
    std::vector<float> least_, most_; // of columns, in the rows around
    std::vector<float> leastAround_, mostAround_;
};

} // namespace

LensFilter::LensFilter(const LensGeometry& geometry, cv::Size size) {
    const LensSpectrum spectrum(geometry);
    const cv::Size2d perPixel(static_cast<double>(geometry.panelWidth) / size.width,
                              static_cast<double>(geometry.panelHeight) / size.height);
    // an enlarged photo has no other frequencies
    const cv::Size2d step(std::max(perPixel.width, 1.0), std::max(perPixel.height, 1.0));
    cv::Mat gains(4 * reachOf(step.height), 4 * reachOf(step.width), CV_64FC1);
    for (int v = 0; v < gains.rows; ++v) {
        for (int u = 0; u < gains.cols; ++u) {
            const double fx = frequency(u, gains.cols) * (geometry.mirrorX ? -1 : 1);
            const double fy = frequency(v, gains.rows) * (geometry.mirrorY ? -1 : 1);
            // the average over a px when the photo is shrunk, then linear sampling across and
            // repeated px along
            const double across = perPixel.width > 1 ? sinc(fx) : 1;
            const double along = perPixel.height > 1 ? sinc(fy) : 1;
            gains.at<double>(v, u) = spectrum.gain(fx / step.width, fy / step.height) /
                                     std::max(squared(across * along) * across, kLeastPass);
        }
    }
    near_ = {nearOf(step.width), nearOf(step.height)};
    for (int c = 0; c < 3; ++c) {
        double offset = geometry.cells.empty() ? (c - 1) / 3.0 / step.width : 0;
        if (geometry.blueFirst != geometry.mirrorX) offset = -offset;
        weights_[static_cast<std::size_t>(c)] = weightsOf(gains, step, offset);
    }
}

void LensFilter::filterRows(const cv::Mat& photo, const cv::Range& rows, cv::Mat& filtered) const {
    constexpr int kBand = 32;
    const cv::Size reach(weights_[0].cols / 2, weights_[0].rows / 2);
    LightRows light(photo.cols, kBand, reach.height, reach.width);
    Ranges ranges(near_, photo.cols);
    std::vector<const float*> taps(static_cast<std::size_t>(weights_[0].rows));
    std::vector<float> sums = paddedRow<float>(static_cast<std::size_t>(photo.cols) + kRowPadding);
    const SrgbLight& srgb = SrgbLight::instance();
    for (int from = rows.start; from < rows.end; from += kBand) {
        const int to = std::min(from + kBand, rows.end);
        for (int channel = 0; channel < 3; ++channel) {
            light.read(photo, channel, from, to);
            for (int y = 0; y < to - from; ++y) {
                for (int k = 0; k < weights_[0].rows; ++k)
                    taps[static_cast<std::size_t>(k)] = light.row(y + k - reach.height);
                weightedSums(taps.data(), weights(2 - channel),
                             static_cast<std::size_t>(photo.cols), sums.data());
                ranges.read(light, y, photo.cols);
                auto* const out = filtered.ptr<std::uint8_t>(from + y) + channel;
                for (int x = 0; x < photo.cols; ++x) {
                    const float sum = ranges.clamp(sums[static_cast<std::size_t>(x)],
                                                   static_cast<std::size_t>(x));
                    out[static_cast<std::ptrdiff_t>(3) * x] = srgb.code(sum);
                }
            }
        }
    }
}

void LensFilter::apply(const cv::Mat& photo, cv::Mat& filtered) const {
    filtered.create(photo.size(), CV_8UC3);
    forRows(photo.rows, [&](const cv::Range& rows) { filterRows(photo, rows, filtered); });
}

} // namespace altiro3D
