#include "altiro3D/native_renderer.hpp"

#include "checks.hpp"
#include "lens_phase.hpp"
#include "native_lut_tables.hpp"
#include "native_row_kernels.hpp"
#include "text.hpp"
#include "view_renderer.hpp"

#include <array>
#include <cstring>

namespace altiro3D {

namespace {

// The px of a side of the photo under each px of a side of the panel.
std::vector<int> samplesOf(int panel, int photo, bool mirrored) {
    std::vector<int> samples(static_cast<std::size_t>(panel));
    for (int i = 0; i < panel; ++i)
        samples[static_cast<std::size_t>(i)] =
            nearestSample(mirrored ? panel - 1 - i : i, panel, photo);
    return samples;
}

void copyColumns(const std::uint8_t* bgr, const std::vector<int>& columns, std::uint8_t* out) {
    for (const int column : columns) {
        std::memcpy(out, bgr + 3 * static_cast<std::ptrdiff_t>(column), 3);
        out += 3;
    }
}

} // namespace

struct NativeRenderer::Impl {
    LensPhases lens;
    int viewCount;
    ViewOptions options;
    ViewPositions positions;

    cv::Size panelSize() const { return {lens.geometry().panelWidth, lens.geometry().panelHeight}; }
};

NativeRenderer::NativeRenderer(const Calibration& calibration, int viewCount,
                               const ViewOptions& options, ViewPositions positions,
                               InvertViews invert) {
    validate(options);
    check(viewCount >= 1 && viewCount <= kMostViews, "view count",
          "is " + std::to_string(viewCount) + ", expected 1.." + std::to_string(kMostViews));
    check(options.method != ViewMethod::Real, "method",
          "is real, which makes whole views; expected fast or layered, or the way over a quilt");
    impl_ = std::make_shared<const Impl>(
        Impl{LensPhases(lensGeometry(calibration, invert)), viewCount, options, positions});
}

cv::Size NativeRenderer::panelSize() const {
    return impl_->panelSize();
}

int NativeRenderer::viewCount() const {
    return impl_->viewCount;
}

const ViewOptions& NativeRenderer::options() const {
    return impl_->options;
}

void NativeRenderer::render(const cv::Mat& photo, const cv::Mat& depth, cv::Mat& native) const {
    const Impl& self = *impl_;
    const std::unique_ptr<ViewRenderer> renderer = makeRenderer(photo, depth, self.options, 1);
    const LensGeometry& geometry = self.lens.geometry();
    native.create(self.panelSize(), CV_8UC3);
    check(native.data < photo.datastart || native.data >= photo.dataend, "native",
          "shares its memory with the photo, expected a picture of its own");
    const std::vector<int> columns = samplesOf(native.cols, photo.cols, geometry.mirrorX);
    const std::vector<int> rowOf = samplesOf(native.rows, photo.rows, geometry.mirrorY);
    const float halfParallax = halfParallaxOf(self.options, photo.cols);
    const auto width = static_cast<std::size_t>(native.cols);
    cv::parallel_for_(cv::Range(0, native.rows), [&](const cv::Range& rows) {
        const std::unique_ptr<SubpixelSampler> sampler =
            renderer->sampler(columns, static_cast<double>(halfParallax));
        std::vector<std::uint16_t> views = paddedRow<std::uint16_t>(width);
        std::vector<float> shifts = paddedRow<float>(width);
        std::array<std::vector<std::uint8_t>, 3> planes; // blue, green, red
        planes.fill(paddedRow<std::uint8_t>(width));
        int open = -1;
        for (int y = rows.start; y < rows.end; ++y) {
            const int row = rowOf[static_cast<std::size_t>(y)];
            auto* pixels = native.ptr<std::uint8_t>(y);
            if (row != open) sampler->open(row);
            if (sampler->still()) {
                if (row == open && y > rows.start) {
                    std::memcpy(pixels, native.ptr<std::uint8_t>(y - 1), 3 * width);
                } else {
                    copyColumns(photo.ptr<std::uint8_t>(row), columns, pixels);
                }
                open = row;
                continue;
            }
            open = row;
            for (int colour = 0; colour < 3; ++colour) { // red, green, blue
                if (self.positions == ViewPositions::Discrete) {
                    self.lens.viewsOfRow(y, colour, self.viewCount, views.data());
                    shiftsOfViews(views.data(), width, self.viewCount, halfParallax, shifts.data());
                } else {
                    shiftsOfPhases(self.lens.columnPhases(y, colour), self.lens.rowPhase(y, colour),
                                   width, self.viewCount, halfParallax, shifts.data());
                }
                const int channel = 2 - colour;
                sampler->sample(channel, shifts.data(),
                                planes[static_cast<std::size_t>(channel)].data());
            }
            interleaveRow(planes[0].data(), planes[1].data(), planes[2].data(), width, pixels);
        }
    });
}

} // namespace altiro3D
