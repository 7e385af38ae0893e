#include "native/lens_filter.hpp"

#include "base/pixel_rows.hpp"
#include "base/srgb_light.hpp"
#include "native/lens_filter_kernels.hpp"
#include "views/view_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numeric>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D {

namespace {

// Luminance blur of an eye in lens periods: 2 px on a Portrait, a fine eye at 50 cm. Colour is
// blurred 3 times as far.
constexpr double kEyeLuminance = 1.0 / 3.1;
// How much coloured noise counts beside noise of luminance; chosen by lens view
// (docs/lab/views.md).
constexpr double kColourWeight = 1;
constexpr int kReach = 16;            // panel px to each side
constexpr double kNear = 2;           // panel px to each side that bound a result
constexpr int kHarmonics = 8;         // sub-pixel harmonics; higher ones are too weak to matter
constexpr double kLeastPass = 0.3;    // gain of sampling; frequencies below it are not restored
constexpr double kLeastPower = 1e-12; // what has less is left out
// Largest error of the products (root of the sum of squares): this share of noise is wrong.
constexpr double kLeftOut = 4e-3;

double sinc(double x) {
    return x == 0 ? 1 : std::sin(CV_PI * x) / (CV_PI * x);
}

double squared(double x) {
    return x * x;
}

// Weights of red, green and blue in a quantity of colour, such as luminance.
using Colours = std::array<double, 3>;

// Luminance, and the two differences from which CIELAB makes a and b, scaled relative to its
// lightness as CIELAB scales them (linear sRGB, D65).
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
        sum += colours[static_cast<std::size_t>(c)] * std::polar(1.0, -2 * CV_PI * k * c / 3);
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

    // Sets the frequency across, in cycles per panel px.
    void setAcross(double fx) {
        pass_ = sinc(fx / 3) * sinc(period_ * fx);
        wanted_ = blur(fx);
        aliases_.clear();
        for (int k = -kHarmonics; k <= kHarmonics; ++k) {
            const auto colour = static_cast<std::size_t>((k % 3 + 3) % 3);
            const double subpixel = squared(sinc((fx + k) / 3));
            const int nearest = static_cast<int>(std::lround(-(fx + k) * period_));
            for (int m = nearest - 2; m <= nearest + 2; ++m) {
                if (k == 0 && m == 0) continue;
                const double gx = fx + k + m / period_;
                const double power = subpixel * squared(sinc(period_ * gx));
                const double seen = blur(gx);
                const Alias alias{power * luminance_[colour] * seen,
                                  power * colour_[colour] * kColourWeight * ofColour(seen),
                                  m * slant_ / period_};
                if (std::max(alias.luminance, alias.colour) > kLeastPower)
                    aliases_.push_back(alias);
            }
        }
    }

    // The filter's best gain for frequency fy down and the one given to setAcross(): (2.10).
    double gain(double fy) const {
        const double wanted = wanted_ * blur(fy);
        const double power = pass_ * pass_ * wanted + noise(fy);
        return power > 0 ? pass_ * wanted / power : 0;
    }

  private:
    // The part of detail that appears at another frequency: (2.8).
    struct Alias {
        double luminance; // power that passes an eye's blur across
        double colour;
        double down; // difference of the two frequencies down
    };

    // Power of luminance that passes an eye's blur in one direction.
    double blur(double f) const {
        return std::exp(-squared(2 * CV_PI * kEyeLuminance * period_ * f));
    }

    // The same for colour, which is blurred by 3 kEyeLuminance.
    static double ofColour(double blur) {
        const double cube = blur * blur * blur;
        return cube * cube * cube;
    }

    // Power of what detail becomes.
    double noise(double fy) const {
        double sum = 0;
        for (const Alias& alias : aliases_) {
            double gy = fy - alias.down;
            gy -= std::round(gy); // rows are samples as well
            const double seen = blur(gy);
            sum += alias.luminance * seen + alias.colour * ofColour(seen);
        }
        return sum;
    }

    double period_; // panel px
    double slant_;  // panel px to the right per row
    Colours luminance_{};
    Colours colour_{};
    // values for the frequency across
    double pass_ = 0;
    double wanted_ = 0;
    std::vector<Alias> aliases_;
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

// The strongest product of a column and a row in a matrix, by power iteration. Plain loops give the
// same on any processor.
void strongestProduct(const cv::Mat& matrix, std::vector<double>& column,
                      std::vector<double>& row) {
    constexpr int kIterations = 30;
    const auto squares = [](const std::vector<double>& values) {
        return std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
    };
    const auto project = [&squares](const cv::Mat& from, const std::vector<double>& on,
                                    std::vector<double>& to) {
        const double scale = 1 / squares(on);
        to.resize(static_cast<std::size_t>(from.rows));
        for (int y = 0; y < from.rows; ++y)
            to[static_cast<std::size_t>(y)] =
                scale * std::inner_product(on.begin(), on.end(), from.ptr<double>(y), 0.0);
    };
    const cv::Mat transposed = matrix.t();
    row.assign(static_cast<std::size_t>(matrix.cols), 0);
    for (int y = 0; y < matrix.rows; ++y) { // begins with the strongest row
        const std::vector<double> own(matrix.ptr<double>(y), matrix.ptr<double>(y) + matrix.cols);
        if (squares(own) > squares(row)) row = own;
    }
    for (int i = 0; i < kIterations; ++i) {
        project(matrix, row, column);
        project(transposed, column, row);
    }
    project(matrix, row, column);
}

// Weights as a sum of products, with an error of at most kLeftOut. @param left [rows x cols,
// CV_64FC1], sum 1
SeparableWeights separated(cv::Mat left) {
    SeparableWeights weights;
    std::vector<double> column;
    std::vector<double> row;
    double sum = 0;
    for (double leftOut = 1; leftOut > squared(kLeftOut);) {
        strongestProduct(left, column, row);
        leftOut = 0;
        for (int y = 0; y < left.rows; ++y) {
            for (int x = 0; x < left.cols; ++x) {
                const double part =
                    column[static_cast<std::size_t>(y)] * row[static_cast<std::size_t>(x)];
                sum += part;
                leftOut += squared(left.at<double>(y, x) -= part);
            }
        }
        weights.columns.push_back(cv::Mat(column, true));
        weights.rows.push_back(cv::Mat(row).t());
    }
    for (cv::Mat& part : weights.columns)
        part.convertTo(part, CV_32F, 1 / sum);
    weights.rows.convertTo(weights.rows, CV_32F);
    return weights;
}

// The filter's weights.
// @param perPixel panel px per px of the photo
// @param offset of the place, px of the photo to the right
SeparableWeights weightsOf(const cv::Mat& gains, cv::Size2d perPixel, double offset) {
    const cv::Size reach(reachOf(perPixel.width), reachOf(perPixel.height));
    cv::Mat weights(2 * reach.height + 1, 2 * reach.width + 1, CV_64FC1);
    const auto window = [](double at, int size) { return sinc(at / (size + 1)); };
    using Waves = std::vector<std::complex<double>>; // values of all frequencies
    const auto wavesAt = [](double place, int count) {
        Waves waves;
        for (int i = 0; i < count; ++i)
            waves.push_back(std::polar(1.0, 2 * CV_PI * frequency(i, count) * place));
        return waves;
    };
    std::vector<Waves> down;
    for (int y = -reach.height; y <= reach.height; ++y)
        down.push_back(wavesAt(y, gains.rows));
    Waves across(static_cast<std::size_t>(gains.rows)); // sums, for each frequency along
    for (int x = 0; x < weights.cols; ++x) {
        const Waves waves = wavesAt(x - reach.width - offset, gains.cols);
        for (int v = 0; v < gains.rows; ++v)
            across[static_cast<std::size_t>(v)] = std::inner_product(
                waves.begin(), waves.end(), gains.ptr<double>(v), std::complex<double>());
        for (int y = 0; y < weights.rows; ++y) {
            const Waves& wave = down[static_cast<std::size_t>(y)];
            const auto sum = std::inner_product(across.begin(), across.end(), wave.begin(),
                                                std::complex<double>());
            weights.at<double>(y, x) = sum.real() * window(x - reach.width, reach.width) *
                                       window(y - reach.height, reach.height);
        }
    }
    return separated(weights / cv::sum(weights)[0]);
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

// Weighted sums of the light around each px of a row.
class Sums {
  public:
    // @param reach px to each side
    Sums(cv::Size reach, int columns)
        : reach_(reach), width_(static_cast<std::size_t>(columns)),
          taps_(static_cast<std::size_t>(2 * reach.height + 1)), sums_(width_ + kRowPadding) {}

    void read(const LightRows& light, int y, const SeparableWeights& weights) {
        for (int k = -reach_.height; k <= reach_.height; ++k)
            taps_[static_cast<std::size_t>(k + reach_.height)] = light.row(y + k);
        const auto around = width_ + static_cast<std::size_t>(2 * reach_.width);
        const std::size_t stride = around + 2 * kRowPadding;
        parts_.resize(weights.columns.size() * stride);
        partRows_.clear();
        for (std::size_t i = 0; i < weights.columns.size(); ++i)
            partRows_.push_back(parts_.data() + i * stride);
        constexpr std::size_t kAtATime = 128; // px; those of all rows fit into the nearest cache
        for (std::size_t x = 0; x < around; x += kAtATime) {
            const std::size_t count = std::min(kAtATime, around - x);
            for (std::size_t i = 0; i < weights.columns.size(); ++i)
                weightedSums(taps_.data(), weights.columns[i], count,
                             parts_.data() + i * stride + x);
            for (const float*& tap : taps_)
                tap += kAtATime;
        }
        weightedSums(partRows_.data(), weights.rows, width_, sums_.data());
    }

    float of(std::size_t x) const { return sums_[x]; }

  private:
    cv::Size reach_;
    std::size_t width_;
    std::vector<const float*> taps_;
    std::vector<float> parts_; // sums over columns, a row for each product
    std::vector<const float*> partRows_;
    std::vector<float> sums_;
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
    std::vector<float> least_, most_; // extremes of columns, in the rows around
    std::vector<float> leastAround_, mostAround_;
};

} // namespace

LensFilter::LensFilter(const LensGeometry& geometry, cv::Size size) {
    LensSpectrum spectrum(geometry);
    const cv::Size2d perPixel(static_cast<double>(geometry.panelWidth) / size.width,
                              static_cast<double>(geometry.panelHeight) / size.height);
    // an enlarged photo has no other frequencies
    const cv::Size2d step(std::max(perPixel.width, 1.0), std::max(perPixel.height, 1.0));
    cv::Mat gains(4 * reachOf(step.height), 4 * reachOf(step.width), CV_64FC1);
    for (int u = 0; u < gains.cols; ++u) {
        const double fx = frequency(u, gains.cols) * (geometry.mirrorX ? -1 : 1);
        spectrum.setAcross(fx / step.width);
        for (int v = 0; v < gains.rows; ++v) {
            const double fy = frequency(v, gains.rows) * (geometry.mirrorY ? -1 : 1);
            // the average over a px when the photo is shrunk, then linear sampling across and
            // repeated px along
            const double across = perPixel.width > 1 ? sinc(fx) : 1;
            const double along = perPixel.height > 1 ? sinc(fy) : 1;
            gains.at<double>(v, u) = spectrum.gain(fy / step.height) /
                                     std::max(squared(across * along) * across, kLeastPass);
        }
    }
    reach_ = {reachOf(step.width), reachOf(step.height)};
    near_ = {nearOf(step.width), nearOf(step.height)};
    for (int c = 0; c < 3; ++c) {
        double offset = geometry.cells.empty() ? (c - 1) / 3.0 / step.width : 0;
        if (geometry.blueFirst != geometry.mirrorX) offset = -offset;
        weights_[static_cast<std::size_t>(c)] = weightsOf(gains, step, offset);
    }
}

void LensFilter::filterRows(const cv::Mat& photo, const cv::Range& rows, cv::Mat& filtered) const {
    constexpr int kBand = 32;
    LightRows light(photo.cols, kBand, reach_.height, reach_.width);
    Ranges ranges(near_, photo.cols);
    Sums sums(reach_, photo.cols);
    const SrgbLight& srgb = SrgbLight::instance();
    for (int from = rows.start; from < rows.end; from += kBand) {
        const int to = std::min(from + kBand, rows.end);
        for (int channel = 0; channel < 3; ++channel) {
            light.read(photo, channel, from, to);
            for (int y = 0; y < to - from; ++y) {
                sums.read(light, y, weights(2 - channel));
                ranges.read(light, y, photo.cols);
                auto* const out = filtered.ptr<std::uint8_t>(from + y) + channel;
                for (int x = 0; x < photo.cols; ++x) {
                    const auto i = static_cast<std::size_t>(x);
                    out[3 * i] = srgb.code(ranges.clamp(sums.of(i), i));
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
